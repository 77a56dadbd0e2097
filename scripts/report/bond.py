"""Figures of bond laws: energy, tension, moduli, and stress against strain."""

from dataclasses import dataclass
from itertools import count

import matplotlib
import numpy as np
from matplotlib.patches import Patch

from report.drawing import (
    FEW_ROWS,
    Figure,
    MARK,
    MARKED_ROWS,
    canvas,
    column_label,
    drawable,
    extent,
    inline_svg,
    known,
    legend_above,
    limits,
    quantity,
    upright,
)

BAND_COLOURS = ("#8DB4D6", "#BCD4E8", "#E1ECF5")  # narrowest tolerance first


@dataclass(frozen=True)
class Band:
    """Strains at which a modulus departs from that at rest by at most `tolerance`; -1 and inf mean unbounded."""

    tolerance: float
    low: float
    high: float


def at_rest(record, name):
    """Value of a column at zero strain, between the nearest rows."""
    strain, values = record["strain"], record[name]
    finite = np.isfinite(strain) & np.isfinite(values)
    return np.interp(0.0, strain[finite], values[finite])


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


def potential_energy(result, record):
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
    return Figure(caption, inline_svg(drawing, caption))


def tension(result, record):
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
    return Figure(caption, inline_svg(drawing, caption))


def keep_near(axes, curve, straight):
    """Limit the ordinate to the curve, to 1.4 times the straight line's range at most: laws diverge at their limits."""
    low, high = extent(straight)
    reach = 1.4 * max(abs(low), abs(high))
    smallest, largest = extent(curve)
    axes.set_ylim(*limits(np.array([max(min(smallest, low), -reach), min(max(largest, high), reach)])))


def zero_by_zero(record):
    """Rows at zero strain without a secant: left out, lest they cut the curve in two."""
    return (record["strain"] == 0) & np.isnan(record["secant_ratio"])


def moduli(result, record):
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
    return Figure(caption, inline_svg(drawing, caption))


def moduli_near_rest(result, record):
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
    return Figure(caption, inline_svg(drawing, caption))


def stress_references(result):
    """References that hold a stress-strain curve."""
    return [reference for reference in result.references if drawable(reference.columns, "strain", "stress")]


def stress_strain(result, record):
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
    return Figure(caption, inline_svg(drawing, caption))


def curve_error(result, record):
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
    return Figure(caption, inline_svg(drawing, caption))


def root_search(result, record):
    """Errors against evaluations of the tension."""
    if not drawable(record, "evaluations", "rest_length_error", "young_modulus_error"):
        return None
    drawing, (axes,) = canvas(height=2.7)
    handles = []
    for name, label, style in (("young_modulus_error", "Young's modulus", "s-"), ("rest_length_error", "rest length", "o--")):
        handles += axes.plot(record["evaluations"], np.maximum(record[name], 2.0**-54), style, label=label)
    axes.set_yscale("log")
    axes.set_xlabel("evaluations of the tension [1]")
    axes.set_ylabel("relative error [1]")
    legend_above(axes, handles)
    caption = "What an accuracy of rest length and modulus costs: the best so far of the search; no error is drawn as 2⁻⁵⁴."
    return Figure(caption, inline_svg(drawing, caption))


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


def bond_laws(results):
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
    return Figure(caption, inline_svg(drawing, caption))


def bond_laws_secant(results):
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
    return Figure(caption, inline_svg(drawing, caption))
