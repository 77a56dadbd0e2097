"""Where a case stands on the page: its group, its set-up, the command that runs it again."""

import tomllib

from report import text
from report.sources import ROOT

COST, OTHERS = "Cost, and parts left out", "Other cases"
# Headings and the topics that belong under them; a case stands under the first that it has a topic of.
GROUPS = {
    "The paper’s filament": {"filament"},
    "Numbers of other codes": {"external"},
    "Against another program": {"peer"},
    "Stable where": {"stability"},
    COST: {"study"},
    "Coupling of body and fluid": {"coupling"},
    "Bond laws": {"bond"},
    "Bodies in motion": {"dynamics", "waves+solid", "conservation+solid", "invariance"},
    "Bodies at rest": {"tensile", "elasticity", "bending", "buckling", "torsion", "shear"},
    "Fluid": {"fluid"},
}
ORDER = ("The paper’s filament", "Bond laws", "Bodies at rest", "Bodies in motion", "Fluid", "Coupling of body and fluid")
KNOWN = {"schema", "id", "title", "question", "equation", "sources", "tier", "topics", "driver", "check", "assumed"}
LONG = 90  # characters of a value; of longer lists the ends are shown


def is_compared(result):
    """Whether it computes a system of the ledger of exact laws and published values."""
    return any(check.kind == "verification" and check.claim for check in result.checks)


def group_of(result):
    """Heading of a case; the first topic of one that has none of those known."""
    topics = set(result.topics)
    topics |= {f"{topic}+solid" for topic in topics if "solid" in topics}
    for heading, wanted in GROUPS.items():
        if topics & wanted or (heading == COST and "ablate" in result.records):
            if heading == COST and is_compared(result):
                continue  # its sizes are there to meet what is known: under its own subject
            return heading
    return result.topics[0].capitalize() if result.topics else OTHERS


def grouped(results):
    """Headings with their results, in the order of the page."""
    found = {}
    for result in results:
        found.setdefault(group_of(result), []).append(result)
    if list(found) == [OTHERS]:
        found = {"Cases": found[OTHERS]}
    order = [*ORDER, *(heading for heading in GROUPS if heading not in ORDER)]
    return sorted(found.items(), key=lambda group: order.index(group[0]) if group[0] in order else len(order))


def in_words(value):
    """A value of a case file."""
    if isinstance(value, dict):
        return ", ".join(f"{key} = {in_words(inner)}" for key, inner in value.items())
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        words = ", ".join(in_words(inner) for inner in value)
        if len(words) > LONG and len(value) > 4:
            words = f"{in_words(value[0])}, {in_words(value[1])}, … {in_words(value[-1])} ({len(value)} values)"
        return words
    return str(value)


def leaves(table, path=""):
    """Keys of a case file with their values; tables of tables by their numbers."""
    for key, value in table.items():
        place = f"{path}{key}"
        many = isinstance(value, dict) and (len(value) > 2 or any(isinstance(inner, (dict, list)) for inner in value.values()))
        if many or (isinstance(value, dict) and value and not path):
            yield from leaves(value, f"{place}.")
        elif isinstance(value, list) and value and all(isinstance(inner, dict) for inner in value):
            for number, inner in enumerate(value):
                yield from leaves(inner, f"{place}.{number}.")
        else:
            yield place, in_words(value)


def set_up(result):
    """Rows (key, value, why it was assumed) of what the case file says of the scene; none of a file that is no TOML."""
    try:
        case = tomllib.loads(result.case_text)
    except tomllib.TOMLDecodeError:
        return []
    why = {row["path"]: row["why"] for row in result.assumed}
    rows = [(key, value, why.pop(key, "")) for key, value in leaves({k: v for k, v in case.items() if k not in KNOWN})]
    return rows + [(row["path"], row["value"], row["why"]) for row in result.assumed if row["path"] in why]


def monitored(result, *keys):
    """Number at a place of the case file, None where it names none."""
    try:
        value = tomllib.loads(result.case_text)
        for key in keys:
            value = value[key]
        return float(value)
    except (tomllib.TOMLDecodeError, KeyError, TypeError, ValueError):
        return None


def rerun(result):
    """Command that makes the result again."""
    shipped = (ROOT / "cases" / f"{result.case_id}.toml").is_file()
    return text.command("run", result.case_id if shipped else result.case_path or result.case_id, result.overrides)


def skipped(results_read):
    """Cases of the repository without a result here, by tier, in words: "34 of tier full, 2 of tier paper"; empty, if none."""
    there = {result.id for result in results_read}
    tiers = {"quick": 0, "full": 0, "paper": 0}
    for file in (ROOT / "cases").glob("*.toml"):
        try:
            case = tomllib.loads(file.read_text("utf-8"))
        except (OSError, ValueError):
            continue
        if case.get("tier") in tiers and case.get("id") not in there:
            tiers[case["tier"]] += 1
    return ", ".join(f"{count} of tier {tier}" for tier, count in tiers.items() if count)
