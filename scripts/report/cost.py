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
        for label, rows in studies.lines(record, axes, size):
            rows = rows[completed[rows]]
            if len(rows) > 1:
                yield result, label, size, rows[np.argsort(record[size][rows])]


def words(label):
    """`representation moments, storage double` as `moments double`: the values that are words say what they are of."""
    parts = [part.split(" ", 1) for part in label.split(", ") if " " in part]
    return ", ".join(value if not value[0].isdigit() else f"{name} {value}" for name, value in parts)


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
                "label": words(label),
                "size": size.replace("_", " "),
                "range": (float(x[0]), float(x[-1])),
                "time": exponent(x, cost["min_wall_seconds"][rows]),
                "last": exponent(x[-2:], cost["min_wall_seconds"][rows][-2:]),
                "memory": exponent(x, record["parts_bytes"][rows]),
            }
        )
    return found


def prices(results):
    """Rows for the table: what one more of a thing takes, from the two largest sizes of a line."""
    found, of_bonds = [], {}
    for result, label, size, rows in curves(results):
        label = words(label)
        record, cost = result.records["sweep"], result.records["sweep_cost"]
        small, large = rows[-2:]
        seconds = cost["min_wall_seconds"][large] - cost["min_wall_seconds"][small]
        more = {name: record[name][large] - record[name][small] for name in UNITS}
        bytes_more = record["parts_bytes"][large] - record["parts_bytes"][small]
        grows = [name for name in UNITS if more[name] > 0]
        if not grows or "steps" in size:
            continue
        if len(grows) == 1:
            unit = grows[0]
            if unit == "bond_evaluations":
                of_bonds[result.id] = seconds / more[unit]
            found.append({"result": result, "label": label, "unit": UNITS[unit], "seconds": seconds / more[unit], "bytes": None})
            if unit == "node_updates":
                steps = tomllib.loads(result.case_text)["run"]["steps"]
                found[-1]["bytes"] = bytes_more / (more[unit] / steps)
        else:
            found.append({"result": result, "label": label, "unit": "angle", "seconds": (seconds, more), "bytes": None})
    for row in found:  # what an angle takes is what is left when the bonds have taken theirs
        if isinstance(row["seconds"], tuple):
            seconds, more = row["seconds"]
            bond = of_bonds.get(row["result"].id, np.nan)
            row["seconds"] = (seconds - bond * more["bond_evaluations"]) / more["angle_evaluations"]
    return found


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


def picture(results, key):
    """Time over size times a constant: level where time is proportional to size."""
    drawn = of_sizes(results)
    if not drawn:
        return None
    drawing, (panel,) = canvas(height=3.9)
    handles = []
    for number, ((result, label, size, rows), marker) in enumerate(zip(drawn, markers())):
        record, cost = result.records["sweep"], result.records["sweep_cost"]
        x, y = record[size][rows], cost["min_wall_seconds"][rows]
        panel.plot(x / x[-1], y / x / (y[-1] / x[-1]), marker + "-", color=f"C{number % 10}")
        name = f"{result.id.removeprefix(PREFIX)} {words(label)}"
        handles.append(Line2D([], [], marker=marker, color=f"C{number % 10}", label=name))
    panel.axhline(1, color="#555555", linewidth=0.8)
    panel.set_xscale("log")
    panel.set_xlabel("size over the largest of the sweep [1]")
    panel.set_ylabel("time per size [1]")
    panel.set_ylim(bottom=0)
    legend_above(panel, handles)
    caption = "How the run time grows with the scene, all over the largest size: level where it is proportional to its size, below 1 where caches hold it, above where a start costs."
    return Figure(caption, inline_svg(drawing, key, caption))
