"""Figures of lattice-spring bodies: bending, buckling, waves."""

import numpy as np
from matplotlib.lines import Line2D

from report.drawing import (
    Figure,
    MARK,
    canvas,
    column_label,
    drawable,
    extent,
    inline_svg,
    label_points,
    legend_above,
    quantity,
)


def elastica(result, record):
    """Tip of the bent beam on the curve of the elastica; deflection above, reach below."""
    exact = result.records.get("elastica_exact")
    if not drawable(record, "load", "deflection", "reach") or not drawable(exact, "load", "deflection", "reach"):
        return None
    drawing, panels = canvas(2, height=5.0, sharex=True)
    for axes, name in zip(panels, ("deflection", "reach")):
        handles = axes.plot(exact["load"], exact[name], "-", color="#222222", linewidth=1.2, label="elastica")
        handles += axes.plot(record["load"], record[name], "o", color="C0", markerfacecolor="none", label="lattice")
        axes.set_ylabel(f"{name} over length [1]")
    legend_above(panels[0], handles)
    panels[-1].set_xlabel(column_label(record.columns["load"]))
    caption = f"{record.title}: along the load (above) and along the undeformed axis (below)."
    return Figure(caption, inline_svg(drawing, caption))


def buckling(result, record):
    """Critical load over Euler's against slenderness, beside the two theories with shear; of a sweep over lengths."""
    if not drawable(record, "buckling.length", "load", "euler", "engesser", "haringx"):
        return None
    drawing, (axes,) = canvas()
    length, euler = record["buckling.length"], record["euler"]
    handles = axes.plot(length, record["load"] / euler, "o", color="C0", markerfacecolor="none", label="measured")
    handles += axes.plot(length, record["engesser"] / euler, "-", color="C1", label="Engesser: thrust along the axis")
    handles += axes.plot(length, record["haringx"] / euler, ":", color="C2", label="Haringx: thrust normal to sections")
    handles.append(Line2D([], [], label="Euler", **MARK))
    axes.axhline(1, **MARK)
    axes.set_xscale("log")
    label_points(axes, length)
    axes.set_xlabel("length in spacings [1]")
    axes.set_ylabel("critical load over Euler's [1]")
    legend_above(axes, handles)
    caption = "Critical load of the pinned column over Euler's; both theories with shear are those of the compressed lattice."
    return Figure(caption, inline_svg(drawing, caption))


def standing_waves(result, record):
    """Frequency of standing waves against the wave number: measured, of the lattice with and without steps, of long waves; of a sweep over modes."""
    if not drawable(record, "wave_number", "omega", "omega_leapfrog", "omega_lattice", "omega_continuum"):
        return None
    drawing, (axes,) = canvas()
    k, top = record["wave_number"], 1.25 * extent(np.maximum(record["omega"], record["omega_lattice"]))[1]
    handles = axes.plot(k, record["omega"], "o", color="C0", markerfacecolor="none", label="measured")
    handles += axes.plot(k, record["omega_leapfrog"], "-", color="C1", label="lattice in leap-frog's steps")
    handles += axes.plot(k, record["omega_lattice"], "--", color="C2", label="lattice")
    handles += axes.plot(k, record["omega_continuum"], ":", color="C3", label="long waves")
    axes.set_xlim(left=0)
    axes.set_ylim(0, top or 1.0)
    axes.set_xlabel(column_label(record.columns["wave_number"]))
    axes.set_ylabel(quantity("angular frequency", "", record.columns["omega"].dimension))
    legend_above(axes, handles)
    caption = "Dispersion of standing waves, measured by dynamics."
    return Figure(caption, inline_svg(drawing, caption))
