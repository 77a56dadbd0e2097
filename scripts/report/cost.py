"""What a scene costs by its size: time and memory for each node, bond, angle and marker, and how they grow."""

import tomllib

import numpy as np
from matplotlib.lines import Line2D

from report import studies
from report.drawing import Figure, canvas, inline_svg, legend_above, markers

PREFIX = "cost-of-"  # cases of this name vary one size, timed
UNITS = {
    "node_updates": "node update",
    "bond_evaluations": "bond",
    "angle_evaluations": "angle",
    "marker_interpolations": "marker",
}


def curves(results):
    """Each line along the size of each such case: result, label, key of the size, rows in its order."""
    for result in results:
        record, cost = result.records.get("sweep"), result.records.get("sweep_cost")
        if result.variant or not result.id.startswith(PREFIX) or record is None or cost is None:
            continue
        axes, _, completed = studies.parts(record)
        numbers = [name for name in axes if studies.is_number(record, name)]
        size = numbers[-1]
        others = [name for name in axes if name != size]
        for _, rows in studies.lines(record, axes, size):
            rows = rows[completed[rows]]
            if len(rows) > 1:
                yield result, studies.setting(record, rows[0], others), size, rows[np.argsort(record[size][rows])]


def exponent(x, y):
    """Of y ~ x^p, least squares; not a number where y does not rise."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0]) if (y > 0).all() else np.nan


def of_sizes(results):
    """Those of which the size is what costs, which a radius is not."""
    return [curve for curve in curves(results) if not curve[2].endswith("radius")]


def growth(results):
    """Rows for the table: how time and memory of each line grow, over which range."""
    found = []
    for result, label, size, rows in of_sizes(results):
        record, cost = result.records["sweep"], result.records["sweep_cost"]
        x = record[size][rows]
        found.append(
            {
                "result": result,
                "label": label,
                "size": size.replace("_", " "),
                "range": (float(x[0]), float(x[-1])),
                "time": exponent(x, cost["min_wall_seconds"][rows]),
                "last": exponent(x[-2:], cost["min_wall_seconds"][rows][-2:]),
                "memory": exponent(x, record["parts_bytes"][rows]),
            }
        )
    return found


def increments(results):
    """Between the two largest sizes of each line: result, label, and by how much seconds, work and bytes rise."""
    for result, label, size, rows in curves(results):
        record, cost = result.records["sweep"], result.records["sweep_cost"]
        small, large = rows[-2:]
        rise = {name: record[name][large] - record[name][small] for name in (*UNITS, "parts_bytes")}
        if not size.endswith("steps"):
            yield result, label, rise | {"seconds": cost["min_wall_seconds"][large] - cost["min_wall_seconds"][small]}


def prices(results):
    """Rows for the table: what one more of a thing takes. An angle takes what is left when the bonds have taken theirs."""
    found, of_a_bond = [], {}
    # Lines along which one kind of work rises before those of several.
    for result, label, rise in sorted(increments(results), key=lambda found: sum(found[2][name] > 0 for name in UNITS)):
        grows = [name for name in UNITS if rise[name] > 0]
        if not grows:
            continue
        unit, seconds, memory = grows[-1], rise["seconds"], None
        if len(grows) > 1:
            seconds -= of_a_bond.get(result.id, np.nan) * rise["bond_evaluations"]
        each = seconds / rise[unit]
        if unit == "bond_evaluations":
            of_a_bond[result.id] = each
        if unit == "node_updates":
            steps = tomllib.loads(result.case_text)["run"]["steps"]
            memory = rise["parts_bytes"] / (rise[unit] / steps)
        found.append({"result": result, "label": label, "unit": UNITS[unit], "seconds": each, "bytes": memory})
    return sorted(found, key=lambda row: row["result"].id)


def outlook(results, nodes=(1e7, 1e8, 1e9)):
    """Rows for the table: seconds for 1000 steps and memory of larger boxes, and the cube that fills the machine."""
    found = []
    for row in prices(results):
        if row["bytes"] is None:
            continue
        machine = float(row["result"].provenance.get("machine_memory_bytes", 0))
        found.append(
            row
            | {
                "boxes": [(count, 1e3 * count * row["seconds"], count * row["bytes"]) for count in nodes],
                "side": int((machine / row["bytes"]) ** (1 / 3)),
                "machine": machine,
            }
        )
    return found


def picture(results):
    """Time over size times a constant: level where time is proportional to size."""
    drawn = of_sizes(results)
    if not drawn:
        return None
    drawing, (panel,) = canvas(height=3.9)
    handles = []
    for number, ((result, label, size, rows), marker) in enumerate(zip(drawn, markers())):
        record, cost = result.records["sweep"], result.records["sweep_cost"]
        x, y = record[size][rows], cost["min_wall_seconds"][rows]
        level = y[-1] / x[-1]
        panel.plot(x / x[-1], y / x / level, marker + "-", color=f"C{number % 6}")
        slowest = cost["max_wall_seconds"][rows] if cost.has("max_wall_seconds") else y
        panel.errorbar(x / x[-1], y / x / level, yerr=(0 * y, (slowest - y) / x / level), fmt="none", ecolor="#B8BCC0", zorder=0)
        name = f"{result.id.removeprefix(PREFIX)} {label}"
        handles.append(Line2D([], [], marker=marker, color=f"C{number % 6}", label=name))
    panel.axhline(1, color="#555555", linewidth=0.8)
    panel.set_xscale("log")
    panel.set_xlabel("size over the largest of the sweep [1]")
    panel.set_ylabel("time per size [1]")
    panel.set_ylim(bottom=0)
    legend_above(panel, handles)
    caption = (
        "How the run time grows with the scene, all over the largest size: level where it is proportional to its size, below 1 where caches hold it, "
        "above where a start costs. Points are the fastest repeat, bars reach to the slowest."
    )
    return Figure(caption, inline_svg(drawing, caption))
