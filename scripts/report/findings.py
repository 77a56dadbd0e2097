"""What the results say of the paper, in sentences, the most important first.

A sentence stands only while the checks that it speaks of judge as it says; its numbers are those of metrics and checks.
"""

from dataclasses import dataclass

from markupsafe import Markup

from report.text import numeral


@dataclass(frozen=True)
class Finding:
    text: Markup  # each number is a <data> whose value is that of the result file
    result: object
    claims: tuple  # ids of the statements in the ledger


def number(value, digits=3, factor=1.0, unit=""):
    return Markup('<data value="{}">{}{}</data>').format(repr(float(value)), numeral(factor * value, digits), unit)


def percent(value, digits=2):
    return number(value, digits, 100.0, " %")


class Case:
    """Metrics and checks of a result; asking for what is not there raises LookupError."""

    def __init__(self, result):
        self.result = result

    def metric(self, name):
        value = self.result.metric(name)
        if value is None or value != value:
            raise LookupError(name)
        return value

    def check(self, start, verdict):
        """The first claim on a metric of that name that was judged so."""
        for check in self.result.checks:
            if check.kind == "claim" and check.metric.startswith(start) and check.verdict == verdict:
                return check
        raise LookupError(start)


def one_step(case):
    case.check("failures", "finding")
    return (
        "With one solid step per step of the fluid, as the paper has it, the FENE-LJ filament breaks at its abrupt start. "
        "The harmonic one, said to diverge, runs, and stays within {} of the amplitude of the FENE-LJ run with sub-steps.",
        [percent(case.metric("effect_harmonic"))],
    )


def stiffer(case):
    found = [check.measured for check in case.result.checks if check.metric.startswith("ratio(boundary)") and check.verdict == "finding"]
    if not found:
        raise LookupError("ratio(boundary)")
    return (
        "Released from a small strain, FENE-LJ bonds carry softer bodies, not stiffer ones: at the same step and stiffness they need "
        "{} to {} times the node mass of harmonic bonds.",
        [number(min(found)), number(max(found))],
    )


def same_shape(case):
    return (
        "Driven as in the paper, the centre lines of both laws agree to {} of the amplitude, although bonds are strained from {} to {}, far beyond "
        "what one modulus describes.",
        [percent(case.metric("deviation_z_max")), percent(case.metric("min_strain")), percent(case.metric("max_strain"))],
    )


def blurred(case):
    low, high = case.check("modulus_low", "finding"), case.check("modulus_high", "finding")
    return (
        "The figures of the filament do not determine the modulus: bodies of {} and {} times the right one move as far from it as the other "
        "law does.",
        [number(low.measured), number(high.measured)],
    )


def modulus(case):
    published = case.check("young_modulus", "finding")
    case.check("young_modulus_at_rounded", "pass")
    linear = case.check("secant_valid_to_1pct", "finding")
    return (
        "Young’s modulus of the bond is {} η/σ³; the printed {} comes from a rounded rest length. It describes the bond within {} "
        "only for strains from {} to {}.",
        [
            number(case.metric("young_modulus"), 8),
            number(published.target, 8),
            percent(linear.target),
            percent(case.metric("secant_valid_from_1pct"), 3),
            percent(case.metric("secant_valid_to_1pct"), 3),
        ],
    )


def delta(case):
    case.check("cosine_ball_sum_min", "finding")
    return (
        "The delta function cut to a ball is none: its weights add up to {} at least and {} on average, so that what body and "
        "fluid exchange is lost in part.",
        [number(case.metric("cosine_ball_sum_min")), number(case.metric("cosine_ball_sum_mean"))],
    )


def slip(case):
    check = case.check("slip", "finding")
    return "The coupling keeps no-slip only in part: an oscillating slice of the rod slips by {} of its largest speed.", [percent(check.measured)]


# The case that each sentence is about, the statements of the ledger, and the sentence, in the order of their weight.
SENTENCES = (
    ("filament-one-substep", ("one-time-step", "well-traps"), one_step),
    ("step-limit", ("stiffer-structures",), stiffer),
    ("filament-stroke-full", ("represented-precisely", "validation"), blurred),
    ("filament-stroke", ("represented-precisely",), same_shape),
    ("derive-fene-lj", ("young-modulus", "first-order"), modulus),
    ("delta-moments", ("delta-function", "interpolation"), delta),
    ("immersed-rod", ("no-slip",), slip),
)
MOST = 5  # that the first screen has room for


def of(results):
    """The sentences that these results support."""
    by_id = {result.id: result for result in results}
    found = []
    for name, claims, sentence in SENTENCES:
        if name not in by_id:
            continue
        try:
            words, numbers = sentence(Case(by_id[name]))
        except LookupError:
            continue
        found.append(Finding(Markup(words).format(*numbers), by_id[name], claims))
    return found[:MOST]
