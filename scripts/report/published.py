"""Computed values against exact laws and published ones: by how much they deviate, and how well either is known."""

import re

import numpy as np
from matplotlib.lines import Line2D

from report.drawing import Figure, canvas, inline_svg, legend_above

PARTS = ("reference", "numerical", "input")
SHAPES = "os^DvP*"  # one more than colours, so that a family has both to itself; all can be hollow


def source_of(check):
    """Key of what a value was taken from: the reference's id, or what the source begins with."""
    return check.reference or re.split("[, ]", check.source)[0]


def rows(results):
    """A row per check that states uncertainties, families together: all is relative to the published value."""
    found = [
        {
            "result": result,
            "check": check,
            "family": (source_of(check), result.driver),
            "deviation": check.measured / check.target - 1,
            "uncertainty": check.tolerance / abs(check.target),
            "parts": {name: getattr(check, f"uncertainty_{name}") / abs(check.target) for name in PARTS},
        }
        for result in results
        for check in result.checks
        if check.has_uncertainty and check.target
    ]
    found.sort(key=lambda row: (row["family"], row["result"].id))
    return [row | {"number": number} for number, row in enumerate(found, 1)]


def families(found):
    """Rows for the table: bias and spread of each family of values, and how far its values may be off by what is known."""
    names = list(dict.fromkeys(row["family"] for row in found))
    by_name = {name: [row for row in found if row["family"] == name] for name in names}
    return [
        {
            "source": name[0],
            "driver": name[1],
            "count": len(members),
            "agree": sum(row["check"].verdict == "pass" for row in members),
            "bias": float(np.mean([row["deviation"] for row in members])),
            "spread": float(np.std([row["deviation"] for row in members], ddof=1)) if len(members) > 1 else None,
            "uncertainty": float(np.sqrt(np.mean([row["uncertainty"] ** 2 for row in members]))),
        }
        for name, members in by_name.items()
    ]


def picture(found):
    """Deviation of each value from the published one, with its combined uncertainty and the reference's own."""
    if not found:
        return None
    drawing, (panel,) = canvas(height=1.25 + 0.2 * len(found))
    places = np.arange(len(found))
    percent = {name: 100 * np.array([row[name] for row in found]) for name in ("deviation", "uncertainty")}
    reference = 100 * np.array([row["parts"]["reference"] for row in found])
    panel.axvline(0, color="#555555", linewidth=0.8)
    panel.errorbar(percent["deviation"], places, xerr=percent["uncertainty"], fmt="none", ecolor="#B8BCC0", elinewidth=1.2, zorder=0)
    panel.errorbar(0 * reference, places, xerr=reference, fmt="none", ecolor="#222222", elinewidth=3, zorder=1)
    kinds = list(dict.fromkeys(row["family"] for row in found))
    looks = [{"marker": SHAPES[number % len(SHAPES)], "color": f"C{number % 6}", "linestyle": "none"} for number in range(len(kinds))]
    for name, look in zip(kinds, looks):
        of_family = np.array([row["family"] == name for row in found])
        for agrees, filled in ((True, look["color"]), (False, "none")):
            chosen = of_family & np.array([(row["check"].verdict == "pass") == agrees for row in found])
            panel.plot(percent["deviation"][chosen], places[chosen], markerfacecolor=filled, **look)
    panel.set_ylim(len(found) - 0.4, -0.6)
    names = [f"{row['result'].id} {row['number']}" for row in found]
    panel.set_yticks(places, [name.replace("-", "\N{NON-BREAKING HYPHEN}") for name in names])  # the drawing's hyphens are minus signs
    panel.grid_along = {"x"}
    panel.set_xlabel("computed over published, less 1 [%]")
    handles = [Line2D([], [], label=", ".join(name), **look) for name, look in zip(kinds, looks)]
    handles.append(Line2D([], [], color="#B8BCC0", label="combined uncertainty"))
    handles.append(Line2D([], [], color="#222222", linewidth=3, label="of the published value"))
    legend_above(panel, handles)
    caption = (
        "Computed values against published ones, family by family. A value agrees when zero lies within its combined uncertainty "
        "(root of the sum of squares of reference, numerical and input); one that does not is hollow."
    )
    return Figure(caption, inline_svg(drawing, caption))
