"""The first screen: three panels, each with a picture and one line, or one line that says what to run."""

from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from report import filament, leave_out, stability, studies, topics
from report.drawing import NARROW, TALL, Figure
from report.text import anchor, memory, numeral, seconds


@dataclass(frozen=True)
class Panel:
    title: str
    figure: Figure | None
    line: Markup
    more: str  # anchor of the section with everything of the kind


def link(result):
    return Markup('<a href="#{}">{}</a>').format(anchor(result), result.id)


def to_run(words, command):
    return Markup("{} <code>{}</code>").format(words, command)


def picture_of_filament(results):
    """Result and figure of the filament: of the case that ran longest in the largest box, none without one."""
    found = [result for result in results if "centre_lines" in result.records and result.verdict != "error"]
    for result in sorted(found, key=lambda result: (-result.metric("touched_nodes") if result.metric("touched_nodes") else 0, result.id)):
        drawn = filament.strip(result)
        if drawn is not None:
            return result, drawn
    return None, None


def cheapest(results, ask=1e-3):
    """The settings that reach an error at the least and at the highest price, of all families, in one line."""
    rows = [row for row in studies.answers(results, (ask,)) if row["timed"]] or studies.answers(results, (ask,))
    if not rows:
        return Markup("")
    price = [seconds(row["price"]) if row["timed"] else f"{memory(row['price'])} moved" for row in rows]
    order = sorted(range(len(rows)), key=lambda index: rows[index]["price"])
    first, last = order[0], order[-1]
    line = Markup("An error of {} costs {} ({})").format(numeral(ask), price[first], link(rows[first]["result"]))
    if last != first:
        line += Markup(" to {} ({})").format(price[last], link(rows[last]["result"]))
    return line + "."


def accuracy(results):
    drawn = studies.error_against_time(results)
    timed = any(record.name == "sweep_cost_front" for _, record in studies.families(results))
    if drawn is None:
        line = to_run("No sweep among these results names its error. Run", "veriflex run cost-oscillation-pair")
        return Panel("Error against run time", None, line, "accuracy")
    line = cheapest(results)
    if not timed:
        line += Markup(" ") + to_run("For run times:", "veriflex run cost-oscillation-pair")
    return Panel("Error against run time" if timed else "Error against work", drawn, line, "accuracy")


def margins(results):
    """How near the paper's scene comes to each limit that a result knows: (what, share of the limit, result)."""
    by_id = {result.id: result for result in results}
    found = []
    scene = next((by_id[name] for name in ("filament-stroke-paper", "filament-stroke-full", "filament-stroke") if name in by_id), None)
    if scene is not None:
        step, mach = scene.metric("dt_over_limit"), scene.metric("max_mach")
        most = topics.monitored(scene, "monitor", "mach_limit")
        found.append(("its linear step limit", step, scene))
        found.append(("its Mach number’s limit", mach / most if mach and most else None, scene))
    law = by_id.get("derive-paper-parameters") or by_id.get("derive-fene-lj")
    if scene is not None and law is not None and law.metric("strain_at_r_max") and scene.metric("max_strain"):
        found.append(("its bonds’ reach", scene.metric("max_strain") / law.metric("strain_at_r_max"), scene))
    coupled = by_id.get("coupling-stability-full") or by_id.get("coupling-stability")
    mass = topics.monitored(scene, "filament", "node_mass") if scene is not None else None
    if coupled is not None and mass and "ablate" in coupled.records:
        found.append(("the coupling’s with one sub-step", coupled.records["ablate"]["predicted"][0] / mass, coupled))
    return [(what, share, result) for what, share, result in found if share is not None and np.isfinite(share)]


def stable(results):
    result = stability.plainest(results)
    near = margins(results)
    line = Markup("")
    if near:
        words = [Markup('<a href="#{}">{} %</a> of {}').format(anchor(result), numeral(100 * share, 2), what) for what, share, result in near]
        line = Markup("The paper’s scene uses ") + Markup(", ").join(words) + "."
    if result is None:
        line += Markup(" ") + to_run("No search for a limit among these results. Run", "veriflex run step-limit")
        return Panel("Stable where", None, line, "stability")
    return Panel("Stable where", stability.stiffness_limit(result, result.records["outcome_boundary"], NARROW, TALL), line, "stability")


def left_out(results):
    result, record = leave_out.largest(results)
    if result is None:
        line = to_run("Nothing was left out and put to the test. Run", "veriflex run ablate-paper-scene")
        return Panel("Left out", None, line, "left-out")
    rows, times = leave_out.without_effect(result, record), leave_out.medians_of(result)
    parts = ", ".join(str(record["variant"][row]).removeprefix("with ") for row in rows)
    saved = sum(float(record["parts_bytes"][row] - record["parts_bytes"][0]) for row in rows)
    line = Markup("{} leaves out, without effect, {}: ").format(link(result), parts)
    line += f"{memory(saved)} saved beside {memory(float(record['parts_bytes'][0]))}"
    if times is not None:
        longer = max(0.0, sum(float(times[row] - times[0]) for row in rows))
        line += Markup(", {} beside {}").format(seconds(longer), seconds(float(times[0])))
    line += "."
    if result.id != "ablate-paper-scene":
        line += Markup(" ") + to_run("The paper’s own box, with times:", "veriflex run ablate-paper-scene")
    return Panel("Left out", leave_out.saved(results), line, "left-out")


PANELS = (accuracy, stable, left_out)
