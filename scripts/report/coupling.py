"""Figures of bodies in a fluid: delta kernels, drag of markers, stability of the coupling."""

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
    known,
    label_points,
    legend_above,
    markers,
    powers,
    quantity,
)


def coupling_boundary(result, record):
    """Least stable node mass, variant by variant: runs, and the linearised exchange with and without the fluid's memory."""
    columns = ("predicted", "forgetful", "measured", "ratio")
    if not drawable(record, *columns):
        return None
    drawing, (axes, ratio) = canvas(2, height=5.4, sharex=True, gridspec_kw={"height_ratios": [2, 1]})
    x = np.arange(len(record))
    # Where all agree the marks lie on each other: each is seen beside the next.
    wide = dict(color="C1", markersize=13, markeredgewidth=1.6)
    handles = axes.plot(x, record["predicted"], "_", label="map, the fluid keeps all", **wide)
    hollow = dict(color="C2", markersize=8, markerfacecolor="none")
    handles += axes.plot(x, record["forgetful"], "D", label="map, the fluid forgets", **hollow)
    handles += axes.plot(x, record["measured"], "o", color="C0", markersize=3.5, label="runs")
    axes.set_ylabel("smallest stable node mass m [M]")
    axes.set_ylim(0, 1.08 * extent(np.concatenate([record[name] for name in columns[:3]]))[1] or 1.0)
    legend_above(axes, handles)
    ratio.axhline(1.0, **MARK)
    ratio.plot(x, record["ratio"], "o", color="C0")
    ratio.set_ylabel("runs / map [1]")
    ratio.set_xticks(x, [str(name).replace("_", " ") for name in record["variant"]])
    ratio.set_xlim(-0.5, len(record) - 0.5)
    ratio.margins(y=0.15)
    ratio.set_xlabel("way of coupling")
    caption = (
        "Smallest node mass at which the coupling of a rod to the fluid is stable: below it perturbations grow. "
        "The map is one step, linearised, without the fluid's own motion."
    )
    return Figure(caption, inline_svg(drawing, caption))


def spectrum(result, record):
    """Eigenvalues of a step in the complex plane, beside the unit circle; what grows lies outside of it."""
    if not drawable(record, "real", "imaginary", "magnitude", "bodies"):
        return None
    drawing, (axes,) = canvas(height=4.6)
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    circle = axes.plot(np.cos(angle), np.sin(angle), "-", label="|λ| = 1", **MARK)
    of_bodies = record["bodies"] > 0.5
    outside = record["magnitude"] > 1.0 + (known(result, "growth_resolution") or 0.0)
    kinds = (
        (of_bodies & outside, "bodies, grows", dict(color="C1", marker="D", markersize=5)),
        (of_bodies & ~outside, "bodies", dict(color="C0", marker="o", markersize=4)),
        (~of_bodies & outside, "fluid, grows", dict(color="C1", marker="D", markersize=6, markerfacecolor="none")),
        (~of_bodies & ~outside, "fluid", dict(color="C0", marker="o", markersize=6, markerfacecolor="none")),
    )
    handles = list(circle)
    for rows, label, style in kinds:
        if rows.any():
            handles += axes.plot(record["real"][rows], record["imaginary"][rows], linestyle="none", label=label, **style)
    most = 1.1 * max(1.0, np.nanmax(record["magnitude"]))
    axes.set_xlim(-most, most)
    axes.set_ylim(-most, most)
    axes.set_aspect("equal")
    axes.axhline(0.0, color="#cccccc", linewidth=0.6, zorder=0)
    axes.axvline(0.0, color="#cccccc", linewidth=0.6, zorder=0)
    axes.set_xlabel(column_label(record.columns["real"]))
    axes.set_ylabel(column_label(record.columns["imaginary"]))
    legend_above(axes, handles)
    caption = (
        "Eigenvalues of largest magnitude of one step of the scene about rest, without its invariants. Filled marks: most of "
        "the energy is the bodies'. Outside of the circle perturbations grow."
    )
    return Figure(caption, inline_svg(drawing, caption))


def last_good_nodes(result, record):
    """The body as it stood when it was last seen sound, from the side."""
    if not drawable(record, "y", "z"):
        return None
    drawing, (axes,) = canvas()
    axes.plot(record["y"], record["z"], ".", color="C0", markersize=3)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(column_label(record.columns["y"]))
    axes.set_ylabel(column_label(record.columns["z"]))
    step = known(result, "last_good_step")
    caption = f"The body at the last good check, step {step:.0f}." if step is not None else "The body at the last good check."
    return Figure(caption, inline_svg(drawing, caption))


DELTA_SCANS = {
    "delta_sums": ("sum of the weights Σ D h³", "Sum of the weights"),
    "delta_imbalances": ("even less odd nodes Σ ± D h³", "Weights of even nodes less those of odd ones"),
    "delta_first_moments": ("first moment Σ (x − X) D h³", "First moment of the weights along an axis"),
}


def delta_scan(result, record):
    """A moment of the delta functions' weights along the diagonal of a cell, a curve for each function."""
    offset, *deltas = record.columns.values()
    if not deltas or not drawable(record, *record.columns):
        return None
    drawing, (axes,) = canvas()
    handles = []
    for delta in deltas:
        handles += axes.plot(offset.values, delta.values, label=delta.name.replace("_", " "))
    axes.set_xlim(*extent(offset.values))
    label, words = DELTA_SCANS[record.name]
    axes.set_xlabel(quantity("offset along each axis from a node", "", offset.dimension))
    axes.set_ylabel(quantity(label, "", deltas[0].dimension))
    legend_above(axes, handles)
    caption = f"{words}, for a marker on the diagonal of a cell and each delta function."
    return Figure(caption, inline_svg(drawing, caption))


def array_drag(result, record):
    """Drag of arrays of markers against the solid fraction; below, error and slip."""
    if not drawable(record, "solid_fraction", "drag", "drag_exact", "error_drag", "slip"):
        return None
    drawing, (above, below) = canvas(2, height=5.2, sharex=True)
    order = np.argsort(record["solid_fraction"])
    fraction, drag, exact, error, slip = (record[name][order] for name in ("solid_fraction", "drag", "drag_exact", "error_drag", "slip"))
    handles = above.plot(fraction, exact, "-", color="#555555", linewidth=1, label="series")
    handles += above.plot(fraction, drag, "o", color="C0", label="markers")
    predicted = error > 1e-9  # the first is zero by the fit
    kinds = below.plot(fraction[predicted], error[predicted], "o-", color="C0", label="error of the drag")
    kinds += below.plot(fraction, slip, "o:", color="C0", markerfacecolor="none", label="slip over U")
    above.set_ylabel(column_label(record.columns["drag"]))
    below.set_yscale("log")
    below.set_ylabel("relative error, slip [1]")
    below.set_xlabel(column_label(record.columns["solid_fraction"]))
    legend_above(above, handles)
    legend_above(below, kinds)
    caption = f"{record.title}; below, error of the predicted drags and slip at the markers."
    return Figure(caption, inline_svg(drawing, caption))


def rod_force(result, record):
    """Force of an oscillating rod over theory against the box, for each period; without (open) and with what the box gives back."""
    names = ("ratio_unbounded", "ratio", "lead_unbounded", "lead")
    if not drawable(record, "box", "period", "amplitude", *names):
        return None
    small = record["amplitude"] == record["amplitude"][0]
    unit = powers(record.columns["period"].dimension)
    drawing, (above, below) = canvas(2, height=5.0, sharex=True)
    handles = []
    for number, (period, marker) in enumerate(zip(np.unique(record["period"]), markers())):
        rows = np.flatnonzero(small & (record["period"] == period))
        box, style = record["box"][rows], dict(color=f"C{number}", marker=marker)
        handles += above.plot(box, record["ratio"][rows], "-", label=f"period {period:g} [{unit}]", **style)
        above.plot(box, record["ratio_unbounded"][rows], ":", markerfacecolor="none", **style)
        below.plot(box, record["lead"][rows], "-", **style)
        below.plot(box, record["lead_unbounded"][rows], ":", markerfacecolor="none", **style)
    handles.append(Line2D([], [], color="#555555", linestyle="-", label="theory for the box"))
    handles.append(Line2D([], [], color="#555555", linestyle=":", label="unbounded fluid"))
    above.axhline(1, **MARK)
    below.axhline(0, **MARK)
    for axes in (above, below):
        axes.margins(y=0.08)
    below.set_xticks(np.unique(record["box"][small]))
    above.set_ylabel("amplitude over theory [1]")
    below.set_ylabel("phase before theory [rad]")
    below.set_xlabel(quantity("side of the periodic box", "", record.columns["box"].dimension))
    legend_above(above, handles)
    caption = (
        "Force of the oscillating rod over that of Stokes' cylinder of the fitted radius, at an amplitude of "
        f"{record['amplitude'][0]:g} [{powers(record.columns['amplitude'].dimension)}]."
    )
    return Figure(caption, inline_svg(drawing, caption))


def beam_line(result, record):
    """Deflection of the rod in a stream and of beams under its load; below, the load."""
    if not drawable(record, "place", "deflection", "beam", "beam_without_shear", "force"):
        return None
    drawing, (above, below) = canvas(2, height=4.6, sharex=True, gridspec_kw={"height_ratios": (3, 2)})
    place = record["place"]
    handles = above.plot(place, record["beam"], "-", color="C0", label="Timoshenko's beam")
    handles += above.plot(place, record["beam_without_shear"], ":", color="#555555", label="without shear")
    handles += above.plot(place, record["deflection"], "o", color="C1", markersize=3.5, label="rod in the stream")
    below.plot(place[1:], record["force"][1:], "o-", color="C1", markersize=3.5)
    above.set_ylabel("deflection [L]")
    below.set_ylabel(quantity("force", "", record.columns["force"].dimension))
    below.set_xlabel(column_label(record.columns["place"]))
    legend_above(above, handles)
    caption = "Deflection of the clamped rod, and of a beam under the forces on its sections (below)."
    return Figure(caption, inline_svg(drawing, caption))


def beside_theory(record, along, measured, theory, points):
    """A figure and its axes: a column against another in `points`, and that of theory, called `theory`; None where one is missing."""
    if not drawable(record, along, measured, "theory"):
        return None
    drawing, (axes,) = canvas()
    handles = axes.plot(record[along], record["theory"], "-", color="#222222", linewidth=1.2, label=theory)
    handles += axes.plot(record[along], record[measured], color="C0", linestyle="none", label="measured", **points)
    axes.set_xlabel(column_label(record.columns[along]))
    axes.set_ylabel(column_label(record.columns[measured]))
    legend_above(axes, handles)
    return drawing, axes


def buckling_mode(result, record):
    """The buckling filament at the end of its run, and the mode of theory."""
    drawn = beside_theory(record, "place", "measured", "mode of the chain of markers", {"marker": "o", "markerfacecolor": "none"})
    if drawn is None:
        return None
    drawn[1].axhline(0, **MARK)
    caption = f"{record.title}."
    return Figure(caption, inline_svg(drawn[0], caption))


def buckling_share(result, record):
    """How the buckling mode grows or decays, and the exponential of theory; where it is fitted it should be one."""
    drawn = beside_theory(record, "strain", "share", "theory", {"marker": ".", "markersize": 3})
    if drawn is None:
        return None
    drawn[1].set_yscale("log")
    caption = f"{record.title}."
    return Figure(caption, inline_svg(drawn[0], caption))


def buckling_growth(result, record):
    """Growth of a filament's buckling mode against the strength of the flow; of a sweep over it."""
    names = ("growth", "growth_markers", "growth_slender")
    if not drawable(record, "eta", *names):
        return None
    order = np.argsort(record["eta"])
    eta, growth, of_markers, slender = (record[name][order] for name in ("eta", *names))
    drawing, (axes,) = canvas()
    handles = axes.plot(eta, slender, "o:", color="C1", markerfacecolor="none", label="slender body, uniform strain")
    handles += axes.plot(eta, of_markers, "-", color="#222222", linewidth=1.2, label="chain of markers between the rolls")
    handles += axes.plot(eta, growth, "o", color="C0", label="measured")
    axes.axhline(0, **MARK)
    axes.set_xscale("log")
    label_points(axes, eta)
    axes.set_xlabel(column_label(record.columns["eta"]))
    axes.set_ylabel("growth over rate of strain [1]")
    legend_above(axes, handles)
    caption = "Growth of the first buckling mode of a free filament between four rolls: above zero it buckles."
    return Figure(caption, inline_svg(drawing, caption))


def thrust_stroke(result, record):
    """The filament driven at one end when the drive is at its most and a quarter of a period later, and the chain of theory."""
    moments = {"with": "drive at its most", "after": "a quarter of a period later"}
    if not drawable(record, "place", *moments, *(f"{name}_theory" for name in moments)):
        return None
    drawing, (axes,) = canvas()
    handles = [Line2D([], [], color="#222222", linewidth=1.2, label="chain of markers, theory")]
    for colour, (name, label) in zip(("C0", "C1"), moments.items()):
        axes.plot(record["place"], record[f"{name}_theory"], "-", color="#222222", linewidth=1.2)
        handles += axes.plot(record["place"], record[name], "o", color=colour, markerfacecolor="none", label=label)
    axes.axhline(0, **MARK)
    axes.set_xlabel(column_label(record.columns["place"]))
    axes.set_ylabel("displacement over drive [1]")
    legend_above(axes, handles)
    caption = f"{record.title}."
    return Figure(caption, inline_svg(drawing, caption))


def thrust_law(result, record):
    """Thrust against the sperm number by two theories, with what was measured: the run, or the rows of a sweep with one drive."""
    drives = ("hinged", "clamped", "angle")
    names = ("sperm_number", "scaled_thrust", "scaled_thrust_markers", "scaled_thrust_slender")
    if not drawable(record, "sperm_number", *drives, "markers"):
        return None
    rows = result.records.get("sweep")
    if rows is None:
        at, measured, of_markers, slender = (np.array([result.metric(name)], float) for name in names)
    elif drawable(rows, *names):
        at, measured, of_markers, slender = (rows[name] for name in names)
    else:
        return None
    sperm_number = record["sperm_number"]

    def distance(name, points):
        return np.abs(np.interp(at, sperm_number, record[name]) - points).max()

    drive = min(drives, key=lambda name: distance(name, slender))
    near = 0.05
    if not distance(drive, slender) < near:  # rows with several drives
        return None
    drawing, (axes,) = canvas()
    handles = axes.plot(sperm_number, record[drive], ":", color="C1", label=f"slender body, {drive}")
    # The curve is that of the last row; where others are in another box, theory is a mark for each.
    if distance("markers", of_markers) < near:
        handles += axes.plot(sperm_number, record["markers"], "-", color="#222222", linewidth=1.2, label="chain of markers in this box")
    else:
        handles += axes.plot(at, of_markers, "x", color="#222222", markersize=7, label="chain of markers in its box")
    handles += axes.plot(at, measured, "o", color="C0", markerfacecolor="none", label="measured")
    axes.axhline(0, **MARK)
    axes.set_xlabel(column_label(record.columns["sperm_number"]))
    axes.set_ylabel("thrust over that of an endless filament Y [1]")
    legend_above(axes, handles)
    caption = "Thrust of a filament driven at one end, the more flexible it is: measured, and by two theories."
    return Figure(caption, inline_svg(drawing, caption))
