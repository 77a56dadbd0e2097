"""Figures of the report: one function per kind of plot, each returns a Figure that holds inline SVG.

What is drawn follows the name of a record, whatever the case: a user's own case gets the same figures.
"""

import re
import warnings
from dataclasses import dataclass
from io import StringIO
from itertools import count, cycle
from pathlib import Path

import matplotlib
import matplotlib.style
import numpy as np
from matplotlib import figure
from matplotlib.colors import PowerNorm
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, MaxNLocator

# The defaults first: a user's own matplotlibrc must not change the report.
matplotlib.style.use(["default", str(Path(__file__).with_name("style.mplstyle"))])

WIDTH, HEIGHT = 4.8, 3.3  # inches
MARK = dict(color="#555555", linewidth=0.9)
BAND_COLOURS = ("#8DB4D6", "#BCD4E8", "#E1ECF5")  # narrowest tolerance first
MANY_ROWS, MANY_PANELS = 20000, 4  # beyond these a record without a plot of its own is not drawn
MANY_CURVES = 8  # more than these are drawn in a panel for each quantity
FEW_ROWS, MARKED_ROWS = 6, 41  # fewer rows than these draw no curve; draw their points too


@dataclass(frozen=True)
class Figure:
    caption: str
    svg: str


@dataclass(frozen=True)
class Band:
    """Strains at which a modulus departs from that at rest by at most `tolerance`; -1 and inf mean unbounded."""

    tolerance: float
    low: float
    high: float


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


def inline_svg(drawing, key, label):
    """SVG of a figure for use inside a page. Ids carry `key`, which must be unique on the page."""
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


def at_rest(record, name):
    """Value of a column at zero strain, between the nearest rows."""
    strain, values = record["strain"], record[name]
    finite = np.isfinite(strain) & np.isfinite(values)
    return np.interp(0.0, strain[finite], values[finite])


def extent(values):
    """Smallest and largest finite value, 0 and 1 without any."""
    finite = values[np.isfinite(values)]
    return (finite.min(), finite.max()) if finite.size else (0.0, 1.0)


def limits(values, margin=0.03):
    """Axis limits around finite values, with a little room."""
    low, high = extent(values)
    room = margin * (high - low) or 1.0
    return low - room, high + room


def bands(result, modulus):
    """Bands of the validity record for "secant" or "tangent", narrowest tolerance first."""
    record = result.records.get("validity")
    if record is None or not record.has("tolerance", f"{modulus}_lo", f"{modulus}_hi"):
        return []
    rows = zip(record["tolerance"], record[f"{modulus}_lo"], record[f"{modulus}_hi"])
    return sorted((Band(*row) for row in rows if 0 < row[0] < 1), key=lambda band: band.tolerance)


def shade(axes, shown):
    """Shade bands, nested, within the present limits of the strain axis; returns handles for the legend."""
    left, right = axes.get_xlim()
    handles = []
    for band, colour in zip(shown, BAND_COLOURS):
        label = f"within {100 * band.tolerance:g} %"
        if band.low <= left and band.high >= right:  # and so are all wider ones
            handles.append(Patch(facecolor="none", label=f"{label} throughout"))
            break
        if band.low < band.high:  # not so where NaN says that nothing was found
            # The widest lies lowest.
            low, high = max(band.low, left), min(band.high, right)
            axes.axvspan(low, high, color=colour, linewidth=0, zorder=0.5 - 0.1 * len(handles))
            handles.append(Patch(facecolor=colour, label=label))
    axes.set_xlim(left, right)
    return handles


def upright(axes, x, label, **style):
    """Vertical line over the whole height; returns its handle for the legend."""
    axes.axvline(x, **{**MARK, **style})
    return Line2D([], [], label=label, **{**MARK, **style})


def potential_energy(result, record, key):
    """Energy of the law and of the harmonic bond of the same stiffness, each zero at rest, against length."""
    if not drawable(record, "length", "strain", "energy", "energy_harmonic"):
        return None
    drawing, (axes,) = canvas()
    length = record["length"]
    law = record["energy"] - at_rest(record, "energy")
    harmonic = record["energy_harmonic"] - at_rest(record, "energy_harmonic")
    handles = axes.plot(length, law, label="this law")
    handles += axes.plot(length, harmonic, label="harmonic, same stiffness")
    axes.set_xlim(*limits(length))
    # The law may grow without bound on either side: the harmonic one sets the scale.
    top = 1.35 * extent(harmonic)[1] or 1.0
    axes.set_ylim(-0.05 * top, top)
    rest, reach = known(result, "rest_length"), known(result, "strain_at_r_max")
    if rest is not None:
        handles.append(upright(axes, rest, f"rest length {rest:.4g}", linestyle=":"))
        if reach is not None:
            bound = rest * (1 + reach)
            axes.set_xlim(right=max(axes.get_xlim()[1], bound + 0.02 * rest))
            handles.append(upright(axes, bound, f"limit {bound:.4g}", linestyle="-."))
    axes.set_xlabel(column_label(record.columns["length"]))
    energy = record.columns["energy"]
    axes.set_ylabel(quantity("energy above rest", energy.symbol, energy.dimension))
    legend_above(axes, handles)
    caption = "Energy of the bond above rest, beside the harmonic bond of the same stiffness and rest length."
    return Figure(caption, inline_svg(drawing, key, caption))


def tension(result, record, key):
    """Tension of the bond against strain, with the straight line of the same stiffness."""
    if not drawable(record, "strain", "tension"):
        return None
    drawing, (axes,) = canvas()
    strain, force = record["strain"], record["tension"]
    handles = axes.plot(strain, force, label="this law")
    axes.set_xlim(*limits(strain))
    slope = known(result, "force_per_strain")
    if slope is None and None not in (known(result, "stiffness"), known(result, "rest_length")):
        slope = known(result, "stiffness") * known(result, "rest_length")
    if slope is not None:
        straight = abs(slope) * strain
        handles += axes.plot(strain, straight, label="straight line of the same stiffness")
        keep_near(axes, force, straight)
    axes.axhline(0, **MARK)
    axes.set_xlabel(column_label(record.columns["strain"]))
    axes.set_ylabel(column_label(record.columns["tension"]))
    legend_above(axes, handles)
    caption = "Tension of the bond against strain, beside that of the harmonic bond."
    return Figure(caption, inline_svg(drawing, key, caption))


def keep_near(axes, curve, straight):
    """Limit the ordinate to the curve, to 1.4 times the straight line's range at most: laws diverge at their limits."""
    low, high = extent(straight)
    reach = 1.4 * max(abs(low), abs(high))
    smallest, largest = extent(curve)
    axes.set_ylim(*limits(np.array([max(min(smallest, low), -reach), min(max(largest, high), reach)])))


def zero_by_zero(record):
    """Rows at zero strain without a secant: left out, lest they cut the curve in two."""
    return (record["strain"] == 0) & np.isnan(record["secant_ratio"])


def moduli(result, record, key):
    """Secant and tangent modulus over the modulus at rest, over the whole range of strain."""
    if not drawable(record, "strain", "secant_ratio", "tangent_ratio"):
        return None
    drawing, (axes,) = canvas()
    strain, secant = record["strain"], record["secant_ratio"]
    defined = ~zero_by_zero(record)
    handles = axes.plot(strain[defined], secant[defined], label="secant")
    handles += axes.plot(strain, record["tangent_ratio"], label="tangent")
    axes.set_xlim(*limits(strain))
    ratios = np.concatenate([secant, record["tangent_ratio"]])
    smallest, largest = extent(ratios)
    # Ratios diverge at a law's limits; what matters is where they leave 1.
    axes.set_ylim(min(0.0, max(smallest, -1.0)), min(max(1.1 * largest, 1.5), 3.0))
    axes.axhline(1, **MARK)
    handles += shade(axes, bands(result, "secant"))
    axes.set_xlabel(column_label(record.columns["strain"]))
    axes.set_ylabel(quantity("modulus over modulus at rest", "", "1"))
    legend_above(axes, handles)
    caption = "Secant and tangent modulus over that at rest; shaded: strain in which the secant stays within the tolerance."
    return Figure(caption, inline_svg(drawing, key, caption))


def moduli_near_rest(result, record, key):
    """The same near zero strain: secant above, tangent below, each with its own bands."""
    if not drawable(record, "strain", "secant_ratio", "tangent_ratio"):
        return None
    found = bands(result, "secant") + bands(result, "tangent")
    ends = [abs(end) for band in found for end in (band.low, band.high) if np.isfinite(end) and end > -1]
    strain = record["strain"]
    span = 1.25 * max(ends, default=0.0)
    # Without bounds there is nothing to see; wide ones are seen in the figure of the whole range.
    if not 0 < span < 0.7 * extent(np.abs(strain))[1]:
        return None
    near = (np.abs(strain) <= 1.1 * span) & ~zero_by_zero(record)
    if near.sum() < FEW_ROWS:
        return None
    marker = "o" if near.sum() < MARKED_ROWS else ""
    widest = max(band.tolerance for band in found)
    drawing, panels = canvas(2, height=4.2, sharex=True)
    for axes, modulus, colour in zip(panels, ("secant", "tangent"), ("C0", "C1")):
        shown = bands(result, modulus)
        axes.plot(strain[near], record[f"{modulus}_ratio"][near], color=colour, linestyle="-", marker=marker)
        axes.set_xlim(-span, span)
        axes.locator_params(axis="x", nbins=6)
        axes.set_ylim(1 - 1.5 * widest, 1 + 1.5 * widest)
        handles = shade(axes, shown)
        for band in shown:
            for level in (1 - band.tolerance, 1 + band.tolerance):
                axes.axhline(level, color="#888888", linewidth=0.7, linestyle=(0, (1, 2)))
        axes.axhline(1, **MARK)
        axes.set_ylabel(quantity(f"{modulus} modulus ratio", "", "1"))
    legend_above(panels[0], handles)
    panels[-1].set_xlabel(column_label(record.columns["strain"]))
    caption = "Near zero strain: the bands end where the modulus leaves 1 by the tolerance (dotted)."
    return Figure(caption, inline_svg(drawing, key, caption))


def stress_references(result):
    """References that hold a stress-strain curve."""
    return [reference for reference in result.references if drawable(reference.columns, "strain", "stress")]


def stress_strain(result, record, key):
    """Stress against strain, the straight line E strain, reference points and the range of validity."""
    if not drawable(record, "strain", "stress"):
        return None
    drawing, (axes,) = canvas()
    strain, stress = record["strain"], record["stress"]
    handles = axes.plot(strain, stress, label="measured")
    modulus = known(result, "young_modulus")
    axes.set_xlim(*limits(strain))
    if modulus is not None:
        straight = modulus * strain
        handles += axes.plot(strain, straight, color="#222222", linewidth=0.9, linestyle="--", label="E × strain")
        keep_near(axes, stress, straight)
    for reference in stress_references(result):
        points = reference.columns
        every = max(1, len(points) // 25)  # enough to see, few enough to see the line
        handles += axes.plot(
            points["strain"][::every], points["stress"][::every], "o", color="C1", markerfacecolor="none",
            label=f"reference ({reference.kind or reference.id})",
        )
    handles += shade(axes, bands(result, "secant"))
    axes.set_xlabel(column_label(record.columns["strain"]))
    axes.set_ylabel(column_label(record.columns["stress"]))
    legend_above(axes, handles)
    caption = "Stress against strain; shaded: strain in which the secant modulus stays within the tolerance."
    return Figure(caption, inline_svg(drawing, key, caption))


def curve_error(result, record, key):
    """Relative distance from the reference curve: of its second column, at the values of its first."""
    modulus = known(result, "young_modulus")
    if modulus is None or not drawable(record, "strain", "stress"):
        return None
    floors = {"strain": 1e-3, "stress": 1e-3 * abs(modulus)}
    drawing, (axes,) = canvas(height=2.7)
    handles = []
    for reference, marker in zip(stress_references(result), "os^D"):
        given, wanted = [name for name in reference.columns.columns if name in floors]
        # Only where the run measured: an interpolation would add an error of its own.
        _, here, there = np.intersect1d(record[given], reference.columns[given], return_indices=True)
        if not len(here):
            continue
        expected = reference.columns[wanted][there]
        error = np.abs(record[wanted][here] - expected) / np.maximum(np.abs(expected), floors[wanted])
        # A logarithm has no place for points that agree to the last bit: they go to half the unit round-off.
        error = np.maximum(error, 2.0**-54)
        label = f"{wanted} against {reference.id}"
        handles += axes.plot(record["strain"][here], error, marker, linestyle="none", label=label)
    if not handles:
        return None
    axes.set_yscale("log")
    axes.set_xlabel(column_label(record.columns["strain"]))
    axes.set_ylabel("relative error [1]")
    legend_above(axes, handles)
    caption = "Distance from the reference, relative to it or to what strain 0.001 gives; no distance is drawn as 2⁻⁵⁴."
    return Figure(caption, inline_svg(drawing, key, caption))


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


def convergence(result, record, key):
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
    return Figure(caption, inline_svg(drawing, key, caption))


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


def markers():
    """Markers without end, in the order in which curves take them."""
    return cycle("os^Dvx*P")


def work_precision(result, record, key):
    """Error of each row against its run time, the timing phase `work_precision/<row>`, and against the first column.

    Both are log-log, with a curve for each value of the column `bits` where there is one.
    """
    if record.has("steps_per_period"):
        return None  # see period_precision
    resolution = next(iter(record.columns.values()))
    if not drawable(record, resolution.name, "error"):
        return None
    times = {row["phase"]: row["wall_seconds"] for row in result.timing}
    seconds = np.array([times.get(f"work_precision/{row}", np.nan) for row in range(len(record))])
    error, steps = record["error"], resolution.values
    bits = record["bits"] if record.has("bits") else np.zeros(len(record))
    drawn = (error > 0) & (seconds > 0)
    if record.has("plane"):
        drawn &= record["plane"] == record["plane"][0]
    if not drawn.any():
        return None
    drawing, axes = canvas(panels=2, height=5.2)
    handles = []
    for number, (kind, marker) in enumerate(zip(np.unique(bits)[::-1], markers())):
        rows = np.flatnonzero(drawn & (bits == kind))
        style = dict(color=f"C{number}", marker=marker, linestyle="-", label=f"{kind:.0f} bits")
        handles += axes[0].plot(1000 * seconds[rows], error[rows], **style)
        axes[1].plot(steps[rows], error[rows], **(style | dict(linestyle=("-", "--")[number % 2])))
        if number == 0:
            for x, y, label in zip(1000 * seconds[rows], error[rows], steps[rows]):
                axes[0].annotate(f"{label:.0f}", (x, y), xytext=(5, 4), textcoords="offset points", fontsize=7)
    rows = np.flatnonzero(drawn)
    fewest = rows[steps[rows].argmin()]
    guide = np.unique(steps[rows])
    axes[1].plot(guide, 0.4 * error[fewest] * (guide / steps[fewest]) ** -2, ":", color="#555555", linewidth=1)
    for panel in axes:
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.set_ylabel("relative error [1]")
        panel.margins(x=0.12, y=0.15)
    label_points(axes[1], guide)
    axes[0].set_xlabel(f"run time of the row [ms]; labels: {resolution.name.replace('_', ' ')}")
    axes[1].set_xlabel(column_label(resolution))
    if len(handles) > 1:
        legend_above(axes[0], handles)
    caption = "What accuracy a second of computing buys; dotted: second order. One run each: read the times to a factor of two."
    return Figure(caption, inline_svg(drawing, key, caption))


def period_precision(result, record, key):
    """Error of each row against its run time, the timing phase `<record>/<row>`, and against the steps; both log-log.

    Sub-steps of an outer step, the record `substeps`, are drawn beside plain steps.
    """
    if not record.has("steps_per_period"):
        return None
    times = {row["phase"]: row["wall_seconds"] for row in result.timing}
    drawing, axes = canvas(panels=2, height=5.2)
    handles, all_steps = [], []
    styles = (("work_precision", "steps_per_period", "plain steps", "o-"), ("substeps", "substeps", "sub-steps of 1", "s--"))
    for colour, (name, labels, legend, style) in enumerate(styles):
        rows = result.records.get(name)
        if not drawable(rows, "steps_per_period", "error", labels):
            continue
        seconds = np.array([times.get(f"{name}/{row}", np.nan) for row in range(len(rows))])
        error, steps = rows["error"], rows["steps_per_period"]
        drawn = (error > 0) & (seconds > 0)
        if not drawn.any():
            continue
        handles += axes[0].loglog(1000 * seconds[drawn], error[drawn], style, color=f"C{colour}", label=legend)
        for x, y, label in zip(1000 * seconds[drawn], error[drawn], rows[labels][drawn]):
            axes[0].annotate(f"{label:.0f}", (x, y), xytext=(5, 4), textcoords="offset points", fontsize=7)
        axes[1].loglog(steps[drawn], error[drawn], style, color=f"C{colour}")
        if not all_steps:
            first = np.flatnonzero(drawn)[0]
            line = 0.4 * error[first] * (steps[drawn] / steps[first]) ** -2
            axes[1].plot(steps[drawn], line, ":", color=f"C{colour}", linewidth=1)
            label_points(axes[1], steps[drawn])
        all_steps.extend(steps[drawn])
    if not all_steps:
        return None
    axes[0].set_xlabel("run time of the row [ms]; labels: steps per period, or sub-steps")
    axes[1].set_xlabel(column_label(record.columns["steps_per_period"]))
    for panel in axes:
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.set_ylabel("relative error [1]")
        panel.margins(x=0.12, y=0.15)
    if len(handles) > 1:
        legend_above(axes[0], handles)
    caption = "What accuracy a second of computing buys; dotted: second order. One run each: read the times to a factor of two."
    return Figure(caption, inline_svg(drawing, key, caption))


def dispersion(result, record, key):
    """Factor per step of waves over the continuum's, measured and by eigenvalue, for each relaxation time."""
    if not drawable(record, "relaxation_time", "wavenumber", "decay_rate", "decay_rate_exact", "decay_rate_continuum"):
        return None
    shown = [("decay_rate", "decay rate over νk²")]
    if record.has("frequency", "frequency_exact", "frequency_continuum"):
        shown.insert(0, ("frequency", "speed over 1/√3"))
    drawing, panels = canvas(len(shown), height=1.0 + 2.7 * len(shown), sharex=True)
    handles = []
    for axes, (name, label) in zip(panels, shown):
        for number, (tau, marker) in enumerate(zip(np.unique(record["relaxation_time"]), markers())):
            rows = record["relaxation_time"] == tau
            k, scale = record["wavenumber"][rows], record[f"{name}_continuum"][rows]
            style = dict(color=f"C{number}", label=f"τ = {tau:g}")
            axes.plot(k, record[f"{name}_exact"][rows] / scale, "-", **style)
            points = axes.plot(k, record[name][rows] / scale, marker, mfc="none", **style)
            handles += points if axes is panels[0] else []
        axes.axhline(1, **MARK)
        axes.set_ylabel(quantity(label, "", "1"))
    panels[-1].set_xlabel(column_label(record.columns["wavenumber"]))
    legend_above(panels[0], handles)
    caption = "Waves over what the continuum says: marks measured, lines the eigenvalues of the lattice's own step."
    return Figure(caption, inline_svg(drawing, key, caption))


def constants(result, record, key):
    """Leading errors against the relaxation time, with reference points; below, what Richardson's limit is off by."""
    quantities = [name.removeprefix("constant_") for name in record.columns if name.startswith("constant_")]
    if not quantities or not drawable(record, "relaxation_time"):
        return None
    drawing, panels = canvas(2, height=5.0, sharex=True)
    tau = record["relaxation_time"]
    handles, below = [], []
    for number, (name, marker) in enumerate(zip(quantities, markers())):
        style = dict(color=f"C{number}", linestyle="-")
        handles += panels[0].plot(tau, record[f"constant_{name}"], label=f"{name}, measured", **style)
        for reference in result.references:
            if drawable(reference.columns, "relaxation_time", f"constant_{name}"):
                points = reference.columns
                handles += panels[0].plot(
                    points["relaxation_time"], points[f"constant_{name}"], marker, mfc="none", color=f"C{number}",
                    label=f"{name}, {reference.kind}",
                )  # fmt: skip
        off = np.abs(record[f"extrapolated_{name}"] - 1)
        below += panels[1].semilogy(tau, off, marker=marker, label=f"{name}: limit off by", **style)
        below += panels[1].semilogy(
            tau, record[f"gci_{name}"], label=f"{name}: convergence index", **(style | dict(linestyle="--"))
        )
    panels[0].axhline(0, **MARK)
    panels[0].set_ylabel(quantity("leading error", "C", "L^2"))
    panels[1].set_ylabel("relative error [1]")
    panels[1].set_xlabel(column_label(record.columns["relaxation_time"]))
    legend_above(panels[0], handles)
    legend_above(panels[1], below)
    caption = "Leading error, value/continuum = 1 + C k²; below, extrapolated limit and grid convergence index of the finest grid."
    return Figure(caption, inline_svg(drawing, key, caption))


def storage(result, record, key):
    """Discretisation and storage error against the resolution, log-log."""
    if not drawable(record, "nodes", "discretisation_error", "storage_error"):
        return None
    drawing, (axes,) = canvas()
    labels = {"discretisation_error": "double against the exact solution", "storage_error": "float against double"}
    handles = []
    for (name, label), marker in zip(labels.items(), markers()):
        handles += axes.loglog(record["nodes"], record[name], marker=marker, linestyle="-", label=label)
    label_points(axes, np.unique(record["nodes"]))
    axes.set_xlabel(column_label(record.columns["nodes"]))
    axes.set_ylabel("relative error, L2 [1]")
    legend_above(axes, handles)
    caption = "What storing populations in float adds to the error, beside that of the grid."
    return Figure(caption, inline_svg(drawing, key, caption))


def galilean(result, record, key):
    """Loss of viscosity against the speed of the stream, log-log."""
    if not drawable(record, "speed", "error", "error_exact", "error_theory"):
        return None
    drawing, (axes,) = canvas()
    speed = record["speed"]
    handles = axes.loglog(speed, record["error"], "o", mfc="none", label="measured")
    handles += axes.loglog(speed, record["error_exact"], "-", label="eigenvalue around the stream")
    handles += axes.loglog(speed, record["error_theory"], "--", label="long waves, 3 (U·k)²/k²")
    label_points(axes, speed)
    axes.set_xlabel(column_label(record.columns["speed"]))
    axes.set_ylabel("relative loss of viscosity [1]")
    legend_above(axes, handles)
    caption = "Viscosity that a stream through the lattice takes away."
    return Figure(caption, inline_svg(drawing, key, caption))


def pairs(record):
    """Names of columns that have an exact counterpart `<name>_exact`."""
    return [name for name in record.columns if name + "_exact" in record.columns]


def profile(result, record, key):
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
    return Figure(caption, inline_svg(drawing, key, caption))


def slip(result, record, key):
    """Slip at the wall against the relaxation time."""
    if not drawable(record, "relaxation_time", "slip_first_order", "slip_guo", "slip_exact", "slip_bare"):
        return None
    drawing, (axes,) = canvas()
    tau = record["relaxation_time"]
    handles = axes.plot(tau, record["slip_exact"], color="C0", linestyle="-", label="exact")
    open_style = dict(linestyle="none", markerfacecolor="none")
    label = "first order, Σ f c + g/2"
    handles += axes.plot(tau, record["slip_first_order"], "o", color="C0", label=label, **open_style)
    handles += axes.plot(tau, record["slip_guo"], "x", color="C1", label="Guo, Σ f c + g/2", **open_style)
    handles += axes.plot(tau, record["slip_bare"], "s", color="C2", label="bare Σ f c", **open_style)
    axes.axhline(0, **MARK)
    axes.set_xlabel(column_label(record.columns["relaxation_time"]))
    axes.set_ylabel("slip over force [T]")
    legend_above(axes, handles)
    caption = "Slip of half-way bounce-back over the force; where it is zero, the wall sits half-way."
    return Figure(caption, inline_svg(drawing, key, caption))


def section(result, record, key):
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
    drawing.colorbar(drawn, ax=axes, label=column_label(record.columns["velocity"]))
    caption = f"{record.title}: measured (colours) and exact (lines, at the edges of the colours)."
    return Figure(caption, inline_svg(drawing, key, caption))


def drag(result, record, key):
    """Drag of an array against the resolution; below, what size of obstacle it is the drag of."""
    if not drawable(record, "nodes", "drag", "drag_exact", "drag_of_voxels", "voxels_larger", "drag_larger"):
        return None
    drawing, (above, below) = canvas(2, height=5.0, sharex=True)
    nodes = record["nodes"]
    handles = above.plot(nodes, record["drag"], "o-", color="C0", label="measured")
    handles += above.plot(nodes, record["drag_exact"], "-", color="#222222", linewidth=1, label="exact")
    of_voxels = dict(linestyle="--", marker="s", color="C1", markerfacecolor="none")
    handles += above.plot(nodes, record["drag_of_voxels"], label="exact, volume of the voxels", **of_voxels)
    above.set_ylabel(column_label(record.columns["drag"]))
    legend_above(above, handles)
    handles = below.plot(nodes, record["drag_larger"], "o-", color="C0", label="as the drag says")
    handles += below.plot(nodes, record["voxels_larger"], label="as the voxels' volume says", **of_voxels)
    below.axhline(0, **MARK)
    below.set_ylim(-0.5, 0.5)
    below.set_ylabel("radius beyond the true one [L]")
    below.set_xlabel("nodes across a cell [1]")
    legend_above(below, handles)
    caption = "Drag against resolution, and the radius that explains it: a staircase is off by a fraction of a spacing."
    return Figure(caption, inline_svg(drawing, key, caption))


def drift(result, record, key):
    """What should not change, against time: every column, logarithmic."""
    first, *runs = record.columns.values()
    drawing, (axes,) = canvas(height=3.5)
    handles = []
    for number, column in enumerate(runs):
        # A logarithm has no place for what did not change at all.
        values = np.where(column.values > 0, column.values, np.nan)
        style = dict(marker=".", color=f"C{number}", linestyle="-", linewidth=0.9)
        handles += axes.plot(first.values, values, label=column.name.replace("_", " "), **style)
    axes.set_yscale("log")
    axes.set_xlabel(column_label(first))
    axes.set_ylabel(quantity("departure per node", "", runs[0].dimension))
    legend_above(axes, handles)
    return Figure(record.title + ".", inline_svg(drawing, key, record.title))


def boundary(result, record, key):
    """First failing time step and the linear limit, against whichever of noise and pre-strain varies."""
    if not drawable(record, "amplitude", "prestrain", "dt", "dt_min", "dt_max", "linear_limit"):
        return None
    varied = "prestrain" if np.ptp(record["prestrain"]) > 0 else "amplitude"
    x = record[varied]
    drawing, (axes,) = canvas(height=3.5)
    low, high = record["dt"] - record["dt_min"], record["dt_max"] - record["dt"]
    label = "first failing step, median and range of the noises"
    handles = [axes.errorbar(x, record["dt"], yerr=[low, high], fmt="o-", color="C0", capsize=3, label=label)]
    limit = r"linear limit $2/\omega_{max}$ of the strained body"
    handles += axes.plot(x, record["linear_limit"], "s--", color="C1", label=limit)
    for reference in result.references:
        if drawable(reference.columns, varied, "dt"):
            points = reference.columns
            handles += axes.plot(points[varied], points["dt"], "D", color="C3", mfc="none", label="another program")
    axes.set_ylim(bottom=0)
    axes.margins(x=0.1)
    if varied == "amplitude":
        axes.set_xscale("log")
        label_points(axes, np.unique(x))
    axes.set_xlabel(column_label(record.columns[varied]))
    axes.set_ylabel("time step [T]")
    legend_above(axes, handles)
    caption = "Time step at which leap-frog first fails, and where small oscillations become unstable."
    return Figure(caption, inline_svg(drawing, key, caption))


def coupling_boundary(result, record, key):
    """Least stable node mass point by point: runs, and the linearised exchange with and without the fluid's memory."""
    columns = ("point", "predicted", "forgetful", "measured", "ratio")
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
    axes.set_ylabel("least stable node mass m [M]")
    axes.set_ylim(0, 1.08 * extent(np.concatenate([record[name] for name in columns[1:4]]))[1] or 1.0)
    legend_above(axes, handles)
    ratio.axhline(1.0, **MARK)
    ratio.plot(x, record["ratio"], "o", color="C0")
    ratio.set_ylabel("runs / map [1]")
    names = [
        metric.name.removeprefix("measured_").replace("_", " ")
        for metric in result.metrics
        if metric.name.startswith("measured_")
    ]
    if len(names) == len(record):
        slanted = dict(rotation=40, horizontalalignment="right", rotation_mode="anchor") if len(names) > 4 else {}
        ratio.set_xticks(x, names, **slanted)
    else:
        ratio.set_xticks(x)
    ratio.set_xlim(-0.5, len(record) - 0.5)
    ratio.margins(y=0.15)
    ratio.set_xlabel("way of coupling: name of the point")
    caption = (
        "Least node mass at which the exchange of a rod with the fluid is stable: below it small motions grow. "
        "The map is one step, linearised, without the fluid's own motion."
    )
    return Figure(caption, inline_svg(drawing, key, caption))


def last_good_nodes(result, record, key):
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
    return Figure(caption, inline_svg(drawing, key, caption))


def elastica(result, record, key):
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
    return Figure(caption, inline_svg(drawing, key, caption))


def buckling(result, record, key):
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
    return Figure(caption, inline_svg(drawing, key, caption))


def standing_waves(result, record, key):
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
    return Figure(caption, inline_svg(drawing, key, caption))


def conservation(result, record, key):
    """What leap-frog keeps, against the time step, log-log: energy to second order, the rest to round-off."""
    if not drawable(record, "dt_over_limit", "energy", "momentum", "angular_momentum", "reversal"):
        return None
    drawing, (axes,) = canvas()
    step, handles = record["dt_over_limit"], []
    for name, marker in zip(("energy", "momentum", "angular_momentum", "reversal"), "os^D"):
        shown = np.maximum(record[name], 2.0**-54)  # a logarithm has no place for what is kept to the last bit
        handles += axes.plot(step, shown, marker + "-", label=name.replace("_", " "))
    axes.set_xscale("log")
    axes.set_yscale("log")
    label_points(axes, step)
    axes.set_xlabel("time step over the linear limit [1]")
    axes.set_ylabel("largest relative departure [1]")
    legend_above(axes, handles)
    caption = "What a free body keeps during a run, over the time step; no departure is drawn as 2⁻⁵⁴."
    return Figure(caption, inline_svg(drawing, key, caption))


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


def centre_lines(result, record, key):
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
    return Figure(caption, inline_svg(drawing, key, caption))


DEVIATIONS = {
    "z_max": "largest |Δz|",
    "z_rms": "rms Δz",
    "lab_max": "largest |d|",
    "swimming_max": "largest |d|, swimming taken out",
}


def law_deviation(result, record, key):
    """Distance of both laws' centre lines over the amplitude, as bars for each phase."""
    names = [name for name in DEVIATIONS if record.has(name)]
    if not names or not drawable(record, "phase"):
        return None
    drawing, (axes,) = canvas(height=3.4)
    places, width = np.arange(len(record)), 0.8 / len(names)
    handles = []
    for number, (name, hatch) in enumerate(zip(names, ("", "////", "----", "xxxx"))):
        shift = (number - (len(names) - 1) / 2) * width
        style = dict(facecolor="white" if hatch else f"C{number}", edgecolor=f"C{number}", hatch=hatch, linewidth=0.8)
        axes.bar(places + shift, record[name], 0.9 * width, **style)
        handles.append(Patch(label=DEVIATIONS[name], **style))
    axes.grid(False, axis="x")
    axes.set_xticks(places, [f"{phase:g}" for phase in record["phase"]])
    axes.set_xlabel("time in the last period t/T [1]")
    axes.set_ylabel("distance over amplitude z₀ [1]")
    legend_above(axes, handles)
    caption = "How far the two laws' centre lines are apart. d is the distance of nodes, Δz its part along the drive."
    return Figure(caption, inline_svg(drawing, key, caption))


def stroke(result, record, key):
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
    drawing.align_ylabels(panels)
    legend_above(panels[0], handles)
    panels[-1].set_xlabel("time in periods t/T [1]")
    caption = (
        "The stroke: displacement and force of the drive, displacement of the centre of mass along the filament, slip of "
        "the coupled nodes (root mean square), smallest and largest strain of any bond."
    )
    return Figure(caption, inline_svg(drawing, key, caption))


def strain_histogram(result, record, key):
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
    return Figure(caption, inline_svg(drawing, key, caption))


def modulus_deviation(result, record, key):
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
    return Figure(caption, inline_svg(drawing, key, caption))


FILM_COLUMNS = 2  # of panels
FILM_ROOM = 40  # spacings of the flow that are shown around the filament
FILM_SAMPLES = 200  # across a panel at most: more would be finer than the page and heavier than it may be
FILM_COLOURS = matplotlib.colormaps["Blues"].resampled(64)  # more tell nobody anything and compress worse


def film(result, record, key):
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
    tall = 0.5 * (WIDTH - 0.6) * (box[3] - box[2]) / (box[1] - box[0])  # inches of a panel
    drawing = figure.Figure(figsize=(WIDTH, min(rows * (tall + 0.08) + 1.1, 9.0)))
    panels = drawing.subplots(rows, FILM_COLUMNS, squeeze=False, sharex=True, sharey=True)
    # Slow flow fills most of the plane: the root gives it more of the colours.
    scale = PowerNorm(0.5, 0.0, extent(speed)[1] or 1.0)
    for axes, phase, seen in zip(panels.flat, phases, speed):
        image = axes.imshow(
            seen, cmap=FILM_COLOURS, norm=scale, extent=box, origin="lower", aspect="equal", interpolation="none"
        )
        if with_line:
            there = np.abs(lines["phase"] - phase) < 0.01
            axes.plot(lines["y"][there], lines["z"][there], color="C1", linestyle="-", linewidth=1.3)
        axes.text(0.03, 0.96, f"t = {phase:g} T", transform=axes.transAxes, verticalalignment="top")
        axes.set_xlim(box[0], box[1])
        axes.set_ylim(box[2], box[3])
        axes.grid(False)
    for axes in panels.flat[len(phases) :]:
        axes.set_visible(False)
    for axes in panels[-1]:
        axes.set_xlabel(column_label(record.columns["y"]))
    for axes in panels[:, 0]:
        axes.set_ylabel(column_label(record.columns["z"]))
    bar = drawing.colorbar(image, ax=panels, location="bottom", aspect=40, label=column_label(record.columns["speed"]))
    ticks = MaxNLocator(4, steps=(1, 2, 5, 10)).tick_values(0.0, scale.vmax)
    ticks = [tick for tick in np.append(ticks[1] / 10, ticks) if tick <= scale.vmax]
    bar.set_ticks(ticks, labels=[f"{tick:.3g}" for tick in ticks])
    caption = (
        f"{record.title or 'Speed of the fluid'} at {len(phases)} phases of the last period; both axes to one scale, colours by the root of the "
        "speed."
    )
    if with_line:
        caption += f" The line is the centre line of the filament, {compared_names(result)[0]}."
    return Figure(caption, inline_svg(drawing, key, caption))


def first_harmonic(result, record, key):
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
    return Figure(caption, inline_svg(drawing, key, caption))


def companion_names(result, record):
    """Variants of a record `sensitivity` in words, without the base: what metrics effect_<name> say after a colon."""
    stated = [metric.meaning.partition(": ")[2] for metric in result.metrics if metric.name.startswith("effect_")]
    if len(stated) != len(record) - 1:
        return [f"variant {number:g}" for number in record["variant"][1:]]
    # Where a run broke off, why follows in brackets: too long for a label.
    return [text if held else text.partition(" (")[0] for text, held in zip(stated, record["survived"][1:])]


def sensitivity(result, record, key):
    """Effect of each variant and the distance between the laws under it, largest effect first, logarithmic."""
    if not drawable(record, "variant", "survived", "law_deviation_z") or not record.has("effect_z") or len(record) < 2:
        return None
    names = companion_names(result, record)
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
    legend_above(axes, handles, ordinate=0.55 * 8.5 * max(len(name) for name in names))
    caption = (
        "What each variant of the scene moves: the law of [bond] against itself in the base's scene, and the two laws "
        "against each other under the variant. A choice whose dot is left of the dashed line moves the filament less than "
        "the change of the law."
    )
    return Figure(caption, inline_svg(drawing, key, caption))


DELTA_SCANS = {
    "delta_sums": ("sum of the weights Σ D h³", "Sum of the weights"),
    "delta_imbalances": ("even less odd nodes Σ ± D h³", "Weights of even nodes less those of odd ones"),
    "delta_first_moments": ("first moment Σ (x − X) D h³", "First moment of the weights along an axis"),
}


def delta_scan(result, record, key):
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
    return Figure(caption, inline_svg(drawing, key, caption))


def against_first_column(result, record, key):
    """A record without a plot of its own: all columns against the first, one panel per dimension."""
    columns = [column for column in record.columns.values() if column.values.dtype.kind in "iuf"]
    if len(columns) < 2 or not 2 <= len(record) <= MANY_ROWS:
        return None
    first, rest = columns[0], columns[1:]
    groups = {}
    for column in rest:
        groups.setdefault(column.dimension, []).append(column)
    if len(groups) > MANY_PANELS:
        return None
    drawing, panels = canvas(len(groups), height=1.2 + 1.9 * len(groups), sharex=True)
    marker = "." if len(record) < MARKED_ROWS else ""
    for axes, (dimension, group) in zip(panels, groups.items()):
        for column in group:
            label = quantity(column.name.replace("_", " "), column.symbol, "")
            axes.plot(first.values, column.values, marker=marker, label=label)
        if len(group) == 1:
            axes.set_ylabel(column_label(group[0]))
        else:
            axes.set_ylabel(quantity("value", "", dimension))
            legend_above(axes, axes.get_lines())
    panels[-1].set_xlabel(column_label(first))
    caption = record.title or record.name
    return Figure(caption, inline_svg(drawing, key, caption))


def laws(results):
    """Results that hold a bond's potential and say its modulus and rest length."""
    return [
        result
        for result in results
        if drawable(result.records.get("potential"), "length", "strain", "energy")
        and known(result, "young_modulus")
        and known(result, "rest_length")
    ]


def law_styles():
    """Styles of lines without end: the colours of the style sheet, and from round to round another dash for each."""
    styles = list(matplotlib.rcParams["axes.prop_cycle"])
    for shift in count():
        for place, style in enumerate(styles):
            yield style | {"linestyle": styles[(place + shift) % len(styles)]["linestyle"]}


def law_name(result):
    return result.id.removeprefix("derive-")


def bond_laws(results, key):
    """Potentials of all laws in reduced units, (U - U(r0)) / (E r0^3) against r / r0, with their limits."""
    drawing, (axes,) = canvas(height=3.7)
    handles, right, scale = [], 1.0, 0.0
    for result, style in zip(laws(results), law_styles()):
        record = result.records["potential"]
        rest, modulus = known(result, "rest_length"), known(result, "young_modulus")
        reach = known(result, "strain_at_r_max")
        energy = (record["energy"] - at_rest(record, "energy")) / (modulus * rest**3)
        handles += axes.plot(record["length"] / rest, energy, label=law_name(result), **style)
        furthest = extent(record["strain"])[1]
        right = max(right, furthest + 1)
        scale = max(scale, 0.5 * furthest**2)
        if reach is not None:
            right = max(right, 1 + reach)
            axes.axvline(1 + reach, linewidth=0.8, alpha=0.7, **style)
    if not handles:
        return None
    handles.append(upright(axes, 1, "rest length", linestyle=":"))
    axes.set_xlim(right=right + 0.03)
    # Laws diverge at their limits: a harmonic bond of the same modulus sets the scale.
    axes.set_ylim(-0.05 * scale, 1.35 * scale or 1.0)
    axes.set_xlabel("length over rest length r/r₀ [1]")
    axes.set_ylabel("(U − U(r₀)) / (E r₀³) [1]")
    legend_above(axes, handles)
    caption = "Potentials in reduced units: all have the same curvature at rest. Thin vertical lines: where a law ends."
    return Figure(caption, inline_svg(drawing, key, caption))


def bond_laws_secant(results, key):
    """Secant modulus over the modulus at rest of all laws."""
    drawing, (axes,) = canvas(height=3.7)
    handles = []
    for result, style in zip(laws(results), law_styles()):
        record = result.records.get("moduli")
        if not drawable(record, "strain", "secant_ratio"):
            continue
        handles += axes.plot(record["strain"], record["secant_ratio"], label=law_name(result), **style)
    if not handles:
        return None
    axes.axhline(1, **MARK)
    axes.set_ylim(0, 3)
    axes.set_xlabel("strain r/r₀ − 1 [1]")
    axes.set_ylabel("secant modulus over modulus at rest [1]")
    legend_above(axes, handles)
    caption = "Secant modulus over that at rest: equal moduli at rest are equal solids for infinitesimal strain only."
    return Figure(caption, inline_svg(drawing, key, caption))


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

    def draw(result, record, key):
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
        return Figure(caption, inline_svg(drawing, key, caption))

    return draw


def node_forces(result, record, key):
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
    return Figure(caption, inline_svg(drawing, key, caption))


def trajectory(result, record, key):
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
    return Figure(caption, inline_svg(drawing, key, caption))


def array_drag(result, record, key):
    """Drag of arrays of markers against the solid fraction, one curve for each relaxation time; below, error and slip."""
    if not drawable(record, "relaxation_time", "solid_fraction", "drag", "drag_exact", "error_drag", "slip"):
        return None
    drawing, (above, below) = canvas(2, height=5.2, sharex=True)
    # The series knows nothing of the relaxation time: one line through all rows.
    order = np.argsort(record["solid_fraction"])
    series = record["solid_fraction"][order], record["drag_exact"][order]
    handles = above.plot(*series, "-", color="#555555", linewidth=1, label="series")
    unit = powers(record.columns["relaxation_time"].dimension)
    for number, (tau, marker) in enumerate(zip(np.unique(record["relaxation_time"]), markers())):
        rows = record["relaxation_time"] == tau
        fraction, style = record["solid_fraction"][rows], dict(color=f"C{number}", marker=marker)
        handles += above.plot(fraction, record["drag"][rows], linestyle="none", label=f"τ = {tau:g} [{unit}]", **style)
        predicted = record["error_drag"][rows] > 1e-9  # the first is zero by the fit
        below.plot(fraction[predicted], record["error_drag"][rows][predicted], linestyle="-", **style)
        below.plot(fraction, record["slip"][rows], linestyle=":", markerfacecolor="none", **style)
    grey = dict(color="#555555", linewidth=1)
    kinds = [
        Line2D([], [], linestyle="-", marker="o", label="error of the drag", **grey),
        Line2D([], [], linestyle=":", marker="o", markerfacecolor="none", label="slip over U", **grey),
    ]
    above.set_ylabel(column_label(record.columns["drag"]))
    below.set_yscale("log")
    below.set_ylabel("relative error, slip [1]")
    below.set_xlabel(column_label(record.columns["solid_fraction"]))
    legend_above(above, handles)
    legend_above(below, kinds)
    caption = "Drag with the radius fitted to the most dilute array; below, error of the predicted ones and slip at the markers."
    return Figure(caption, inline_svg(drawing, key, caption))


def rounds(result, record, key):
    """Slip and errors of a plate against the rounds of forcing, and against run time, the phase `iterations/<row>`."""
    names = {"slip": "slip", "error_force": "force, thin plate", "error_theory": "force, plate of markers"}
    if not drawable(record, "iterations", *names):
        return None
    times = {row["phase"]: row["wall_seconds"] for row in result.timing}
    seconds = np.array([times.get(f"iterations/{row}", np.nan) for row in range(len(record))])
    drawing, panels = canvas(2, height=5.2)
    handles = []
    for number, ((name, label), marker) in enumerate(zip(names.items(), markers())):
        style = dict(color=f"C{number}", marker=marker, linestyle="-", label=label)
        handles += panels[0].plot(record["iterations"], record[name], **style)
        panels[1].plot(1000 * seconds, record[name], **style)
    panels[0].set_xscale("log")
    for panel in panels:
        panel.set_yscale("log")
        panel.set_ylabel("relative slip, error [1]")
        panel.margins(x=0.12, y=0.15)
    label_points(panels[0], record["iterations"])
    panels[0].set_xlabel(column_label(record.columns["iterations"]))
    panels[1].set_xlabel("run time of the row [ms]")
    legend_above(panels[0], handles)
    caption = "What more rounds of forcing buy. One run each: read the times to a factor of two."
    return Figure(caption, inline_svg(drawing, key, caption))


def rod_force(result, record, key):
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
    return Figure(caption, inline_svg(drawing, key, caption))


def beam_line(result, record, key):
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
    return Figure(caption, inline_svg(drawing, key, caption))


BOND_TABLE = "Force of one bond. Grey: there the peer does not compute the stated potential."
ANGLE_TABLE = "Force of one angle. Grey: there the peer does not compute the stated potential."
ENERGY = "Change of the total energy of a free motion: leap-frog keeps it within bounds."
TENSILE_ERRORS = ("force_error", "last_layer_error", "energy_error")
BEAM_ERRORS = ("tip_error", "reaction_error", "energy_error")

# Kinds of plot by the name of the record, in the order of the page. Validity is a table, and the bands of the others;
# what `couette` holds is round-off; `stroke_compared` is in the figure of `stroke`.
KINDS = {
    "potential": (potential_energy, tension),
    "stress_strain": (stress_strain, curve_error, moduli, moduli_near_rest),
    "moduli": (moduli, moduli_near_rest),
    "convergence": (convergence,),
    "work_precision": (work_precision, period_precision),
    "dispersion": (dispersion,),
    "constants": (constants,),
    "storage": (storage,),
    "delta_sums": (delta_scan,),
    "delta_imbalances": (delta_scan,),
    "delta_first_moments": (delta_scan,),
    "galilean": (galilean,),
    "boundary": (boundary,),
    "elastica": (elastica,),
    "buckling": (buckling,),
    "standing_waves": (standing_waves,),
    "conservation": (conservation,),
    "elastica_exact": (),
    "profile": (profile,),
    "slip": (slip,),
    "section": (section,),
    "drag": (drag,),
    "couette": (),
    "drift_of_mass": (drift,),
    "drift_of_momentum": (drift,),
    "drift_of_staggered_momentum": (drift,),
    "substeps": (),  # drawn beside work_precision
    "bond_table": (against_peer("r", "force", "peer_force", ("force_error", "energy_error"), BOND_TABLE),),
    "angle_table": (against_peer("theta", "force", "peer_force", ("force_error", "energy_error"), ANGLE_TABLE),),
    "node_forces": (node_forces,),
    "end_force": (against_peer("strain", "force", "peer_force", TENSILE_ERRORS, "Tensile curves of both programs."),),
    "cantilever": (against_peer("load", "deflection", "peer_deflection", BEAM_ERRORS, "Deflection of the last layer."),),
    "trajectory": (trajectory,),
    "energy": (against_peer("step", "change", "peer_change", ("energy_error",), ENERGY),),
    "centre_lines": (centre_lines,),
    "law_deviation": (law_deviation,),
    "stroke": (stroke,),
    "stroke_compared": (),
    "film": (film,),
    "first_harmonic": (first_harmonic,),
    "sensitivity": (sensitivity,),
    "last_good_nodes": (last_good_nodes,),
    "coupling_boundary": (coupling_boundary,),
    "strain_histogram": (strain_histogram,),
    "modulus_deviation": (modulus_deviation,),
    "array": (array_drag,),
    "iterations": (rounds,),
    "rod": (rod_force,),
    "deflection": (beam_line,),
    "validity": (),
}


def of_case(result, key):
    """All figures of a result. `key` must be unique on the page."""
    figures = []
    order = {name: place for place, name in enumerate(KINDS)}
    for record in sorted(result.records.values(), key=lambda record: order.get(record.name, len(order))):
        for draw in KINDS.get(record.name, (against_first_column,)):
            drawn = draw(result, record, f"{key}-{len(figures)}")
            if drawn is not None:
                figures.append(drawn)
    return figures
