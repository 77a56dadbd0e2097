#!/usr/bin/python3
"""One page about a verification run: reads the result files of a folder, writes a self-contained HTML file.

Verdicts were computed by veriflex; here they are only shown.
"""

import argparse
import fcntl
import json
import math
import os
import stat
import sys
from collections import Counter
from pathlib import Path

from report import cache, parent, text, topics
from veriflex import results

WRITTEN, USAGE, UNWRITABLE = 0, 2, 4
HERE = Path(__file__).parent / "report"
READER = Path(__file__).parent / "veriflex"


def standings_in_words(counts):
    """How many statements of the paper stand how, in one line."""
    words = [f"{count} {'hold' if name == 'holds' and count != 1 else name}" for name, count in counts.items()]
    return ", ".join(word for word in words if word != "0 unsettled")


def sweep(folder):
    """Remove what killed writers have left; who still writes holds a lock (as `lib/io/file.cpp` does)."""
    for stale in folder.glob(".veriflex-*.part"):
        try:
            with open(os.open(stale, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK), "rb") as file:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                stale.unlink()
        except OSError:
            pass


def write_through(path, page):
    """Write into what stands there already: a device, a pipe that somebody reads, or what a link points to."""
    file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NONBLOCK, 0o666)
    os.set_blocking(file, True)
    with open(file, "w", encoding="utf-8", errors="backslashreplace") as stream:
        stream.write(page)


def write(path, page):
    """Write aside, then rename: who reads the page meanwhile sees the earlier one, whole."""
    try:
        replaceable = stat.S_ISREG(path.lstat().st_mode)
    except FileNotFoundError:
        replaceable = True
    if not replaceable:
        write_through(path, page)
        return
    sweep(path.parent)
    aside = path.with_name(f".veriflex-{os.getpid()}-report.part")
    try:
        with aside.open("w", encoding="utf-8", errors="backslashreplace") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            file.write(page)
            file.flush()
            aside.replace(path)
    finally:
        aside.unlink(missing_ok=True)


def verdict_table(results_read, unreadable, counts_of_paper, skipped):
    """Lines of a plain-text table, one row per case, and a line of counts."""
    head = ("case", "verdict", "checks", "worst margin", "findings", "wall s")
    body = []
    for result in results_read:
        margin = text.worst_margin(result)
        body.append(
            (
                result.id,
                result.verdict,
                f"{text.passed(result)}/{len(result.checks)}",
                "-" if margin is None else f"{margin:.2g}",
                str(result.findings),
                f"{text.wall_seconds(result):.3g}",
            )
        )
    body += [(results.plain(broken.file.name), "unreadable", "-", "-", "-", "-") for broken in unreadable]
    widths = [max(len(row[column]) for row in [head, *body]) for column in range(len(head))]
    lines = []
    for row in [head, *body]:
        words = [cell.ljust(width) for cell, width in zip(row[:2], widths[:2])]
        numbers = [cell.rjust(width) for cell, width in zip(row[2:], widths[2:])]
        lines.append("  ".join(words + numbers))
    counts = Counter(result.verdict for result in text.as_they_stand(results_read))
    changed = [result for result in results_read if result.variant]
    errors = counts["error"] + len(unreadable)
    lines.append("")
    lines.append(
        f"{len(body) - len(changed)} cases: {counts['pass']} pass, {counts['fail']} fail, {errors} error"
        + (f" ({len(unreadable)} unreadable)" if unreadable else "")
        + (f", {counts['measured']} measured without a check" if counts["measured"] else "")
        + (f", {counts['skipped']} skipped" if counts["skipped"] else "")
        + (f"; not counted: {len(changed)} changed by --set" if changed else "")
    )
    lacking = [result for result in text.as_they_stand(results_read) if result.verdict == "skipped"]
    for why in dict.fromkeys(result.error_message for result in lacking):
        lines.append(f"skipped: {', '.join(result.id for result in lacking if result.error_message == why)}: {why}")
    if skipped:
        lines.append(f"not run: {skipped} (veriflex verify --tier full)")
    if counts_of_paper:
        lines.append(f"statements of the paper: {standings_in_words(counts_of_paper)}")
    return lines


def verdicts(results_read, unreadable):
    """The same table for programs: one dict per case."""
    rows = []
    for result in results_read:
        margin = text.worst_margin(result)
        rows.append(
            dict(
                id=result.id,
                verdict=result.verdict,
                checks=len(result.checks),
                passed=text.passed(result),
                worst_margin=margin if margin is not None and math.isfinite(margin) else None,
                findings=result.findings,
                wall_seconds=text.wall_seconds(result),
            )
        )
    return rows + [dict(id=results.plain(broken.file.stem), verdict="unreadable") for broken in unreadable]


def progress(done, of):
    """A line on a terminal, which the next one replaces."""
    if sys.stderr.isatty():
        end = "\r\033[K" if done == of else ""
        print(f"\rreport: {done} of {of} results{end}", end="", file=sys.stderr, flush=True)


def report_of(paths, ledger, out):
    """Page, table of verdicts and complaints: kept ones, if nothing has changed that they depend on."""
    code = cache.of_files(HERE, ".py", ".mplstyle", ".j2", ".css", ".js") + cache.of_files(READER, ".py")
    found = {path: results.fingerprint(path) for path in paths}
    linked = [HERE.parents[1] / folder for folder in ("cases", "reference")]  # whose files the page leads to
    names = [name for folder in linked if folder.is_dir() for name in sorted(os.listdir(folder))]
    works = [file.read_bytes() for file in (linked[1] / "bibliography.bib",) if file.is_file()]
    inputs = [text for path, fingerprint in found.items() for text in (str(path), fingerprint)]
    key = cache.checksum(code, json.dumps(ledger), str(out.absolute()), *names, *inputs, *works)
    kept = cache.Cache(cache.home())
    made = kept.get(key)
    if made is not None:
        return made
    from report import page  # here: matplotlib takes longer than all else of a page that was kept

    drawing_code = cache.of_files(HERE, ".py", ".mplstyle") + cache.of_files(READER, ".py")
    results_read, figures, unreadable = page.load(paths, found, drawing_code, kept, progress)
    standing = ledger["counts"] if ledger and page.ledger_rows(ledger["claims"], results_read) else {}
    skipped = topics.skipped(results_read) if standing else ""
    made = dict(
        page=page.render(results_read, figures, unreadable, ledger, skipped, out),
        table=verdict_table(results_read, unreadable, standing, skipped),
        verdicts=verdicts(results_read, unreadable),
        complaints=[broken.message for broken in unreadable],
    )
    kept.put(key, made)
    kept.sweep()
    return made


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
    parser.add_argument("--json", action="store_true", help="print the verdicts as JSON")
    parser.add_argument("--parent", type=int, help=argparse.SUPPRESS)  # process id of the command that asks for the page
    options = parser.parse_args(arguments)
    if options.parent:
        parent.end_with(options.parent)
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
    paths = results.files(options.folder)
    if not paths:
        print(f"{options.folder}: no results (no *.h5 file in it). {remedy}", file=sys.stderr)
        return USAGE
    ledger = None
    if options.claims:
        try:
            ledger = json.loads(options.claims.read_text(encoding="utf-8"))
            ledger = {
                "claims": ledger["claims"],
                "counts": ledger["counts"],
                "citation": str(ledger.get("citation", "")),
                "benchmarks": ledger.get("benchmarks", []),
            }
        except (OSError, ValueError, KeyError, TypeError) as problem:
            print(f"{options.claims}: no ledger ({problem}). Make it with `veriflex claims --json`", file=sys.stderr)
            return USAGE
    made = report_of(paths, ledger, out)
    for complaint in made["complaints"]:
        print(complaint, file=sys.stderr)
    try:
        write(out, made["page"])
    except OSError as problem:
        print(f"{out}: cannot be written ({problem.strerror}). Give another file with --out", file=sys.stderr)
        return UNWRITABLE
    if options.json:
        return tell([json.dumps(dict(verdicts=made["verdicts"], report=str(out)), indent=2)])
    return tell([*made["table"], str(out)])


if __name__ == "__main__":
    sys.exit(main())
