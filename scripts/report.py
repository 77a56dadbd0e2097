#!/usr/bin/python3
"""One page about a verification run: reads the result files of a folder, writes a self-contained HTML file.

Verdicts were computed by veriflex; here they are only shown.
"""

import argparse
import concurrent.futures
import fcntl
import json
import math
import os
import re
import shlex
import stat
import sys
from collections import Counter
from pathlib import Path

import jinja2
from markupsafe import Markup

from report import bond, cost, drawing, figures, leave_out, results, stability, studies

WRITTEN, USAGE, UNWRITABLE = 0, 2, 4
SMALL_ROWS = 20  # records of at most that many rows are shown as tables
PRINTED = 10  # a target of at most that many digits counts as a printed number
MARKS = {"pass": "✓", "fail": "✗", "error": "!", "finding": "◇", "measured": "·"}
# As what a statement of the paper is marked, by its standing.
STANDING_MARKS = {
    "holds": "pass",
    "refuted in part": "finding",
    "refuted": "finding",
    "not decidable": "",
    "not run": "",
    "unsettled": "fail",
}


def powers_of_ten(mantissa, exponent):
    return Markup('{}<span class="times">×</span>10<sup>{}</sup>').format(mantissa, str(exponent).replace("-", "−"))


def unusual(value):
    """Text of a number that has no digits, None for all others."""
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    return "0" if value == 0 else None


def exponent_of(value):
    """Decimal exponent of a finite number other than zero."""
    return int(f"{value:e}".split("e")[1])


def grouped(text, alike):
    """Digits, many decimals in groups set apart by style so that a copy has no spaces; those after `alike` bold."""
    whole, point, decimals = text.partition(".")
    size = 3 if len(decimals) > 4 else 4
    pieces, place = [], 0
    groups = [decimals[start : start + size] for start in range(0, len(decimals), size)]
    for group in [whole + point, *groups]:
        same = max(0, min(alike - place, len(group)))
        different = Markup("<b>{}</b>").format(group[same:]) if group[same:] else ""
        pieces.append(Markup("<span>{}{}</span>").format(group[:same], different))
        place += len(group)
    return Markup('<span class="digits">{}</span>').format(Markup("").join(pieces))


def numeral(value, digits=6):
    """Number with that many significant digits, trailing zeros dropped; the title says it in full."""
    text = unusual(value)
    if text is None:
        exponent = exponent_of(value)
        if -4 <= exponent < 6:
            text = f"{value:.{max(digits - 1 - exponent, 0)}f}"
            text = (text.rstrip("0").rstrip(".") if "." in text else text).replace("-", "−")
        else:
            mantissa = f"{value:.{digits - 1}e}".split("e")[0]
            mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
            text = powers_of_ten(mantissa.replace("-", "−"), exponent)
    return Markup('<span class="n" title="{}">{}</span>').format(repr(float(value)), text)


def stated_digits(value):
    """Significant digits of the shortest decimal number that is this double."""
    return len(repr(float(value)).split("e")[0].replace(".", "").strip("-0"))


def side_by_side(measured, target, tolerance):
    """Measured and target with as many digits as show how they differ, or the tolerance; differing digits are bold.

    A target of few digits, such as a printed one, is shown as it was stated.
    """
    plain = numeral(measured, 4), numeral(target, 4)
    if unusual(measured) or unusual(target):
        return plain
    scale = max(abs(measured), abs(target))
    apart = abs(measured - target) or abs(tolerance)
    if not math.isfinite(apart) or apart > 0.1 * scale:
        return plain
    stated = stated_digits(target)
    digits = max(math.ceil(math.log10(scale / apart)) + 2 if apart else 17, 4, stated if stated <= PRINTED else 0)
    digits = min(digits, max(stated_digits(measured), stated, 4))
    exponent = exponent_of(scale)
    shift = 0 if -4 <= exponent < 6 else exponent
    decimals = max(digits - 1 - (exponent - shift), 0)
    texts = [f"{value / 10.0**shift if shift else value:.{decimals}f}" for value in (measured, target)]
    alike = len(os.path.commonprefix(texts)) if texts[0] != texts[1] else len(texts[0])
    if stated <= PRINTED and "." in texts[1]:
        texts[1] = texts[1].rstrip("0").rstrip(".")
    shown = []
    for value, text in zip((measured, target), texts):
        body = grouped(text.replace("-", "−"), alike)
        body = powers_of_ten(body, shift) if shift else body
        shown.append(Markup('<span class="n" title="{}">{}</span>').format(repr(float(value)), body))
    return tuple(shown)


def badge(verdict, text=None):
    """Verdict as mark and word: colour alone says nothing."""
    return Markup('<span class="verdict {}"><span aria-hidden="true">{}</span> {}</span>').format(
        verdict, MARKS.get(verdict, "?"), text or verdict
    )


def seconds(value):
    """Duration in words of the right size."""
    if value < 1e-3:
        return f"{value * 1e6:.0f} µs"
    if value < 1:
        return f"{value * 1e3:.3g} ms"
    return f"{value:.3g} s" if value < 120 else f"{value / 60:.3g} min"


def memory(count):
    """Bytes in words of the right size."""
    for unit in ("B", "KiB", "MiB"):
        if count < 1024:
            return f"{count:.4g} {unit}"
        count /= 1024
    return f"{count:.4g} GiB"


def anchor(result):
    """Name of a case's section; from the file's name, which is unique in a folder."""
    return "case-" + re.sub(r"[^A-Za-z0-9_-]", "-", result.file.stem)


def wall_seconds(result):
    return sum(row["wall_seconds"] for row in result.timing)


def passed(result):
    return sum(check.verdict == "pass" for check in result.checks)


def worst_margin(result):
    """Largest margin, None without any; without refuted claims, which are beyond their tolerance by nature."""
    margins = [check.margin for check in result.checks if check.verdict != "finding"]
    return max(margins, key=lambda margin: math.inf if math.isnan(margin) else margin, default=None)


def dimension_of(result, name):
    """Dimension of a metric, empty for a number."""
    stated = next((metric.dimension for metric in result.metrics if metric.name == name), "")
    return "" if stated == "1" else stated


def rerun(result):
    """Command that makes the result again."""
    words = ["veriflex", "run", result.case_path or result.case_id]
    for override in result.overrides:
        words += ["--set", override]
    return shlex.join(words)


def small_records(result):
    """Records short enough to be read, without those that the page shows in a form of their own."""
    return [
        record
        for record in result.records.values()
        if record.name not in figures.KINDS and 0 < len(record) <= SMALL_ROWS
    ]


def as_they_stand(results_read):
    """The results of cases that no --set has changed: only these are counted."""
    return [result for result in results_read if not result.variant]


def ledger_rows(claims, results_read):
    """Entries of the ledger (`veriflex claims --json`), each judgement with the result it stands in, if any.

    None when no case judged any of them: a user's own cases get a report without the paper.
    """
    if all(entry["standing"] in ("not run", "not decidable") for entry in claims):
        return []
    by_id = {result.id: result for result in results_read}
    return [
        entry | {"judgements": [found | {"result": by_id.get(found["case"])} for found in entry["judgements"]]}
        for entry in claims
    ]


def standings_in_words(counts):
    """How many statements of the paper stand how, in one line."""
    words = [f"{count} {'hold' if name == 'holds' and count != 1 else name}" for name, count in counts.items()]
    return ", ".join(word for word in words if word != "0 unsettled")


def provenance(results_read):
    """Values that the files state for each property of program and machine, with the number of files."""
    names = dict.fromkeys(name for result in results_read for name in result.provenance)
    return {name: Counter(result.provenance.get(name, "not stated") for result in results_read) for name in names}


def dates(results_read):
    """First and last date of the files, one if they are the same."""
    met = sorted({result.provenance.get("date", "") for result in results_read} - {""})
    return met if len(met) < 2 else [met[0], met[-1]]


def figures_of(result, name):
    """Figures of a case, none when its records are not as their plots take them."""
    try:
        return figures.of_case(result, name)
    except Exception as problem:  # one odd result must not cost the others their page
        print(f"{result.file}: no figures ({type(problem).__name__}: {problem})", file=sys.stderr)
        return []


def all_figures(results_read):
    """Figures of every case by its file, drawn by as many processes as there are cores: drawing is most of the time."""
    workers = min(len(os.sched_getaffinity(0)), len(results_read))
    names = [f"f{number}" for number in range(len(results_read))]
    try:
        with concurrent.futures.ProcessPoolExecutor(workers) as pool:
            drawn = list(pool.map(figures_of, results_read, names))
    except (OSError, concurrent.futures.process.BrokenProcessPool):  # no further process is to be had, or one was killed
        drawn = [figures_of(result, name) for result, name in zip(results_read, names)]
    return {result.file: figures for result, figures in zip(results_read, drawn)}


def page(results_read, unreadable, ledger):
    """The whole HTML page as text; `ledger` may be None."""
    entries = ledger_rows(ledger["claims"], results_read) if ledger else []
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent / "report"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    for shown in (numeral, side_by_side, badge, seconds, memory, bond.bands):
        environment.globals[shown.__name__] = shown
    for asked in (anchor, wall_seconds, passed, worst_margin, dimension_of, rerun, small_records):
        environment.globals[asked.__name__] = asked
    environment.filters["powers"] = drawing.powers
    side_figures = bond.bond_laws(results_read, "laws"), bond.bond_laws_secant(results_read, "secants")
    return environment.get_template("page.html.j2").render(
        results=results_read,
        unreadable=unreadable,
        verdicts=Counter(result.verdict for result in as_they_stand(results_read)),
        ledger=entries,
        standings=ledger["counts"] if ledger else {},
        marked=STANDING_MARKS,
        refuted=[entry for entry in entries if entry["standing"].startswith("refuted")],
        laws=bond.laws(results_read),
        law_figures=[drawn for drawn in side_figures if drawn is not None],
        figures=all_figures(results_read),
        price=studies.error_against_time(results_read, "price"),
        answers=studies.answers(results_read),
        never_worth=studies.never_worth(results_read),
        cost_growth=cost.growth(results_read),
        cost_prices=cost.prices(results_read),
        cost_outlook=cost.outlook(results_read),
        cost_picture=cost.picture(results_read, "growth"),
        left_out=(left_out := leave_out.rows(results_read)),
        left_out_sentences=leave_out.sentences(left_out),
        left_out_effect=leave_out.effect,
        saved=leave_out.saved(results_read, "saved"),
        stable_where=stability.stable_where(results_read, "stable"),
        stiffness=(stiffness := stability.compared(results_read)),
        stiffness_sentences=stability.sentences(stiffness),
        provenance=provenance(results_read),
        dates=dates(results_read),
    )


def sweep(folder):
    """Remove what killed writers have left; who still writes holds a lock (as `lib/io/file.cpp` does)."""
    for stale in folder.glob(".veriflex-*.part"):
        try:
            with open(os.open(stale, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK), "rb") as file:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                stale.unlink()
        except OSError:
            pass


def write_through(path, text):
    """Write into what stands there already: a device, a pipe that somebody reads, or what a link points to."""
    file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NONBLOCK, 0o666)
    os.set_blocking(file, True)
    with open(file, "w", encoding="utf-8", errors="backslashreplace") as stream:
        stream.write(text)


def write(path, text):
    """Write aside, then rename: who reads the page meanwhile sees the earlier one, whole."""
    try:
        replaceable = stat.S_ISREG(path.lstat().st_mode)
    except FileNotFoundError:
        replaceable = True
    if not replaceable:
        write_through(path, text)
        return
    sweep(path.parent)
    aside = path.with_name(f".veriflex-{os.getpid()}-report.part")
    try:
        with aside.open("w", encoding="utf-8", errors="backslashreplace") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            file.write(text)
            file.flush()
            aside.replace(path)
    finally:
        aside.unlink(missing_ok=True)


def verdict_table(results_read, unreadable, ledger):
    """Lines of a plain-text table, one row per case, and a line of counts."""
    head = ("case", "verdict", "checks", "worst margin", "findings", "wall s")
    body = []
    for result in results_read:
        margin = worst_margin(result)
        body.append(
            (
                result.id,
                result.verdict,
                f"{passed(result)}/{len(result.checks)}",
                "-" if margin is None else f"{margin:.2g}",
                str(result.findings),
                f"{wall_seconds(result):.3g}",
            )
        )
    body += [(results.plain(broken.file.name), "unreadable", "-", "-", "-", "-") for broken in unreadable]
    widths = [max(len(row[column]) for row in [head, *body]) for column in range(len(head))]
    lines = []
    for row in [head, *body]:
        words = [cell.ljust(width) for cell, width in zip(row[:2], widths[:2])]
        numbers = [cell.rjust(width) for cell, width in zip(row[2:], widths[2:])]
        lines.append("  ".join(words + numbers))
    counts = Counter(result.verdict for result in as_they_stand(results_read))
    changed = [result for result in results_read if result.variant]
    errors = counts["error"] + len(unreadable)
    lines.append("")
    lines.append(
        f"{len(body) - len(changed)} cases: {counts['pass']} pass, {counts['fail']} fail, {errors} error"
        + (f" ({len(unreadable)} unreadable)" if unreadable else "")
        + (f", {counts['measured']} measured without a check" if counts["measured"] else "")
        + (f"; not counted: {len(changed)} changed by --set" if changed else "")
    )
    if ledger and ledger_rows(ledger["claims"], results_read):
        lines.append(f"statements of the paper: {standings_in_words(ledger['counts'])}")
    return lines


def tell(lines):
    """Print the lines; the exit code says whether they have reached their reader."""
    try:
        print("\n".join(lines))
        sys.stdout.flush()
    except OSError as problem:
        print(f"standard output: cannot be written ({problem.strerror}). Make room there", file=sys.stderr)
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left is flushed at the end
        return UNWRITABLE
    return WRITTEN


def main(arguments=None):
    parser = argparse.ArgumentParser(description="Write one HTML page about the result files of a folder.")
    parser.add_argument("folder", type=Path, metavar="RESULTS_DIR", help="folder with the *.h5 files of `veriflex run`")
    parser.add_argument("--out", type=Path, metavar="FILE.html", help="default: RESULTS_DIR/report.html")
    parser.add_argument("--claims", type=Path, metavar="FILE.json", help="the ledger, from `veriflex claims --json`")
    options = parser.parse_args(arguments)
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="backslashreplace")  # names of files may be no text
    out = options.out or options.folder / "report.html"
    remedy = f"Run `veriflex run` with --out {options.folder} first"
    try:
        is_folder, why = options.folder.is_dir(), "it is a file" if options.folder.exists() else "it does not exist"
    except OSError as problem:  # such as a name too long for the file system
        is_folder, why = False, problem.strerror
    if not is_folder:
        print(f"{options.folder}: no results folder ({why}). {remedy}", file=sys.stderr)
        return USAGE
    results_read, unreadable = results.load_all(options.folder)
    if not results_read and not unreadable:
        print(f"{options.folder}: no results (no *.h5 file in it). {remedy}", file=sys.stderr)
        return USAGE
    for broken in unreadable:
        print(broken.message, file=sys.stderr)
    ledger = None
    if options.claims:
        try:
            ledger = json.loads(options.claims.read_text(encoding="utf-8"))
            ledger = {"claims": ledger["claims"], "counts": ledger["counts"]}
        except (OSError, ValueError, KeyError, TypeError) as problem:
            print(f"{options.claims}: no ledger ({problem}). Make it with `veriflex claims --json`", file=sys.stderr)
            return USAGE
    text = page(results_read, unreadable, ledger)
    try:
        write(out, text)
    except OSError as problem:
        print(f"{out}: cannot be written ({problem.strerror}). Give another file with --out", file=sys.stderr)
        return UNWRITABLE
    return tell([*verdict_table(results_read, unreadable, ledger), str(out)])


if __name__ == "__main__":
    sys.exit(main())
