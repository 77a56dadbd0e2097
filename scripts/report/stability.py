"""Where a body is stable: how stiff it may be at a given step, by bond law and disturbance.

A body alone in vacuum knows one number without dimension that holds its stiffness, E dt^2/(m/r0^3); the least node mass
of a search at a step of 1 therefore says how stiff the body may be, and 1 over it is shown.
"""

import numpy as np
from matplotlib.lines import Line2D

from report import studies
from report.drawing import HEIGHT, WIDTH, Figure, canvas, inline_svg, legend_above, markers

KEY, LAW, PHYSICAL = "body.0.node_mass", "body.0.name", "monitor.physical"
STIFFNESS, FOLLOWING, SUBSTEPS = "body.0.stiffness", "body.0.coupling.subcycled", "body.0.substeps"


def is_search(record):
    """Whether a boundary is that of the node mass of bodies that differ in their bond law."""
    return record is not None and record.has(LAW, "boundary") and f"along {KEY}," in record.title


def is_stiffness_search(record):
    """Whether a boundary is that of the stiffness of bodies that differ in their bond law."""
    return record is not None and record.has(LAW, "boundary") and f"along {STIFFNESS}," in record.title


def coupled_stiffness(result, record):
    """The stiffest coupled body against the last axis of numbers, by law and sub-steps; bars over all other axes."""
    names = list(record.columns)
    axes = [name for name in names[: names.index("boundary")] if record[name].dtype.kind in "iuf" and name != SUBSTEPS]
    if not axes:
        return studies.outcome_boundary(result, record)
    axis = axes[-1]
    ways = list(dict.fromkeys(record[FOLLOWING])) if record.has(FOLLOWING) else [None]
    drawing, panels = canvas(len(ways), height=1.2 + 2.4 * len(ways), sharex=True)
    handles, hints = [], []
    for panel, way in zip(panels, ways):
        here = np.full(len(record), True) if way is None else record[FOLLOWING] == way
        for number, law in enumerate(dict.fromkeys(record[LAW])):
            for marker, substeps in zip(markers(), sorted(set(record[SUBSTEPS]))):
                rows = here & (record[LAW] == law) & (record[SUBSTEPS] == substeps)
                x = np.array(sorted(set(record[axis][rows])))
                found = [record["boundary"][rows & (record[axis] == at)] for at in x]
                low, high = (np.array([bound(values) for values in found]) for bound in (np.nanmin, np.nanmax))
                middle = np.sqrt(low * high)
                line = panel.plot(x, middle, marker + "-", color=f"C{number}", label=f"{law}, {substeps:g} sub-step{'s' if substeps > 1 else ''}")
                panel.errorbar(x, middle, yerr=(middle - low, high - middle), fmt="none", ecolor=f"C{number}")
                if panel is panels[0]:
                    handles += line
                for at, a, b in zip(x, low, high):
                    hints.append((panel, at, np.sqrt(a * b), f"{law}, {substeps:g} sub-steps, {axis} {at:g}: {a:.3g} to {b:.3g}"))
        panel.set_yscale("log")
        panel.set_ylabel("stiffest body carried" + {"false": ", force frozen", "true": ", force following"}.get(str(way), "") + " [1]")
        panel.margins(x=0.06, y=0.1)
    panels[-1].set_xlabel(axis.replace("_", " "))
    legend_above(panels[0], handles)
    caption = f"{result.title}. Over E = 0.26, by law and sub-steps; bars: over the other axes of the search."
    return Figure(caption, inline_svg(drawing, caption, hints))


def disturbance(record):
    """The axis of numbers whose values are those of the disturbance; None without one."""
    names = list(record.columns)
    axes = [name for name in names[: names.index("boundary")] if record[name].dtype.kind in "iuf"]
    return axes[-1] if axes and len(set(record[axes[-1]])) > 1 else None


def undisturbed(record, x):
    """The least node mass of the first law at the smallest disturbance, from which all others are counted."""
    rows = np.flatnonzero(record[LAW] == record[LAW][0])
    rows = rows[np.isfinite(record["boundary"][rows])]
    return record["boundary"][rows[np.argmin(np.abs(x[rows]))]] if rows.size else np.nan


def limits_of(record):
    """Rows (law, whether states that no solid has count as failed, disturbances, stiffness over that of the first law
    undisturbed, how the runs behind end)."""
    x = record[disturbance(record)]
    strict = record[PHYSICAL] == "true" if record.has(PHYSICAL) else np.ones(len(record), bool)
    mass = undisturbed(record, x)
    for law in dict.fromkeys(record[LAW]):
        for counts in (True, False):
            rows = np.flatnonzero((record[LAW] == law) & (strict == counts))
            if rows.size:
                rows = rows[np.argsort(x[rows])]
                yield law, counts, x[rows], mass / record["boundary"][rows], record["outcome_behind"][rows]


def name_of(axis):
    """`body.0.start.impact.strain` as "impact strain"."""
    words = axis.removeprefix("body.0.").removeprefix("start.")
    return {"strain": "strain of the start", "load.force.2": "force on each end node"}.get(words, words.replace(".", " "))


def stiffness_limit(result, record, width=WIDTH, height=HEIGHT):
    """How stiff a body may be against how much it is disturbed; any other search for a boundary as it is."""
    if is_stiffness_search(record) and record.has(SUBSTEPS):
        return coupled_stiffness(result, record)
    if not is_search(record) or disturbance(record) is None or disturbance(record) == SUBSTEPS:
        return studies.outcome_boundary(result, record)
    axis = disturbance(record)
    drawing, (panel,) = canvas(width=width, height=height)
    handles, classes, hints = [], {}, []
    for number, (law, marker) in enumerate(zip(dict.fromkeys(record[LAW]), markers())):
        handles.append(Line2D([], [], marker=marker, color=f"C{number}", label=str(law)))
        for _, counts, x, stiffness, ends in (found for found in limits_of(record) if found[0] == law):
            style = dict(linestyle="-") if counts else dict(linestyle=":", mfc="none")
            panel.plot(x, stiffness, marker=marker, color=f"C{number}", **style)
            allowed = "" if counts else ", unphysical states allowed"
            for at, y, end in zip(x, stiffness, ends):
                hints.append((panel, at, y, f"{law}{allowed}, {name_of(axis)} {at:.4g}: stiffness {y:.4g}; beyond: {end}"))
            if counts:
                classes.setdefault(law, []).extend(zip(x[np.isnan(stiffness)], ends[np.isnan(stiffness)]))
    for number, (law, lost) in enumerate(classes.items()):
        for place, _ in lost:
            panel.plot(place, 0.025 + 0.04 * number, "x", color=f"C{number}", transform=panel.get_xaxis_transform())
    if record.has(PHYSICAL):
        handles.append(Line2D([], [], linestyle=":", color="#555555", label="unphysical states allowed"))
    panel.axhline(1.0, color="#555555", linewidth=0.8)
    panel.set_yscale("log")
    x = record[axis]
    if x.min() > 0 and x.max() > 20 * x.min():
        panel.set_xscale("log")
    panel.set_xlabel(name_of(axis))
    panel.set_ylabel("stiffest body carried [1]")
    panel.margins(x=0.06, y=0.12)
    legend_above(panel, handles)
    caption = f"{result.title}. Over the stiffness that the first law carries undisturbed; above a curve runs fail."
    if any(classes.values()):
        ends = sorted({str(end) for lost in classes.values() for _, end in lost})
        caption += f" × at the foot: fails at every stiffness tried ({', '.join(ends)})."
    return Figure(caption, inline_svg(drawing, caption, hints))


def searches(results):
    """Results of such searches that no --set has changed."""
    return [result for result in results if not result.variant and is_search(result.records.get("outcome_boundary"))]


def maps(results, most=2):
    """Results of the searches with the most rows: of bodies in motion before those that are held."""
    found = [result for result in searches(results) if disturbance(result.records["outcome_boundary"]) not in (None, SUBSTEPS)]
    return sorted(found, key=lambda result: ("prestrain" in result.id, -len(result.records["outcome_boundary"])))[:most]


def plainest(results, most=4):
    """Of these the first with so few laws that a small panel can name them, else the one with the fewest."""

    def laws(result):
        return len(set(result.records["outcome_boundary"][LAW]))

    found = maps(results, None)
    return next((result for result in found if laws(result) <= most), min(found, key=laws, default=None))


def stable_where(results):
    """Their figures, as the picture for all."""
    return [stiffness_limit(result, result.records["outcome_boundary"]) for result in maps(results)]


def compared(results):
    """Rows (result, disturbance, law, stiffness of that law over the first law's at the same disturbance)."""
    rows = []
    for result in searches(results):
        record = result.records["outcome_boundary"]
        axis = disturbance(record)
        if axis in (None, SUBSTEPS):
            continue
        strict = {law: (x, stiffness, ends) for law, counts, x, stiffness, ends in limits_of(record) if counts}
        first, *others = strict
        x, reference, reference_ends = strict[first]
        for row, value in enumerate(x):
            rows.append(
                {
                    "result": result,
                    "what": f"{name_of(axis)} {value:.6g}".replace("-", "−"),
                    "first": (first, reference[row], str(reference_ends[row])),
                    "others": [(law, strict[law][1][row] / reference[row], strict[law][1][row], str(strict[law][2][row])) for law in others],
                }
            )
    return rows


def sentences(rows, alike=0.02):
    """For each law but the first, under how many disturbances it carries more, as much or less stiffness."""
    found = []
    for law in dict.fromkeys(law for row in rows for law, *_ in row["others"]):
        ratios = {"stiffer": [], "as stiff": [], "softer": []}
        lost = gained = neither = 0
        for row in rows:
            _, own, _ = row["first"]
            for other, ratio, stiffness, _ in row["others"]:
                if other != law:
                    continue
                if np.isfinite(ratio):
                    kind = "as stiff" if abs(ratio - 1) <= alike else "stiffer" if ratio > 1 else "softer"
                    ratios[kind].append(ratio)
                elif np.isfinite(own):
                    lost += 1
                elif np.isfinite(stiffness):
                    gained += 1
                else:
                    neither += 1
        first = rows[0]["first"][0]
        counts = [f"{len(found)} {kind} bodies" for kind, found in ratios.items() if kind != "as stiff"]
        counts.append(f"{len(ratios['as stiff'])} as stiff within {alike:.0%}")
        text = f"{law} against {first} bonds, {len(rows)} disturbances: {', '.join(counts)}"
        if ratios["softer"]:
            text += f", down to {min(ratios['softer']):.2g} of the stiffness"
        text += f"; in {lost} it fails at every stiffness tried and {first} does not, in {gained} the reverse, in {neither} both do."
        found.append(text)
    return found
