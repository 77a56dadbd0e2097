"""What the figures of all subjects share: the canvas, inline SVG, labels, limits."""

import re
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path

import matplotlib
import matplotlib.style
import numpy as np
from matplotlib import figure, ticker
from matplotlib.colors import PowerNorm
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from report import svg
from report.panel import Panel
from report.text import RAISED, raised

# The defaults first: a user's own matplotlibrc must not change the report.
matplotlib.style.use(["default", str(Path(__file__).with_name("style.mplstyle"))])

WIDTH, HEIGHT = 4.8, 3.3  # inches
NARROW, TALL = 3.3, 2.4  # of the panels of the first screen
MARK = dict(color="#555555", linewidth=0.9)
MANY_CURVES = 8  # more than these are drawn in a panel for each quantity
FEW_ROWS, MARKED_ROWS = 6, 41  # fewer rows than these draw no curve; draw their points too


@dataclass(frozen=True)
class Figure:
    caption: str
    svg: str


def known(result, name):
    """Value of a metric, None where the case has no such metric or it is not finite."""
    value = result.metric(name)
    return value if value is not None and np.isfinite(value) else None


def drawable(record, *names):
    """Whether a record is there and has these columns, each with at least two finite numbers."""
    return (
        record is not None
        and record.has(*names)
        and all(record[name].dtype.kind in "iuf" and np.isfinite(record[name]).sum() >= 2 for name in names)
    )


def powers(dimension):
    """Dimension with raised exponents: "M L^-1 T^-2" as "M L⁻¹ T⁻²"."""
    return re.sub(r"\^([-+]?[0-9.]+)", lambda found: found.group(1).translate(RAISED), dimension)


def quantity(name, symbol, dimension):
    """Axis label: name, symbol, dimension. A dollar sign would start matplotlib's formulas."""
    unit = f" [{powers(dimension)}]" if dimension else ""
    return (f"{name} {symbol}" if symbol != name else name).strip().replace("$", r"\$") + unit


def column_label(column):
    return quantity(column.name.replace("_", " "), column.symbol, column.dimension)


class LogLabels(ticker.LogFormatterSciNotation):
    """Labels of a logarithmic axis as plain text: a formula costs as much time as all else of a figure."""

    def __call__(self, x, pos=None):
        text = super().__call__(x, pos)
        text = text.removeprefix(r"$\mathdefault{").removesuffix("}$").replace(r"\times", "×").replace(r"\,", "")
        return re.sub(r"\^\{([-−0-9]+)\}", lambda found: found.group(1).translate(RAISED), text)


class Labels(ticker.ScalarFormatter):
    """The same of a linear axis."""

    def __init__(self):
        super().__init__(useMathText=False)

    def get_offset(self):
        return raised(super().get_offset())


def label_plainly(drawing):
    """Puts plain text in the place of the formulas that matplotlib labels axes with by itself."""
    for panel in drawing.axes:
        for axis in (panel.xaxis, panel.yaxis):
            if type(axis.get_major_formatter()) is ticker.ScalarFormatter:
                axis.set_major_formatter(Labels())
            elif type(axis.get_major_formatter()) is ticker.LogFormatterSciNotation:
                axis.set_major_formatter(LogLabels())


def inline_svg(drawing, label, hints=()):
    """SVG of a figure for use inside a page; for `hints` see svg_of()."""
    label_plainly(drawing)
    return svg.svg_of(drawing, label, hints)


def panels_of(drawing, rows, columns, **options):
    """Panels of a drawing, by row and column."""
    return drawing.subplots(rows, columns, squeeze=False, subplot_kw={"axes_class": Panel}, **options)


def canvas(panels=1, height=HEIGHT, width=WIDTH, **options):
    """An empty drawing and its axes, stacked."""
    drawing = figure.Figure(figsize=(width, height))
    axes = panels_of(drawing, panels, 1, **options)[:, 0]
    return drawing, axes


def legend_above(axes, handles):
    """Legend over the axes, where it covers no data."""
    axes.legend_handles = [handle for handle in handles if not str(handle.get_label()).startswith("_")]


def extent(values):
    """Smallest and largest finite value, 0 and 1 without any."""
    finite = values[np.isfinite(values)]
    return (finite.min(), finite.max()) if finite.size else (0.0, 1.0)


def limits(values, margin=0.03):
    """Axis limits around finite values, with a little room."""
    low, high = extent(values)
    room = margin * (high - low) or 1.0
    return low - room, high + room


def stacked(abscissa, groups, rows=slice(None)):
    """A panel for each group against one column: label of an ordinate with several columns, and these with their own labels."""
    values = abscissa.values[rows]
    drawing, panels = canvas(len(groups), height=1.2 + 1.9 * len(groups), sharex=True)
    marker = "." if len(values) < MARKED_ROWS else ""
    for axes, (ordinate, group) in zip(panels, groups):
        for label, column in group:
            axes.plot(values, column.values[rows], marker=marker, label=label)
        if len(group) == 1:
            axes.set_ylabel(column_label(group[0][1]))
        else:
            axes.set_ylabel(ordinate)
            legend_above(axes, axes.get_lines())
    panels[-1].set_xlabel(column_label(abscissa))
    return drawing


FLOW_COLOURS = matplotlib.colormaps["Blues"].resampled(64)  # more tell nobody anything and compress worse


def draw_speed(axes, speed, box, top):
    """Speed of a fluid in a plane, to one scale along both axes, as a map up to `top`; returns the scale of its colours. Slow flow fills
    most of a plane: the root gives it more of the colours."""
    scale = PowerNorm(0.5, 0.0, top or 1.0)
    axes.imshow(speed, cmap=FLOW_COLOURS, norm=scale, extent=box, origin="lower", aspect="equal", interpolation="none")
    return scale


def legend_of_speed(axes, scale, ticks):
    """The colours of these speeds over the axes."""
    legend_above(axes, [Patch(facecolor=FLOW_COLOURS(scale(tick)), label=f"{tick:.2g}") for tick in ticks])


def upright(axes, x, label, **style):
    """Vertical line over the whole height; returns its handle for the legend."""
    axes.axvline(x, **{**MARK, **style})
    return Line2D([], [], label=label, **{**MARK, **style})


def label_points(axes, steps):
    """Few points of a logarithmic abscissa are its ticks, those that have room: a range of less than a decade would
    label all minor ones."""
    if len(steps) > 8:
        return
    room = 0.13 * np.log(steps[-1] / steps[0])  # that a label takes
    kept = [steps[0]]
    for step in steps[1:]:
        if np.log(step / kept[-1]) >= room:
            kept.append(step)
    steps = kept
    axes.set_xticks(steps, [raised(f"{step:.3g}") for step in steps])
    axes.set_xticks([], minor=True)


def markers():
    """Markers without end, in the order in which curves take them."""
    return cycle("os^Dvx*P")
