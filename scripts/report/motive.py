"""The paper's motive: are FENE-LJ bonds stable for stiffer structures than harmonic ones? For which load, which step,
which meaning of failure; only from searches for a limit, and from the ledger.

A search says along the node mass, or along the stiffness of a body, where runs no longer end well. At a step of 1 a body
alone knows one number that holds its stiffness, E r0^3/m, so that the inverse of a least node mass counts as a stiffness.
"""

from dataclasses import dataclass

import numpy as np

from report import stability, topics

FIRST, OTHER = "harmonic", "fene-lj"
STATEMENTS = ("harmonic-diverges", "well-traps", "stiffer-structures", "one-time-step", "validation", "first-time")  # Secs. 1 and 4
ALIKE = 0.02  # two boundaries to a per cent each


@dataclass(frozen=True)
class Row:
    result: object
    meaning: str  # of failure
    where: str  # what the bodies of the row have in common
    ratios: tuple  # stiffness carried with FENE-LJ bonds over that with harmonic ones, by conditions
    lost: int  # FENE-LJ fails wherever it is looked for, harmonic does not
    gained: int  # the reverse
    ends: tuple  # how runs end behind the boundary: of harmonic bonds, of FENE-LJ

    def count(self, kind):
        return sum(kind_of(ratio) == kind for ratio in self.ratios)


def kind_of(ratio):
    return "as stiff" if abs(ratio - 1) <= ALIKE else "stiffer" if ratio > 1 else "softer"


def conditions(record, row, without):
    """Values of all axes but these, as text."""
    names = list(record.columns)
    axes = names[: names.index("boundary")]
    return tuple((name, str(record[name][row])) for name in axes if name not in without)


def pairs(result):
    """(conditions, row of harmonic, row of FENE-LJ) of a search that has both."""
    record = result.records["outcome_boundary"]
    of_law = {
        law: {conditions(record, row, (stability.LAW,)): row for row in np.flatnonzero(record[stability.LAW] == law)}
        for law in (FIRST, OTHER)
    }
    return [(found, row, of_law[OTHER][found]) for found, row in of_law[FIRST].items() if found in of_law[OTHER]]


def meaning_of(found, result):
    """What counts as failure: that is an axis of the search, or the same everywhere."""
    strict = dict(found).get(stability.PHYSICAL, "true" if topics.monitored(result, "monitor", "physical") else "false")
    return "the run breaks, or its state is unphysical" if strict == "true" else "the run breaks"


def in_fluid(result):
    return "coupling" in result.topics


def common(found):
    """What rows are grouped by beside the meaning of failure: how a coupled body is stepped."""
    values = dict(found)
    if "body.0.substeps" not in values:
        return ""
    steps = f"{float(values['body.0.substeps']):g}"
    if steps == "1":
        return "1 sub-step"
    return f"{steps} sub-steps, force {'following' if values.get('body.0.coupling.subcycled') == 'true' else 'frozen'}"


def rows(results):
    made = []
    for result in results:
        record = result.records.get("outcome_boundary")
        along_mass = stability.is_search(record) and not in_fluid(result)  # there mass and stiffness are two numbers
        if result.variant or not (along_mass or stability.is_stiffness_search(record)):
            continue
        groups = {}
        for found, first, other in pairs(result):
            groups.setdefault((meaning_of(found, result), common(found)), []).append((first, other))
        for (meaning, where), members in groups.items():
            a, b = (record["boundary"][list(side)] for side in zip(*members))
            ratios = a / b if along_mass else b / a
            ends = [", ".join(sorted({str(end) for end in record["outcome_behind"][list(side)]})) for side in zip(*members)]
            made.append(
                Row(
                    result,
                    meaning,
                    where,
                    tuple(ratios[np.isfinite(ratios)]),
                    int(np.sum(np.isfinite(a) & np.isnan(b))),
                    int(np.sum(np.isnan(a) & np.isfinite(b))),
                    tuple(ends),
                )
            )
    return made


def sentences(found):
    """For each meaning of failure, alone and in a fluid, how often FENE-LJ bonds carry stiffer bodies."""
    said = []
    for meaning in dict.fromkeys(row.meaning for row in found):
        for fluid in (False, True):
            chosen = [row for row in found if row.meaning == meaning and in_fluid(row.result) == fluid]
            ratios = [ratio for row in chosen for ratio in row.ratios]
            lost, gained = (sum(getattr(row, name) for row in chosen) for name in ("lost", "gained"))
            if not ratios and not lost and not gained:
                continue
            kinds = {kind: [ratio for ratio in ratios if kind_of(ratio) == kind] for kind in ("stiffer", "as stiff", "softer")}
            text = f"{'In a fluid' if fluid else 'In vacuum'}, failure meaning that {meaning}: of {len(ratios) + lost + gained} conditions "
            text += f"FENE-LJ bonds carry stiffer bodies than harmonic ones under {len(kinds['stiffer'])}"
            if kinds["stiffer"]:
                text += f" (up to {max(kinds['stiffer']):.2g} times)"
            text += f", as stiff ones under {len(kinds['as stiff'])}, softer ones under {len(kinds['softer'])}"
            if kinds["softer"]:
                text += f" (down to {min(kinds['softer']):.2g} of the stiffness)"
            if lost or gained:
                text += f"; under {lost} they fail at every stiffness tried and harmonic bonds do not, under {gained} the reverse"
            said.append(text + ".")
    return said


def statements(entries):
    """The entries of the ledger that the motive stands on, in its order."""
    return [entry for entry in entries if entry["id"] in STATEMENTS]
