"""The page: what it needs of the results, and its template."""

import concurrent.futures
import os
import re
import sys
from collections import Counter
from dataclasses import asdict
from pathlib import Path

import jinja2
from markupsafe import Markup

from report import bond, cache, codes, cost, drawing, equation, figures, findings, leave_out, motive, overview, parent, published, sources, stability, studies, text, topics
from veriflex import results

HERE = Path(__file__).parent
SECTIONS = {
    "ledger": "What the paper states",
    "published": "Exact laws and published values",
    "codes": "Codes side by side",
    "accuracy": "What accuracy costs",
    "motive": "The paper’s motive",
    "stability": "Stiffness by law",
    "left-out": "Parts left out",
    "cost": "Cost by size",
    "laws": "Laws side by side",
}
PANELLED = ("ledger", "accuracy", "stability", "left-out")  # any of these makes the three panels worth their place
SMALL_ROWS, SMALL_COLUMNS = 12, 8  # records of at most that size are shown as tables
COURSE = ("last", "mean", "min", "max")
# As what a statement of the paper is marked, by its standing.
STANDING_MARKS = {
    "holds": "pass",
    "refuted in part": "finding",
    "refuted": "finding",
    "not decidable": "",
    "not run": "",
    "unsettled": "fail",
}


def small_records(result):
    """Records short enough to be read, without those that the page shows in a form of their own."""
    return [
        record
        for record in result.records.values()
        if record.name not in figures.KINDS and 0 < len(record) <= SMALL_ROWS and len(record.columns) <= SMALL_COLUMNS
    ]


def metric_rows(result):
    """Rows (name, (part, value) ..., dimension, meaning); what is known of a column in time, `.last` to `.max`, shares one."""
    by_name = {metric.name: metric for metric in result.metrics}
    courses = {name.removesuffix(".last") for name in by_name if all(f"{name.removesuffix('.last')}.{part}" in by_name for part in COURSE)}
    rows = []
    for metric in result.metrics:
        stem, _, part = metric.name.rpartition(".")
        if stem not in courses or part not in COURSE:
            rows.append((metric.name, [("", metric.value)], metric.dimension, metric.meaning))
        elif part == "last":
            rows.append((stem, [(part, by_name[f"{stem}.{part}"].value) for part in COURSE], metric.dimension, metric.meaning))
    return rows


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


def baselines(result):
    """Checks against earlier results of this program: many and alike, so that the page folds them."""
    return [check for check in result.checks if check.target_kind == "baseline"]


def figures_of(result):
    """Figures of a case, none when its records are not as their plots take them."""
    try:
        return figures.of_case(result)
    except Exception as problem:  # one odd result must not cost the others their page
        print(f"{result.file}: no figures ({type(problem).__name__}: {problem})", file=sys.stderr)
        return []


def tried(make, results_read, otherwise):
    """What is made of all results; `otherwise`, where an odd one among them stops it."""
    try:
        return make(results_read)
    except Exception as problem:
        print(f"{make.__module__}.{make.__name__}: left out ({type(problem).__name__}: {problem})", file=sys.stderr)
        return otherwise


def read_and_draw(path, key, kept):
    """A file as a Result or an Unreadable, and its figures: those that were kept, or drawn now."""
    read = results.read_file(path)
    if isinstance(read, results.Unreadable):
        return read, []
    drawn = kept.get(key)
    try:
        return read, [drawing.Figure(**figure) for figure in drawn]
    except TypeError:  # nothing kept, or something else
        drawn = figures_of(read)
        kept.put(key, [asdict(figure) for figure in drawn])
        return read, drawn


def in_parallel(work, arguments, progress):
    """Results of work(*arguments[n]) in order, by as many processes as there are cores."""
    workers = min(len(os.sched_getaffinity(0)), len(arguments))
    done = []
    try:
        with concurrent.futures.ProcessPoolExecutor(workers, initializer=parent.end_with, initargs=(os.getpid(),)) as pool:
            for found in pool.map(work, *zip(*arguments), chunksize=max(1, len(arguments) // (8 * workers))):
                done.append(found)
                progress(len(done), len(arguments))
    except (OSError, concurrent.futures.process.BrokenProcessPool):  # no further process is to be had, or one was killed
        done += [work(*each) for each in arguments[len(done) :]]
    return done


def load(paths, checksums, code, kept, progress):
    """All results of the files with their figures by file, and the unreadable ones."""
    found = in_parallel(read_and_draw, [(path, cache.checksum(code, checksums[path]), kept) for path in paths], progress)
    good = [(read, drawn) for read, drawn in found if not isinstance(read, results.Unreadable)]
    broken = [read for read, _ in found if isinstance(read, results.Unreadable)]
    return [read for read, _ in good], {read.file: drawn for read, drawn in good}, broken


def environment():
    made = jinja2.Environment(
        loader=jinja2.FileSystemLoader(HERE),
        autoescape=lambda name: name is None or ".html" in name,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    shown = (text.numeral, text.side_by_side, text.badge, text.seconds, text.memory, bond.bands)
    asked = (text.anchor, text.wall_seconds, text.passed, text.worst_margin, text.dimension_of)
    for function in (*shown, *asked, topics.rerun, topics.set_up, sources.files_of, sources.reference_link, small_records, metric_rows, baselines):
        made.globals[function.__name__] = function
    made.filters["powers"] = drawing.powers
    made.filters["typeset"] = equation.typeset
    made.filters["cites"] = sources.linked
    return made


def title_of(entries, results_read):
    """What the page is about: the paper, one case, or what was run."""
    if entries:
        return "Verification report: does the paper hold?"
    if len(results_read) == 1:
        return results_read[0].title or results_read[0].id
    return "Verification report"


def in_short_lines(page):
    """Without the indentation of the templates, which nobody reads."""
    return "\n".join(line.strip() for line in page.splitlines() if line.strip())


def render(results_read, figures_by_file, unreadable, ledger, skipped, out):
    """The whole HTML page; `ledger` may be None, `skipped` says what a tier did not run."""
    entries = ledger_rows(ledger["claims"], results_read) if ledger else []
    standing = text.as_they_stand(results_read)
    filament, filament_figure = tried(overview.picture_of_filament, standing, (None, None))
    side_figures = [tried(draw, results_read, None) for draw in (bond.bond_laws, bond.bond_laws_secant)]
    law_figures = [drawn for drawn in side_figures if drawn is not None]
    left_out = tried(leave_out.rows, results_read, [])
    stiffness = tried(stability.compared, results_read, [])
    motives = tried(motive.rows, results_read, [])
    few = len(results_read) + len(unreadable) <= 3
    benchmarks = ledger_rows(ledger["benchmarks"], results_read) if ledger else []
    if few:  # systems that none of them computed are of no interest then
        benchmarks = [entry for entry in benchmarks if any(found["result"] for found in entry["judgements"])]
    measured_elsewhere = tried(published.rows, standing, [])
    side_by_side = tried(codes.matrix, standing, None)
    growth, answers = tried(cost.growth, results_read, []), tried(studies.answers, results_read, [])
    there = dict(zip(SECTIONS, (entries, benchmarks or measured_elsewhere, side_by_side, answers, entries and motives, stiffness, left_out, growth, law_figures)))
    panels = [tried(panel, standing, None) for panel in overview.PANELS] if any(there[name] for name in PANELLED) else []
    page = environment().get_template("page.html.j2").render(
        results=results_read,
        few=few,
        groups=topics.grouped(results_read),
        topics=sorted({topic for result in results_read for topic in result.topics}),
        unreadable=unreadable,
        verdicts=Counter(result.verdict for result in standing),
        broken=[result for result in standing if result.verdict not in ("pass", "measured", "skipped")],
        lacking=[result for result in standing if result.verdict == "skipped"],
        title=title_of(entries, results_read),
        skipped=skipped,
        citation=sources.cited(ledger["citation"]) if entries and "citation" in ledger else "",
        sections={name for name, content in there.items() if content},
        section_names=SECTIONS,
        ledger=entries,
        standings=ledger["counts"] if ledger else {},
        marked=STANDING_MARKS,
        claim_ids={entry["id"] for entry in (*entries, *benchmarks)},
        findings=tried(findings.of, standing, []) if entries else [],
        filament=filament,
        filament_figure=filament_figure,
        panels=[panel for panel in panels if panel is not None],
        laws=tried(bond.laws, results_read, []),
        law_figures=law_figures,
        figures=figures_by_file,
        benchmarks=benchmarks,
        works=sources.works(results_read, benchmarks),
        published_rows=measured_elsewhere,
        published_families=tried(published.families, measured_elsewhere, []),
        published_picture=tried(published.picture, measured_elsewhere, None),
        codes=side_by_side,
        answers=answers,
        accuracy_picture=tried(lambda read: studies.error_against_time(read, whole=True), results_read, None),
        method_pictures=tried(lambda read: [studies.of_methods(group) for group in studies.methods(read)], results_read, []),
        never_worth=tried(studies.never_worth, results_read, []),
        cheapest_ranges=tried(studies.cheapest_ranges, results_read, []),
        slopes=tried(studies.slopes, results_read, []),
        cost_growth=growth,
        cost_prices=tried(cost.prices, results_read, []),
        cost_outlook=tried(cost.outlook, results_read, []),
        cost_picture=tried(cost.picture, results_read, None),
        left_out=left_out,
        left_out_sentences=tried(leave_out.sentences, left_out, []) if left_out else [],
        left_out_effect=leave_out.effect,
        motives=motives,
        motive_sentences=tried(motive.sentences, motives, []) if motives else [],
        motive_statements=motive.statements(entries),
        stable_where=tried(stability.stable_where, results_read, []),
        stiffness=stiffness,
        stiffness_sentences=stability.sentences(stiffness) if stiffness else [],
        provenance=text.provenance(results_read),
        dates=text.dates(results_read),
        out=out,
        style=Markup((HERE / "style.css").read_text("utf-8")),
        script=Markup((HERE / "script.js").read_text("utf-8")),
    )
    return in_short_lines(page)
