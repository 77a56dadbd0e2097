"""Figures of scenes: a plane of the fluid with the bodies in it."""

import numpy as np
from matplotlib.colors import PowerNorm
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from report.drawing import Figure, WIDTH, canvas, column_label, drawable, extent, inline_svg, legend_above, powers
from report.filament import FILM_COLOURS, FILM_SAMPLES

VELOCITY = ("velocity_x", "velocity_y", "velocity_z")


def is_plane(record):
    """Whether a record holds velocities of the fluid on a plane, or in a box one node thick."""
    return drawable(record, "step", "x", "y", "z", *VELOCITY) and sum(np.ptp(record[axis]) == 0.0 for axis in "xyz") == 1


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
    scale = PowerNorm(0.5, 0.0, extent(speed)[1] or 1.0)
    axes.imshow(speed, cmap=FILM_COLOURS, norm=scale, extent=box, origin="lower", aspect="equal", interpolation="none")
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
    legend_above(axes, [Patch(facecolor=FILM_COLOURS(scale(tick)), label=f"{tick:.2g}") for tick in ticks])
    axes.set_title(f"speed [{powers(record.columns[VELOCITY[0]].dimension)}]", loc="left")
    caption = f"{record.title}, step {record['step'].max():.0f}: speed of the fluid, colours by its root; both axes to one scale."
    if with_bodies:
        caption += " Dots are nodes of bodies."
    return Figure(caption, inline_svg(drawing, caption))
