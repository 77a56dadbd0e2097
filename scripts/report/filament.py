"""Figures of the driven filament: centre lines, the distance of the laws, the stroke, the flow."""

import numpy as np
from matplotlib import figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, MaxNLocator

from report.drawing import (
    Figure,
    MARK,
    WIDTH,
    canvas,
    column_label,
    draw_speed,
    drawable,
    extent,
    inline_svg,
    legend_above,
    legend_of_speed,
    limits,
    panels_of,
    powers,
    quantity,
    upright,
)


def compared_names(result):
    """Names of the two laws of a filament: the ends of the strokes' titles, or the tables of the case."""
    names = []
    for record, table in (("stroke", "law of [bond]"), ("stroke_compared", "law of [compared_bond]")):
        title = result.records[record].title if record in result.records else ""
        names.append(title.rpartition(", ")[2] if ", " in title else table)
    return names if names[0] != names[1] else [names[0], names[1] + ", compared"]


# The law of [bond] and the one it is compared with, in every figure of the filament.
COMPARED_STYLES = (dict(color="C0", linestyle="-", linewidth=1.4), dict(color="C1", linestyle="--", linewidth=1.4))

FIGURE_PHASES = (0.25, 0.5, 0.75, 1.0)  # of the last period


def centre_lines(result, record):
    """Centre lines of both filaments at four phases, equally scaled along both axes."""
    columns = ("phase", "y", "z", "y_compared", "z_compared")
    if not drawable(record, *columns):
        return None
    # Phases lie on eighths of the period: a tenth of that tells them apart.
    phases = [phase for phase in FIGURE_PHASES if np.any(np.abs(record["phase"] - phase) < 0.01)]
    if not phases:
        return None
    along = limits(np.concatenate([record["y"], record["y_compared"]]))
    across = limits(np.concatenate([record["z"], record["z_compared"]]), margin=0.08)
    unit = (WIDTH - 0.7) / np.ptp(along)  # inches per spacing, beside the ordinate's labels
    height = min(len(phases) * (unit * np.ptp(across) + 0.12) + 0.95, 9.0)
    drawing, panels = canvas(len(phases), height=height, sharex=True, sharey=True)
    for axes, phase in zip(panels, phases):
        rows = np.abs(record["phase"] - phase) < 0.01
        handles = []
        for ending, name, style in zip(("", "_compared"), compared_names(result), COMPARED_STYLES):
            handles += axes.plot(record["y" + ending][rows], record["z" + ending][rows], label=name, **style)
        axes.set_xlim(*along)
        axes.set_ylim(*across)
        axes.set_aspect("equal")
        above = np.mean(record["z"][rows][: max(1, rows.sum() // 3)]) > np.mean(across)
        axes.text(
            0.01, 0.04 if above else 0.96, f"t = {phase:g} T", transform=axes.transAxes,
            verticalalignment="bottom" if above else "top",
        )  # fmt: skip
        axes.set_ylabel(quantity("z", "", record.columns["z"].dimension))
    legend_above(panels[0], handles)
    panels[-1].set_xlabel(quantity("y", "", record.columns["y"].dimension))
    caption = "Centre lines in the last period, in the laboratory; both axes to one scale. The end at larger y is driven."
    return Figure(caption, inline_svg(drawing, caption))


STRIP_ROOM = 14  # spacings that are shown around the filament


def strip(result):
    """The filament over one period, for the first screen: both centre lines at four phases, over the speed of the fluid if it was kept."""
    lines, film = result.records.get("centre_lines"), result.records.get("film")
    columns = ("phase", "y", "z", "y_compared", "z_compared")
    phases = [phase for phase in FIGURE_PHASES if drawable(lines, *columns) and np.any(np.abs(lines["phase"] - phase) < 0.01)]
    if not phases:
        return None
    box = [(extent(lines[name])[0] - STRIP_ROOM, extent(lines[name])[1] + STRIP_ROOM) for name in ("y", "z")]
    with_flow = drawable(film, "phase", "y", "z", "speed")
    rows = -(-len(phases) // 2)
    tall = 0.5 * (WIDTH - 0.8) * np.ptp(box[1]) / np.ptp(box[0])
    drawing = figure.Figure(figsize=(WIDTH, min(rows * (tall + 0.12) + 0.7, 5.0)))
    panels = panels_of(drawing, rows, 2, sharex=True, sharey=True)
    top = extent(film["speed"])[1] if with_flow else 1.0
    for axes, phase in zip(panels.flat, phases):
        if with_flow:
            frame = (np.abs(film["phase"] - phase) < 0.01) & (box[0][0] <= film["y"]) & (film["y"] <= box[0][1])
            frame &= (box[1][0] <= film["z"]) & (film["z"] <= box[1][1])
            y, z = np.unique(film["y"][frame]), np.unique(film["z"][frame])
            if len(y) > 1 and len(y) * len(z) == frame.sum():
                order = np.lexsort((film["y"][frame], film["z"][frame]))
                seen = film["speed"][frame][order].reshape(len(z), len(y))
                edges = (y[0] - 0.5, y[-1] + 0.5, z[0] - 0.5, z[-1] + 0.5)
                draw_speed(axes, seen, edges, top)
        there = np.abs(lines["phase"] - phase) < 0.01
        handles = []
        for ending, name, style in zip(("", "_compared"), compared_names(result), COMPARED_STYLES):
            handles += axes.plot(lines["y" + ending][there], lines["z" + ending][there], label=name, **style)
        axes.set_xlim(*box[0])
        axes.set_ylim(*box[1])
        axes.set_aspect("equal")
        axes.text(0.03, 0.9, f"t = {phase:g} T", transform=axes.transAxes, verticalalignment="top")
        axes.grid_along = set()
    legend_above(panels[0, 0], handles)
    for axes in panels[-1]:
        axes.set_xlabel(quantity("y", "", lines.columns["y"].dimension))
    for axes in panels[:, 0]:
        axes.set_ylabel(quantity("z", "", lines.columns["z"].dimension))
    caption = f"Centre lines of both laws over one period{', over the speed of the fluid' if with_flow else ''}. {result.title}."
    return Figure(caption, inline_svg(drawing, caption))


DEVIATIONS = {
    "z_max": "largest |Δz|",
    "z_rms": "rms Δz",
    "lab_max": "largest |d|",
    "swimming_max": "largest |d|, swimming taken out",
}


def law_deviation(result, record):
    """Distance of both laws' centre lines over the amplitude, as bars for each phase."""
    names = [name for name in DEVIATIONS if record.has(name)]
    if not names or not drawable(record, "phase"):
        return None
    drawing, (axes,) = canvas(height=3.4)
    places, width = np.arange(len(record)), 0.8 / len(names)
    handles = []
    for number, name in enumerate(names):
        shift = (number - (len(names) - 1) / 2) * width
        style = dict(facecolor=f"C{number}", linewidth=0)
        axes.bar(places + shift, record[name], 0.9 * width, **style)
        handles.append(Patch(label=DEVIATIONS[name], **style))
    axes.grid_along = {"y"}
    axes.set_xticks(places, [f"{phase:g}" for phase in record["phase"]])
    axes.set_xlabel("time in the last period t/T [1]")
    axes.set_ylabel("distance over amplitude z₀ [1]")
    legend_above(axes, handles)
    caption = "How far the two laws' centre lines are apart. d is the distance of nodes, Δz its part along the drive."
    return Figure(caption, inline_svg(drawing, caption))


def stroke(result, record):
    """The stroke in time, one panel per quantity, with that of the compared law."""
    labels = {
        "drive": "drive z", "force": "force F", "centre_y": "displacement Y", "slip": "slip",
        "max_strain": "bond strain",
    }  # fmt: skip
    if not drawable(record, "time", "min_strain", *labels):
        return None
    other = result.records.get("stroke_compared")
    runs = [record] + ([other] if drawable(other, "time", "min_strain", *labels) else [])
    drawing, panels = canvas(len(labels), height=7.6, sharex=True)
    for axes, (name, label) in zip(panels, labels.items()):
        handles = []
        for run, law, style in zip(runs, compared_names(result), COMPARED_STYLES):
            handles += axes.plot(run["time"], run[name], label=law, **style)
            if name == "max_strain":
                axes.plot(run["time"], run["min_strain"], **style)
        if name != "slip":
            axes.axhline(0, **{**MARK, "linewidth": 0.6})
        unit = powers(record.columns[name].dimension)
        axes.set_ylabel(f"{label}\n[{unit}]")
        axes.locator_params(axis="y", nbins=5)
    legend_above(panels[0], handles)
    panels[-1].set_xlabel("time in periods t/T [1]")
    caption = (
        "The stroke: displacement and force of the drive, displacement of the centre of mass along the filament, slip of "
        "the coupled nodes (root mean square), smallest and largest strain of any bond."
    )
    return Figure(caption, inline_svg(drawing, caption))


def strain_histogram(result, record):
    """Share of bonds and times for each bond length, logarithmic."""
    if not drawable(record, "length", "share", "share_compared"):
        return None
    drawing, (axes,) = canvas()
    length = record["length"]
    handles = []
    for name, law, style in zip(("share", "share_compared"), compared_names(result), COMPARED_STYLES):
        # A logarithm has no place for empty bins.
        share = np.where(record[name] > 0, record[name], np.nan)
        handles += axes.step(length, share, where="mid", label=law, **style)
    filled = (record["share"] > 0) | (record["share_compared"] > 0)
    if not filled.any():
        return None
    handles.append(upright(axes, 1, "lattice spacing", linestyle=":"))
    bin_width = np.ptp(length) / (len(length) - 1)
    axes.set_xlim(length[filled].min() - 2 * bin_width, length[filled].max() + 2 * bin_width)
    axes.set_yscale("log")
    axes.set_xlabel("bond length over lattice spacing r/r₀ [1]")
    axes.set_ylabel(f"share per bin of {bin_width:.3g} [1]")
    legend_above(axes, handles)
    caption = "Bond lengths over all bonds and the last period. A bin without a bond is not drawn."
    return Figure(caption, inline_svg(drawing, caption))


def modulus_deviation(result, record):
    """Distance that a wrong modulus makes, with the distance between the laws as a level of the same colour."""
    names = [name for name in DEVIATIONS if record.has(name)]
    if not names or not drawable(record, "factor", *names):
        return None
    # Both are the largest of the same four phases.
    laws_apart = result.records.get("law_deviation")
    drawing, (axes,) = canvas(height=3.6)
    # With the right modulus the run is compared with itself: zero, whether or not it was run again.
    factor, distinct = np.unique(np.append(record["factor"], 1.0), return_index=True)
    handles = []
    for name, marker, colour in zip(DEVIATIONS, "os^D", ("C0", "C1", "C2", "C3")):
        if name not in names:
            continue
        style = dict(color=colour, linestyle="-", linewidth=1.1, markerfacecolor="none")
        handles += axes.plot(factor, np.append(record[name], 0.0)[distinct], marker, label=DEVIATIONS[name], **style)
        if laws_apart is not None and laws_apart.has(name):
            level = extent(laws_apart[name])[1]
            axes.axhline(level, color=colour, linestyle="--", linewidth=1.1)
    if laws_apart is not None:
        handles.append(Line2D([], [], color="#555555", linestyle="--", linewidth=1.1, label="between the two laws"))
    axes.axvline(1, **{**MARK, "linestyle": ":"})
    axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    axes.set_xlabel("modulus over the right one E′/E [1]")
    axes.set_ylabel("distance over amplitude z₀ [1]")
    legend_above(axes, handles)
    caption = (
        "Centre lines of one law with a wrong modulus against its own, largest of four phases. Where a curve stays below "
        "the dashed level of its colour, that error of the modulus moves the filament less than the change of the law."
    )
    return Figure(caption, inline_svg(drawing, caption))


FILM_COLUMNS = 2  # of panels

FILM_ROOM = 40  # spacings of the flow that are shown around the filament

FILM_SAMPLES = 200  # across a panel at most: more would be finer than the page and heavier than it may be

def film(result, record):
    """Speed of the fluid in the plane of the stroke, a panel for each phase, under the centre line of that phase."""
    if not drawable(record, "phase", "y", "z", "speed"):
        return None
    phases, y, z = (np.unique(record[name]) for name in ("phase", "y", "z"))
    if len(y) < 2 or len(z) < 2 or len(phases) * len(y) * len(z) != len(record):
        return None
    order = np.lexsort((record["y"], record["z"], record["phase"]))
    speed = record["speed"][order].reshape(len(phases), len(z), len(y))
    lines = result.records.get("centre_lines")
    with_line = drawable(lines, "phase", "y", "z")
    if with_line:  # in a large box the filament would be a dot: what is around it is shown
        near = [
            np.abs(axis - np.mean(extent(lines[name]))) < np.ptp(lines[name]) / 2 + FILM_ROOM
            for axis, name in ((y, "y"), (z, "z"))
        ]
        if all(axis.sum() >= 2 for axis in near):
            y, z, speed = y[near[0]], z[near[1]], speed[:, near[1]][:, :, near[0]]
    every = -(-len(y) // FILM_SAMPLES)
    speed = speed[:, ::every, ::every]
    y, z = y[::every], z[::every]
    half = 0.5 * (y[1] - y[0]), 0.5 * (z[1] - z[0])  # a sample is the middle of its square
    box = (y[0] - half[0], y[-1] + half[0], z[0] - half[1], z[-1] + half[1])
    rows = -(-len(phases) // FILM_COLUMNS)
    tall = 0.5 * (WIDTH - 0.7) * (box[3] - box[2]) / (box[1] - box[0])  # inches of a panel
    drawing = figure.Figure(figsize=(WIDTH, min(rows * (tall + 0.12) + 1.0, 9.0)))
    panels = panels_of(drawing, rows, FILM_COLUMNS, sharex=True, sharey=True)
    top = extent(speed)[1]
    for axes, phase, seen in zip(panels.flat, phases, speed):
        scale = draw_speed(axes, seen, box, top)
        if with_line:
            there = np.abs(lines["phase"] - phase) < 0.01
            axes.plot(lines["y"][there], lines["z"][there], color="C1", linestyle="-", linewidth=1.3)
        axes.text(0.03, 0.96, f"t = {phase:g} T", transform=axes.transAxes, verticalalignment="top")
        axes.set_xlim(box[0], box[1])
        axes.set_ylim(box[2], box[3])
        axes.grid_along = set()
    for axes in panels.flat[len(phases) :]:
        axes.set_visible(False)
    for axes in panels[-1]:
        axes.set_xlabel(column_label(record.columns["y"]))
    for axes in panels[:, 0]:
        axes.set_ylabel(column_label(record.columns["z"]))
    ticks = MaxNLocator(4, steps=(1, 2, 5, 10)).tick_values(0.0, scale.vmax)
    ticks = sorted({tick for tick in (ticks[1] / 10, ticks[1] / 3, *ticks) if tick <= scale.vmax})
    legend_of_speed(panels[0, 0], scale, ticks)
    panels[0, 0].set_title(column_label(record.columns["speed"]), loc="left")
    caption = (
        f"{record.title or 'Speed of the fluid'} at {len(phases)} phases of the last period; both axes to one scale, colours by the root of the "
        "speed."
    )
    if with_line:
        caption += f" The line is the centre line of the filament, {compared_names(result)[0]}."
    return Figure(caption, inline_svg(drawing, caption))


def first_harmonic(result, record):
    """Amplitude and phase along the filament: of both laws measured, and of the theories the record holds."""
    if not drawable(record, "section", "amplitude", "phase"):
        return None
    theories = {
        "rings": ("theory, unsteady flow of all sections", "C2", "--"),
        "cylinder": ("theory, Stokes' cylinder", "C3", ":"),
        "resistive": ("theory, steady resistive force", "C4", (0, (6, 1.5, 1, 1.5))),
    }
    drawing, panels = canvas(2, height=5.4, sharex=True)
    section = record["section"]
    law, compared = compared_names(result)
    for axes, name in zip(panels, ("amplitude", "phase")):
        handles = axes.plot(section, record[name], "-", color="C0", linewidth=1.8, label=f"measured, {law}")
        if record.has(f"{name}_compared"):
            style = dict(color="C1", markersize=3.5, markerfacecolor="none", label=f"measured, {compared}")
            handles += axes.plot(section, record[f"{name}_compared"], "o", **style)
        for theory, (label, colour, dashes) in theories.items():
            if record.has(f"{name}_{theory}"):
                style = dict(color=colour, linestyle=dashes, linewidth=1.3, label=label)
                handles += axes.plot(section, record[f"{name}_{theory}"], **style)
    panels[0].set_ylim(bottom=0)
    panels[0].set_ylabel("amplitude over drive |W| [1]")
    panels[1].set_ylabel("phase arg W [rad]")
    panels[1].set_xlabel("section, 0 is the free end [1]")
    legend_above(panels[0], handles)
    caption = "First harmonic of the stroke along the filament over that of the drive, W = 1 at the driven end."
    return Figure(caption, inline_svg(drawing, caption))


def variant_names(result, record):
    """Variants of a record `sensitivity` in words, without the base: what metrics effect_<name> say after a colon."""
    stated = [metric.meaning.partition(": ")[2] for metric in result.metrics if metric.name.startswith("effect_")]
    if len(stated) != len(record) - 1:
        return [f"variant {number:g}" for number in record["variant"][1:]]
    # Where a run broke off, why follows in brackets: too long for a label.
    return [text if held else text.partition(" (")[0] for text, held in zip(stated, record["survived"][1:])]


def sensitivity(result, record):
    """Effect of each variant and the distance between the laws under it, largest effect first, logarithmic."""
    if not drawable(record, "variant", "survived", "law_deviation_z") or not record.has("effect_z") or len(record) < 2:
        return None
    names = variant_names(result, record)
    effect, apart, survived = (record[name][1:] for name in ("effect_z", "law_deviation_z", "survived"))
    order = np.argsort(np.where(survived > 0, effect, -1.0), kind="stable")
    places = np.arange(len(order))
    effect, apart, survived = effect[order], apart[order], survived[order]
    # A logarithm has no place for zero.
    moved, parted = np.where(effect > 0, effect, np.nan), np.where(apart > 0, apart, np.nan)
    drawing, (axes,) = canvas(height=1.25 + 0.2 * len(order))
    base = record["law_deviation_z"][0]
    handles = axes.plot(moved, places, "o", color="C0", label="one law, from the base")
    handles += axes.plot(parted, places, "s", color="C1", markerfacecolor="none", label="between the laws")
    handles.append(upright(axes, base, "the same, base", color="C1", linestyle="--"))
    axes.set_xscale("log")
    low, high = extent(np.concatenate([moved, parted, [base]]))
    axes.set_xlim(low / 2, 2 * high)
    for place, held, far in zip(places, survived, effect):
        if not held or far == 0:
            words = "broke off" if not held else "from the base: 0"
            axes.text(0.01, place, words, transform=axes.get_yaxis_transform(), verticalalignment="center", fontsize=8)
    axes.set_ylim(-0.7, len(order) - 0.3)
    axes.set_yticks(places, [names[place] for place in order])
    axes.tick_params(axis="y", length=0)
    axes.xaxis.set_major_locator(LogLocator(numticks=12))
    axes.set_xlabel("largest |Δz| over amplitude z₀ [1]")
    legend_above(axes, handles)
    caption = (
        "What each variant of the scene moves: the law of [bond] against itself in the base's scene, and the two laws "
        "against each other under the variant. A choice whose dot is left of the dashed line moves the filament less than "
        "the change of the law."
    )
    return Figure(caption, inline_svg(drawing, caption))
