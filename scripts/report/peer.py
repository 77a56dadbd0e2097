"""Figures of comparisons with another program."""

import numpy as np

from report.drawing import Figure, MARKED_ROWS, canvas, column_label, drawable, inline_svg, legend_above


def error_lines(axes, record, x, names):
    """Errors that are not zero, on a logarithmic ordinate, with the meaning of each in the legend."""
    for place, name in enumerate(names):
        if not drawable(record, name):
            continue
        error = np.abs(record[name])
        some = error > 0
        label = name.replace("_", " ")
        style = "o-" if len(x) <= MARKED_ROWS else "-"
        axes.semilogy(x[some], error[some], style, color=f"C{place}", markersize=3, label=label)
    axes.set_ylabel("relative error [1]")
    axes.margins(y=0.15)


def against_peer(x, ours, peer, errors, caption):
    """A kind of plot: one column of this program and of its peer over a panel of errors; grey where a row does not count."""

    def draw(result, record):
        if not drawable(record, x, ours, peer):
            return None
        drawing, (top, below) = canvas(panels=2, height=5.2)
        handles = top.plot(record[x], record[ours], "-", color="C0", label="this program")
        handles += top.plot(record[x], record[peer], "o", color="C1", markersize=4, fillstyle="none", label="peer")
        top.set_ylabel(column_label(record.columns[ours]))
        legend_above(top, handles)
        error_lines(below, record, record[x], errors)
        if record.has("clamped"):
            left_out = record["clamped"] != 0
            for panel in (top, below):
                for place in record[x][left_out]:
                    panel.axvline(place, color="#BBBBBB", linewidth=0.8, zorder=0)
        if below.get_legend_handles_labels()[0]:
            legend_above(below, below.get_legend_handles_labels()[0])
        below.set_xlabel(column_label(record.columns[x]))
        return Figure(caption, inline_svg(drawing, caption))

    return draw


def node_forces(result, record):
    """Error of the force on each node against the force, with the parts of bonds and angles."""
    if not drawable(record, "peer_force", "force_error", "bond_force_error", "angle_force_error"):
        return None
    drawing, (axes,) = canvas(height=3.7)
    for place, name in enumerate(("force_error", "bond_force_error", "angle_force_error")):
        some = record[name] > 0
        label = name.replace("_", " ")
        force, error = record["peer_force"][some], record[name][some]
        axes.semilogy(force, error, "os^"[place], color=f"C{place}", markersize=3, label=label)
    axes.set_xlabel(column_label(record.columns["peer_force"]))
    axes.set_ylabel("error over the largest force [1]")
    if axes.get_legend_handles_labels()[0]:
        legend_above(axes, axes.get_legend_handles_labels()[0])
    caption = "Distance of the force vectors of this program and its peer, node by node; errors of zero are not drawn."
    return Figure(caption, inline_svg(drawing, caption))


def trajectory(result, record):
    """How two computations of one motion part: errors of position and velocity against the step."""
    if not drawable(record, "step", "position_error", "velocity_error"):
        return None
    drawing, (axes,) = canvas(height=3.5)
    later = record["step"] > 0
    for place, name in enumerate(("position_error", "velocity_error")):
        some = later & (record[name] > 0)
        label = name.replace("_", " ")
        axes.loglog(record["step"][some], record[name][some], "o-", color=f"C{place}", markersize=3, label=label)
    axes.set_xlabel(column_label(record.columns["step"]))
    axes.set_ylabel("largest relative error of a node [1]")
    if axes.get_legend_handles_labels()[0]:
        legend_above(axes, axes.get_legend_handles_labels()[0])
    caption = "Growth of the difference of two programs: rounding, carried on by the motion. Zeros are not drawn."
    return Figure(caption, inline_svg(drawing, caption))


TENSILE_ERRORS = ("force_error", "last_layer_error", "energy_error")
BEAM_ERRORS = ("tip_error", "reaction_error", "energy_error")

bond_table = against_peer(
    "r",
    "force",
    "peer_force",
    ("force_error", "energy_error"),
    "Force of one bond. Grey: there the peer does not compute the stated potential.",
)
angle_table = against_peer(
    "theta",
    "force",
    "peer_force",
    ("force_error", "energy_error"),
    "Force of one angle. Grey: there the peer does not compute the stated potential.",
)
end_force = against_peer("strain", "force", "peer_force", TENSILE_ERRORS, "Tensile curves of both programs.")
cantilever = against_peer("load", "deflection", "peer_deflection", BEAM_ERRORS, "Deflection of the last layer.")
energy = against_peer(
    "step",
    "change",
    "peer_change",
    ("energy_error",),
    "Change of the total energy of a free motion: leap-frog keeps it within bounds.",
)
