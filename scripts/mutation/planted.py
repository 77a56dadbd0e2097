"""Planted bugs (lib/base/mutant.hpp): which of them the cases and tests notice, and by how much."""

import json
import re
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from mutation.suite import Outcome, Suite

FACTORS = [0.1, 0.5, 1.0, 2.0, 10.0]  # of all tolerances


def table(root):
    """Of each planted bug its name, what is wrong, and the place of its switch."""
    header = (root / "lib/base/mutant.hpp").read_text()
    named = dict(re.findall(r'EACH\((\w+), "((?:[^"\\]|\\.)*)"\)', header))
    places = {}
    for path in sorted([*root.glob("lib/**/*.[ch]pp"), *root.glob("verify/**/*.[ch]pp")]):
        if path.name.startswith("mutant"):
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            for name in re.findall(r"planted\(Mutant::(\w+)\)", line):
                places.setdefault(name, f"{path.relative_to(root)}:{number}")
    lost = sorted(set(named) - set(places))
    if lost:
        raise SystemExit(f"mutants: no source asks for {', '.join(lost)}. Plant or remove them in lib/base/mutant.hpp")
    return {name: {"what": what, "place": places[name]} for name, what in named.items()}


def run_all(build, names, seconds, jobs, show, told):
    """Puts each bug before all cases and tests that take up to so many seconds, and where these let it pass before the slower ones, up to the
    first that does not. `told` is called after each with all tests, those that meet every bug, and the outcomes by bug until then."""
    suite = Suite.of_build(build)
    tests = suite.timed(build / "planted-times.json", jobs, show)
    cheap = [test for test in tests if test.seconds <= seconds]
    slow = sorted((test for test in tests if test.seconds > seconds), key=lambda test: test.seconds)

    def meet(name):
        outcomes = suite.confirmed(suite.run(cheap, name), cheap, name)
        if not any(outcome.caught for outcome in outcomes.values()):
            outcomes |= suite.confirmed(suite.run(slow, name, until_caught=True), slow, name)
        return outcomes

    found = {}
    with ThreadPoolExecutor(jobs) as workers:
        waiting = {workers.submit(meet, name): name for name in names}
        for met in as_completed(waiting):
            name = waiting[met]
            found[name] = met.result()
            caught = sum(outcome.caught for outcome in found[name].values())
            show(f"{len(found)} of {len(names)}: {name} " + (f"caught by {caught}" if caught else "SURVIVES"))
            told(tests, cheap, found)


def summary(root, names, tests, met_all, found, took):
    """All that is known, as plain data."""
    known = table(root)
    bugs = {}
    for name in names:
        caught = {label: outcome for label, outcome in found[name].items() if outcome.caught}
        bugs[name] = {**known[name], "caught": bool(caught),
                      "cases": {label[5:]: how_much(o) for label, o in caught.items() if label.startswith("case ")},
                      "units": {label.split(" ", 1)[1]: o.how for label, o in caught.items() if not label.startswith("case ")},
                      "met": len(found[name])}
    idle = [test.label for test in met_all if not any(found[name].get(test.label, Outcome("passed")).caught for name in names)]
    return {"planted": len(names), "caught": sum(bug["caught"] for bug in bugs.values()), "seconds": round(took),
            "by_cases": sum(bool(bug["cases"]) for bug in bugs.values()), "by_units": sum(bool(bug["units"]) for bug in bugs.values()),
            "tests": len(tests), "met_every_bug": len(met_all), "bugs": bugs, "caught_nothing": idle,
            "tolerances": [at_tolerance(factor, names, met_all, found) for factor in FACTORS]}


def how_much(outcome):
    """How a case ended, and the largest margin of its checks."""
    margins = [margin for _, _, margin, verdict in outcome.margins if verdict != "finding" and margin is not None]
    return {"how": outcome.how, "margin": max(margins, default=None)}


def at_tolerance(factor, names, tests, found):
    """What the cases that met every bug would have caught, had every tolerance been so many times what it is. A margin is error over
    tolerance, or for what must lie outside of its tolerance the inverse: both are divided by the factor. Checks that would then fail
    without a bug are none. A refuted claim has a margin above 1 as long as nothing is wrong, and is judged by a band around what was
    recorded: no factor changes whether it stands."""
    checks = {(test.label, metric, statement): (margin, verdict)
              for test in tests if test.kind == "case" for metric, statement, margin, verdict in test.margins}
    refuted = {check for check, (_, verdict) in checks.items() if verdict == "finding"}
    good = {check for check, (margin, _) in checks.items() if check not in refuted and margin is not None and margin <= factor}

    def catches(label, outcome):
        if outcome.how in ("error", "crash", "time-out"):
            return True
        told = [((label, metric, statement), margin, verdict) for metric, statement, margin, verdict in outcome.margins]
        return any(check in refuted and verdict == "fail" or check in good and (margin is None or margin > factor) for check, margin, verdict in told)

    labels = {test.label for test in tests if test.kind == "case"}
    caught = [name for name in names if any(catches(label, outcome) for label, outcome in found[name].items() if label in labels)]
    return {"factor": factor, "caught": len(caught), "missed": sorted(set(names) - set(caught)),
            "would_fail_without_a_bug": len(checks) - len(refuted) - len(good)}


def markdown(told):
    share = 100.0 * told["caught"] / told["planted"]
    lines = ["# Planted bugs", "",
             f"{told['caught']} of {told['planted']} are caught ({share:.1f} %): {told['by_cases']} by quick cases, {told['by_units']} by unit "
             f"tests. {told['met_every_bug']} of {told['tests']} cases and tests met every bug, the slower ones only those that these "
             f"let pass. It took {told['seconds'] / 60:.0f} minutes.", "",
             "| bug | what is wrong | where | cases | largest margin | unit tests |", "|---|---|---|---|---|---|"]
    for name, bug in told["bugs"].items():
        margins = [case["margin"] for case in bug["cases"].values() if case["margin"] is not None]
        how = {f"{case['how']}" for case in bug["cases"].values() if case["how"] != "failed"} | {h for h in bug["units"].values() if h != "failed"}
        cases = shown(bug["cases"]) + (f" ({', '.join(sorted(how))})" if how else "")
        lines.append(f"| {name} | {bug['what']} | {bug['place']} | {cases} | {max(margins):.2g} | {shown(bug['units'])} |" if margins else
                     f"| {name} | {bug['what']} | {bug['place']} | {cases or '-'} | - | {shown(bug['units']) or ('-' if bug['caught'] else '**survives**')} |")
    lines += ["", "## Detection against tolerance", "",
              "By the quick cases that met every bug, from the margins of their checks. A check that would fail without a bug counts for nothing.", "",
              "| all tolerances times | bugs caught | checks that would fail without a bug |", "|---|---|---|"]
    lines += [f"| {at['factor']:g} | {at['caught']} | {at['would_fail_without_a_bug']} |" for at in told["tolerances"]]
    lines += ["", "## Cases and tests that caught nothing", "", "Of those that met every bug:", ""]
    return "\n".join(lines + [f"- {label}" for label in told["caught_nothing"]]) + "\n"


def shown(names, most=3):
    """Some of the names, and how many more."""
    some = ", ".join(list(names)[:most])
    return some + (f" and {len(names) - most} more" if len(names) > most else "")


def main(root, build, names, seconds, jobs, out, show):
    known = table(root)
    unknown = [name for name in names if name not in known]
    if unknown:
        raise SystemExit(f"mutants: no bug '{unknown[0]}' is planted. lib/base/mutant.hpp lists all")
    start = time.monotonic()
    wanted = names or list(known)
    out.mkdir(parents=True, exist_ok=True)
    told = {}

    def tell(tests, met_all, found):  # after each bug, so that a run that is broken off leaves what it has found
        done = [name for name in wanted if name in found]
        told.update(summary(root, done, tests, met_all, found, time.monotonic() - start))
        (out / "planted.json").write_text(json.dumps(told, indent=1))
        (out / "planted.md").write_text(markdown(told))

    run_all(build, wanted, seconds, jobs, show, tell)
    survivors = [name for name, bug in told["bugs"].items() if not bug["caught"]]
    print(f"planted bugs: {told['caught']} of {told['planted']} caught" + (f"; {', '.join(survivors)} survive" if survivors else ""))
    for at in told["tolerances"]:
        print(f"  all tolerances times {at['factor']:g}: the quick cases that met every bug catch {at['caught']}")
    print(f"  {len(told['caught_nothing'])} of {told['met_every_bug']} cases and tests that met every bug caught none\n  {out}/planted.md, {out}/planted.json")
    return 1 if survivors else 0
