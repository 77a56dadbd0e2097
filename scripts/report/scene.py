"""Figures of scenes: what was observed in time, on a line, of nodes, and a plane of the fluid with the bodies in it."""

import numpy as np
from matplotlib.ticker import MaxNLocator

from report.drawing import (
    Figure,
    WIDTH,
    canvas,
    column_label,
    draw_speed,
    drawable,
    extent,
    inline_svg,
    legend_above,
    legend_of_speed,
    powers,
    quantity,
    stacked,
)
from report.filament import FILM_SAMPLES

VELOCITY = ("velocity_x", "velocity_y", "velocity_z")
MANY_CURVES, MANY_PANELS = 5, 6  # more curves of one dimension are a panel for each axis
ROUNDING = 1e-11  # of the largest value of its dimension: what is below it throughout shows nothing


def kinds(result, record):
    """What is drawn of a record: none is called by a name that tells."""
    if not drawable(record, "step", "time"):
        return ()
    if not record.has("x", "y", "z"):
        return (series,)
    if record.has("node"):
        return () if any(is_plane(other) for other in result.records.values()) else (nodes,)
    return (plane,) if is_plane(record) else (line,)


def is_plane(record):
    """Whether a record holds velocities of the fluid on a plane, or in a box one node thick."""
    return drawable(record, "step", "x", "y", "z", *VELOCITY) and sum(np.ptp(record[axis]) == 0.0 for axis in "xyz") == 1


def series(result, record):
    """All columns against time."""
    return against(record, "time", slice(None), record.title or record.name)


def line(result, record):
    """All columns along a line of the fluid when it was last looked at."""
    along = [axis for axis in "xyz" if np.ptp(record[axis]) > 0.0]
    if len(along) != 1:
        return None
    return against(record, along[0], record["step"] == record["step"].max(), f"{record.title}, step {record['step'].max():.0f}")


def against(record, abscissa, rows, caption):
    """All columns against one, a panel per dimension, or per axis of vectors where these are many; what is zero but for rounding is left out."""
    columns = [column for column in record.columns.values() if column.name not in ("step", "time", "x", "y", "z")]
    largest, of_dimension = {}, {}
    for column in columns:
        if column.values.dtype.kind in "iuf":
            largest[column.name] = np.nanmax(np.abs(column.values[rows]), initial=0.0)
            of_dimension[column.dimension] = max(of_dimension.get(column.dimension, 0.0), largest[column.name])
    seen = [column for column in columns if largest.get(column.name, 0.0) > ROUNDING * of_dimension[column.dimension]]
    groups = {}
    for column in seen:
        along = column.name[-1] if column.name[-2:] in ("_x", "_y", "_z") else ""
        same = [other for other in seen if other.dimension == column.dimension]
        along = along if len(same) > MANY_CURVES else ""
        ordinate = quantity(f"along {along}" if along else "value", "", column.dimension)
        groups.setdefault(ordinate, []).append((column.name.removesuffix("_" + along).replace("_", " "), column))
    if not 0 < len(groups) <= MANY_PANELS or len(record[abscissa][rows]) < 2:
        return None
    drawing = stacked(record.columns[abscissa], list(groups.items()), rows)
    if len(seen) < len(columns):
        caption += "; not drawn, 0 but for rounding: " + ", ".join(column.name for column in columns if column not in seen)
    return Figure(caption, inline_svg(drawing, caption))


def nodes(result, record):
    """Nodes of a body when they were last looked at, in the plane of their largest extents."""
    last = record["step"] == record["step"].max()
    across, up = sorted(sorted("xyz", key=lambda axis: -np.ptp(record[axis][last]))[:2])
    drawing, (axes,) = canvas()
    place = record[across][last]
    handles = axes.plot(place, record[up][last], ".", markersize=3, label="measured")
    for reference in result.references:
        if drawable(reference.columns, "node", up) and len(reference.columns["node"]) == len(place):
            handles += axes.plot(place, reference.columns[up], "-", color="#222222", linewidth=0.8, label=reference.kind)
    if len(handles) > 1:
        legend_above(axes, handles)
    axes.set_xlabel(column_label(record.columns[across]))
    axes.set_ylabel(column_label(record.columns[up]))
    caption = f"{record.title}, step {record['step'].max():.0f}"
    return Figure(caption, inline_svg(drawing, caption))


def plane(result, record):
    """Speed of the fluid on the plane when it was last looked at, under the nodes of bodies at that time."""
    last = record["step"] == record["step"].max()
    axes_of_plane = [axis for axis in "xyz" if np.ptp(record[axis]) > 0.0]
    across, up = sorted(axes_of_plane, key=lambda axis: -np.ptp(record[axis]))
    a, b = np.unique(record[across][last]), np.unique(record[up][last])
    if len(a) * len(b) != last.sum():
        return None
    order = np.lexsort((record[across][last], record[up][last]))
    speed = np.sqrt(sum(record[name][last] ** 2 for name in VELOCITY))[order].reshape(len(b), len(a))
    every = -(-len(a) // FILM_SAMPLES)
    speed = speed[::every, ::every]
    box = (a[0] - 0.5, a[-1] + 0.5, b[0] - 0.5, b[-1] + 0.5)
    drawing, (axes,) = canvas(height=min((WIDTH - 0.7) * (box[3] - box[2]) / (box[1] - box[0]) + 1.1, 6.0))
    scale = draw_speed(axes, speed, box, extent(speed)[1])
    with_bodies = False
    for nodes in result.records.values():
        if drawable(nodes, "step", "node", across, up):
            there = nodes["step"] == record["step"].max()
            axes.plot(nodes[across][there], nodes[up][there], ".", color="C1", markersize=1.2)
            with_bodies = True
    axes.set_xlim(*box[:2])
    axes.set_ylim(*box[2:])
    axes.grid_along = set()
    axes.set_xlabel(column_label(record.columns[across]))
    axes.set_ylabel(column_label(record.columns[up]))
    ticks = [tick for tick in MaxNLocator(4, steps=(1, 2, 5, 10)).tick_values(0.0, scale.vmax) if tick <= scale.vmax]
    legend_of_speed(axes, scale, ticks)
    axes.set_title(f"speed [{powers(record.columns[VELOCITY[0]].dimension)}]", loc="left")
    caption = f"{record.title}, step {record['step'].max():.0f}: speed of the fluid, colours by its root; both axes to one scale."
    if with_bodies:
        caption += " Dots are nodes of bodies."
    return Figure(caption, inline_svg(drawing, caption))
