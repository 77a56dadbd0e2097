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
    """Tip of the bent beam, one marker per length, on the curve of the elastica; deflection above, reach below."""
    exact = result.records.get("elastica_exact")
    if not drawable(record, "length", "load", "deflection", "reach") or not drawable(exact, "load", "deflection", "reach"):
        return None
    drawing, panels = canvas(2, height=5.0, sharex=True)
    lengths = np.unique(record["length"])
    for axes, name in zip(panels, ("deflection", "reach")):
        handles = axes.plot(exact["load"], exact[name], "-", color="#222222", linewidth=1.2, label="elastica")
        for number, (length, marker) in enumerate(zip(lengths, "os^Dvx*P")):
            rows = record["length"] == length
            handles += axes.plot(
                record["load"][rows], record[name][rows], marker, color=f"C{number % 6}", linestyle="none",
                markerfacecolor="none", label=f"L = {length:.4g}",
            )  # fmt: skip
        axes.set_ylabel(f"{name} over length [1]")
    legend_above(panels[0], handles)
    panels[-1].set_xlabel(column_label(record.columns["load"]))
    caption = "Tip of the clamped beam under a dead load: along the load (above) and along the undeformed axis (below)."
    return Figure(caption, inline_svg(drawing, caption))


def buckling(result, record):
    """Critical load over Euler's against slenderness, beside the two theories with shear."""
    if not drawable(record, "length", "load", "euler", "engesser", "haringx"):
        return None
    drawing, (axes,) = canvas()
    length, euler = record["length"], record["euler"]
    handles = axes.plot(length, record["load"] / euler, "o", color="C0", markerfacecolor="none", label="measured")
    handles += axes.plot(length, record["engesser"] / euler, "-", color="C1", label="Engesser: thrust along the axis")
    handles += axes.plot(length, record["haringx"] / euler, ":", color="C2", label="Haringx: thrust normal to sections")
    handles.append(Line2D([], [], label="Euler", **MARK))
    axes.axhline(1, **MARK)
    axes.set_xscale("log")
    label_points(axes, length)
    axes.set_xlabel(column_label(record.columns["length"]))
    axes.set_ylabel("critical load over Euler's [1]")
    legend_above(axes, handles)
    caption = "Critical load of the pinned column over Euler's; both theories with shear are those of the compressed lattice."
    return Figure(caption, inline_svg(drawing, caption))


def standing_waves(result, record):
    """Frequency of standing waves against the wave number: measured, of the lattice with and without steps, of long waves."""
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
