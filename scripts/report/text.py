"""Numbers, units and names as the page has them."""

import math
import os
import re
import shlex
from collections import Counter

from markupsafe import Markup

PRINTED = 10  # a target of at most that many digits counts as a printed number
RAISED = str.maketrans("-−+.0123456789", "⁻⁻⁺·⁰¹²³⁴⁵⁶⁷⁸⁹")


def raised(text):
    """Powers of ten as people write them: "2e-06" as "2×10⁻⁶", "1e5" as "×10⁵" where it multiplies an axis."""
    text = re.sub(r"e([-−+]?)0*(\d+)", lambda found: "×10" + (found.group(1).strip("+") + found.group(2)).translate(RAISED), text)
    return re.sub(r"^1(?=×10)", "", text)


def powers_of_ten(mantissa, exponent):
    return Markup("{} × 10<sup>{}</sup>").format(mantissa, str(exponent).replace("-", "−"))


def unusual(value):
    """Text of a number that has no digits, None for all others."""
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    return "0" if value == 0 else None


def exponent_of(value):
    """Decimal exponent of a finite number other than zero."""
    return int(f"{value:e}".split("e")[1])


def numeral(value, digits=6):
    """Number with that many significant digits, trailing zeros dropped."""
    text = unusual(value)
    if text is not None:
        return text
    exponent = exponent_of(value)
    if -4 <= exponent < 6:
        text = f"{value:.{max(digits - 1 - exponent, 0)}f}"
        return (text.rstrip("0").rstrip(".") if "." in text else text).replace("-", "−")
    mantissa = f"{value:.{digits - 1}e}".split("e")[0]
    mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    return powers_of_ten(mantissa.replace("-", "−"), exponent)


def in_full(value, text):
    """A number whose title says it in full, where the text does not."""
    full = repr(float(value)).removesuffix(".0")
    return text if str(text).replace("−", "-") == full else Markup('<span title="{}">{}</span>').format(full, text)


def stated_digits(value):
    """Significant digits of the shortest decimal number that is this double."""
    return len(repr(float(value)).split("e")[0].replace(".", "").strip("-0"))


def side_by_side(measured, target, tolerance):
    """Measured and target with as many digits as show how they differ, or the tolerance; differing digits are bold.

    A target of few digits, such as a printed one, is shown as it was stated.
    """
    plain = in_full(measured, numeral(measured, 4)), in_full(target, numeral(target, 4))
    if unusual(measured) or unusual(target):
        return plain
    scale = max(abs(measured), abs(target))
    apart = abs(measured - target) or abs(tolerance)
    if not math.isfinite(apart) or apart > 0.1 * scale:
        return plain
    stated = stated_digits(target)
    digits = max(math.ceil(math.log10(scale / apart)) + 2 if apart else 17, 4, stated if stated <= PRINTED else 0)
    digits = min(digits, max(stated_digits(measured), stated, 4))
    exponent = exponent_of(scale)
    shift = 0 if -4 <= exponent < 6 else exponent
    decimals = max(digits - 1 - (exponent - shift), 0)
    texts = [f"{value / 10.0**shift if shift else value:.{decimals}f}" for value in (measured, target)]
    alike = len(os.path.commonprefix(texts)) if texts[0] != texts[1] else len(texts[0])
    if stated <= PRINTED and "." in texts[1]:
        texts[1] = texts[1].rstrip("0").rstrip(".")
    shown = []
    for value, text in zip((measured, target), texts):
        same, other = text[:alike].replace("-", "−"), text[alike:].replace("-", "−")
        body = Markup("{}<b>{}</b>").format(same, other) if other else same
        shown.append(in_full(value, powers_of_ten(body, shift) if shift else body))
    return tuple(shown)


def badge(verdict, text=None):
    """Verdict as a word, before which the style sheet puts a mark: colour alone says nothing."""
    return Markup('<span class="verdict {}">{}</span>').format(verdict, text or verdict)


def seconds(value):
    """Duration in words of the right size."""
    if value < 1e-3:
        return f"{value * 1e6:.0f} µs"
    if value < 1:
        return f"{value * 1e3:.3g} ms"
    return f"{value:.3g} s" if value < 120 else f"{value / 60:.3g} min"


def memory(count):
    """Bytes in words of the right size."""
    for unit in ("B", "kB", "MB"):
        if abs(count) < 1000:
            return f"{count:.3g} {unit}"
        count /= 1000
    return f"{count:.3g} GB"


def anchor(result):
    """Name of a case's section; from the file's name, which is unique in a folder."""
    return "case-" + re.sub(r"[^A-Za-z0-9_-]", "-", result.file.stem)


def wall_seconds(result):
    return sum(row["wall_seconds"] for row in result.timing)


def passed(result):
    return sum(check.verdict == "pass" for check in result.checks)


def worst_margin(result):
    """Largest margin, None without any; without refuted claims, which are beyond their tolerance by nature."""
    margins = [check.margin for check in result.checks if check.verdict != "finding"]
    return max(margins, key=lambda margin: math.inf if math.isnan(margin) else margin, default=None)


def dimension_of(result, name):
    """Dimension of a metric, empty for a number."""
    stated = next((metric.dimension for metric in result.metrics if metric.name == name), "")
    return "" if stated == "1" else stated


def command(verb, case, overrides=()):
    """A command line of veriflex."""
    words = ["veriflex", verb, case]
    for override in overrides:
        words += ["--set", override]
    return shlex.join(words)


def as_they_stand(results_read):
    """The results of cases that no --set has changed: only these are counted."""
    return [result for result in results_read if not result.variant]


def provenance(results_read):
    """Values that the files state for each property of program and machine, with the number of files."""
    names = dict.fromkeys(name for result in results_read for name in result.provenance)
    return {name: Counter(result.provenance.get(name, "not stated") for result in results_read) for name in names}


def dates(results_read):
    """First and last date of the files, one if they are the same."""
    met = sorted({result.provenance.get("date", "") for result in results_read} - {""})
    return met if len(met) < 2 else [met[0], met[-1]]
