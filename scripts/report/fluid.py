"""Figures of the fluid: convergence, profiles, what is kept."""

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from report.drawing import (
    Figure,
    MANY_CURVES,
    MARK,
    canvas,
    column_label,
    drawable,
    inline_svg,
    known,
    label_points,
    legend_above,
    markers,
    quantity,
)


def convergence(result, record):
    """Every column error_<name> against the first column, log-log, with the measured order (metric order_<name>)."""
    errors = [name for name in record.columns if name.startswith("error_")]
    # Many curves get a panel for each quantity, the first word of their names.
    quantities = {name.split("_")[1]: None for name in errors} if len(errors) > MANY_CURVES else {"": None}
    if not errors:
        return None
    legend_rows = len(errors) + len(quantities)  # names are long: one row each
    drawing, panels = canvas(len(quantities), height=2.0 * len(quantities) + 0.6 + 0.18 * legend_rows)
    first = next(iter(record.columns.values()))
    drawn = [
        converging(axes, result, record, first, [name for name in errors if name.startswith(f"error_{word}")])
        for axes, word in zip(panels, quantities)
    ]
    if not any(drawn):
        return None
    panels[-1].set_xlabel(column_label(first))
    caption = "Convergence; dotted: the slope of the nearest whole order, below its curve."
    return Figure(caption, inline_svg(drawing, caption))


def converging(axes, result, record, first, errors):
    """One panel of convergence(); whether there is anything to see."""
    handles = []
    for number, (name, marker) in enumerate(zip(errors, markers())):
        drawn = (record[name] > 0) & (first.values > 0) & np.isfinite(record[name])
        steps, values = first.values[drawn], record[name][drawn]
        if not len(steps):
            continue
        order = known(result, name.replace("error_", "order_", 1))
        label = name.removeprefix("error_").replace("_", " ")
        label += f": order {order:.3f}" if order is not None else ""
        colour = f"C{number}"
        handles += axes.plot(steps, values, marker + "-", color=colour, label=label)
        if order is not None and round(order) != 0:
            coarsest = steps.argmax()
            guide = 0.4 * values[coarsest] * (steps / steps[coarsest]) ** round(order)
            axes.plot(steps, guide, ":", color=colour, linewidth=1)
    if not handles:
        return False
    axes.set_xscale("log")
    axes.set_yscale("log")
    label_points(axes, np.unique(np.concatenate([line.get_xdata() for line in handles])))
    smallest = min(np.min(line.get_ydata()) for line in handles)
    largest = max(np.max(line.get_ydata()) for line in handles)
    axes.set_ylim(smallest / 5, largest * 5)  # guides go on below round-off
    axes.set_ylabel("relative error [1]")
    handles.append(Line2D([], [], linestyle=":", color="#555555", linewidth=1, label="nearest whole order"))
    legend_above(axes, handles)
    return True


def pairs(record):
    """Names of columns that have an exact counterpart `<name>_exact`."""
    return [name for name in record.columns if name + "_exact" in record.columns]


def profile(result, record):
    """Profiles (points) and exact ones (lines) against the first column; below, their difference."""
    names = pairs(record)
    if not names or len(record) < 2:
        return None
    drawing, (above, below) = canvas(2, height=4.6, sharex=True, gridspec_kw={"height_ratios": (3, 2)})
    place = next(iter(record.columns.values()))
    handles = []
    for number, (name, marker) in enumerate(zip(names, "osD^vx")):
        colour = f"C{number}"
        exact = record[name + "_exact"]
        above.plot(place.values, exact, color=colour, linestyle="-", linewidth=1)
        label = quantity(name.replace("_", " "), record.columns[name].symbol, "")
        style = dict(color=colour, marker=marker, markersize=3.5, markerfacecolor="none")
        handles += above.plot(place.values, record[name], linestyle="none", label=label, **style)
        below.plot(place.values, record[name] - exact, linestyle="-", linewidth=0.8, **style)
    handles.append(Line2D([], [], color="#555555", linestyle="-", linewidth=1, label="exact"))
    below.axhline(0, **MARK)
    below.ticklabel_format(axis="y", style="sci", scilimits=(-2, 3), useMathText=True)
    above.set_ylabel("velocity over its scale [1]")
    below.set_ylabel("difference [1]")
    below.set_xlabel(column_label(place))
    legend_above(above, handles)
    caption = f"{record.title}; below, the difference to the exact one."
    return Figure(caption, inline_svg(drawing, caption))


def section(result, record):
    """Velocity in a square section: measured as colours, exact as lines of the same levels."""
    side = round(len(record) ** 0.5)
    if not drawable(record, "y", "z", "velocity", "velocity_exact") or side * side != len(record):
        return None
    drawing, (axes,) = canvas(height=4.0)
    grid = [record[name].reshape(side, side) for name in ("y", "z", "velocity", "velocity_exact")]
    levels = np.linspace(0, 1, 11)
    drawn = axes.contourf(*grid[:3], levels=levels, cmap="Blues", extend="max")
    axes.contour(grid[0], grid[1], grid[3], levels=levels[1:-1], colors="#222222", linewidths=0.7)
    axes.set_aspect("equal")
    axes.set_xlabel(column_label(record.columns["y"]))
    axes.set_ylabel(column_label(record.columns["z"]))
    shades = zip(drawn.get_facecolors() if hasattr(drawn, "get_facecolors") else drawn.tcolors, levels)
    shades = [(shade[0] if len(shade) == 1 else shade, level) for shade, level in shades]
    legend_above(axes, [Patch(facecolor=shade, label=f"{level:.1f}") for shade, level in shades[::2]])
    caption = f"{record.title}: measured (colours, from the number on) and exact (lines, at the edges of the colours)."
    return Figure(caption, inline_svg(drawing, caption))


def drift(result, record):
    """What should not change, against time: every column, logarithmic."""
    first, *kept = record.columns.values()
    drawing, (axes,) = canvas(height=3.5)
    handles = []
    for number, column in enumerate(kept):
        # A logarithm has no place for what did not change at all.
        values = np.where(column.values > 0, column.values, np.nan)
        style = dict(marker=".", color=f"C{number}", linestyle="-", linewidth=0.9)
        label = quantity(column.name.replace("_", " "), "", column.dimension)
        handles += axes.plot(first.values, values, label=label, **style)
    axes.set_yscale("log")
    axes.set_xlabel(column_label(first))
    axes.set_ylabel("departure per node")
    legend_above(axes, handles)
    return Figure(record.title + ".", inline_svg(drawing, record.title))
