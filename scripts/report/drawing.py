"""What the figures of all subjects share: the canvas, inline SVG, labels, limits."""

import re
import warnings
from dataclasses import dataclass
from io import StringIO
from itertools import cycle
from pathlib import Path

import matplotlib
import matplotlib.style
import numpy as np
from matplotlib import figure, ticker
from matplotlib.lines import Line2D

# The defaults first: a user's own matplotlibrc must not change the report.
matplotlib.style.use(["default", str(Path(__file__).with_name("style.mplstyle"))])

WIDTH, HEIGHT = 4.8, 3.3  # inches
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
    raised = str.maketrans("-+.0123456789", "⁻⁺·⁰¹²³⁴⁵⁶⁷⁸⁹")
    return re.sub(r"\^([-+]?[0-9.]+)", lambda found: found.group(1).translate(raised), dimension)


def quantity(name, symbol, dimension):
    """Axis label: name, symbol, dimension. A dollar sign would start matplotlib's formulas."""
    unit = f" [{powers(dimension)}]" if dimension else ""
    return (f"{name} {symbol}" if symbol != name else name).strip().replace("$", r"\$") + unit


def column_label(column):
    return quantity(column.name.replace("_", " "), column.symbol, column.dimension)


RAISED = str.maketrans("-−0123456789", "⁻⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


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
        return re.sub(r"^1?e([-−+]?\d+)$", lambda found: "×10" + found.group(1).lstrip("+").translate(RAISED), super().get_offset())


def label_plainly(drawing):
    """Puts plain text in the place of the formulas that matplotlib labels axes with by itself."""
    for panel in drawing.axes:
        for axis in (panel.xaxis, panel.yaxis):
            if type(axis.get_major_formatter()) is ticker.ScalarFormatter:
                axis.set_major_formatter(Labels())
            for get, put in (
                (axis.get_major_formatter, axis.set_major_formatter),
                (axis.get_minor_formatter, axis.set_minor_formatter),
            ):
                if type(get()) is ticker.LogFormatterSciNotation:
                    put(LogLabels(labelOnlyBase=get().labelOnlyBase))


def inline_svg(drawing, key, label):
    """SVG of a figure for use inside a page. Ids carry `key`, which must be unique on the page."""
    label_plainly(drawing)
    matplotlib.rcParams["svg.hashsalt"] = key
    text = StringIO()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from")  # text is left to the reader's fonts
        drawing.savefig(text, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"\s*<style.*?</style>", "", svg, flags=re.DOTALL)  # it would apply to the whole page
    svg = re.sub(r'\bid="', f'id="{key}-', svg)
    svg = re.sub(r'href="#', f'href="#{key}-', svg)
    svg = re.sub(r"url\(#", f"url(#{key}-", svg)
    described = label.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
    return svg.replace(
        "<svg", f'<svg role="img" aria-label="{described}" style="stroke-linejoin:round;stroke-linecap:butt"', 1
    )


def canvas(panels=1, height=HEIGHT, **options):
    """An empty drawing and its axes, stacked."""
    drawing = figure.Figure(figsize=(WIDTH, height))
    axes = drawing.subplots(panels, 1, squeeze=False, **options)[:, 0]
    return drawing, axes


def legend_above(axes, handles, ordinate=45):
    """Legend over the axes, where it covers no data; in as many columns as fit, lest it squeeze the axes.

    `ordinate` is the width of the ordinate's labels in points.
    """
    em = matplotlib.rcParams["legend.fontsize"]  # points
    room = 72 * WIDTH - ordinate
    for columns in (3, 2, 1):
        texts = np.array_split([len(handle.get_label()) for handle in handles], columns)  # as the legend will
        if sum(4.8 + 0.58 * column.max(initial=0) for column in texts) * em < room:
            break
    axes.legend(handles=handles, loc="lower left", bbox_to_anchor=(0, 1.03), ncol=columns)


def extent(values):
    """Smallest and largest finite value, 0 and 1 without any."""
    finite = values[np.isfinite(values)]
    return (finite.min(), finite.max()) if finite.size else (0.0, 1.0)


def limits(values, margin=0.03):
    """Axis limits around finite values, with a little room."""
    low, high = extent(values)
    room = margin * (high - low) or 1.0
    return low - room, high + room


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
    axes.set_xticks(steps, [f"{step:.3g}" for step in steps])
    axes.set_xticks([], minor=True)


def markers():
    """Markers without end, in the order in which curves take them."""
    return cycle("os^Dvx*P")
