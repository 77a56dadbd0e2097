"""The quick cases, the unit tests and a script of a build, one by one and with limits: what a mutant must get past.

A test that ends by itself has passed or failed. One that takes many times as long as without a bug is killed, and counts as caught by
time-out: what takes for ever is noticed.
"""

import hashlib
import json
import os
import resource
import shutil
import signal
import subprocess
import tempfile
import time
import xml.etree.ElementTree as ET
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path

TIMES, SECONDS = 8.0, 10.0  # a test may take so many times its own CPU time, and so many seconds more
MEMORY = 16 << 30  # bytes of address space: what asks for ever more ends before the machine does
BATCH = 40  # unit tests that one program runs
SCRIPTS = {"reading script": Path(__file__).resolve().parent.parent / "test_reading.py"}  # which is given the command


@dataclass
class Test:
    kind: str  # "case", "unit" or "script"
    name: str
    seconds: float = 0.0  # of CPU time, without a bug
    margins: list = field(default_factory=list)  # of a case's checks: error over tolerance, without a bug

    @property
    def label(self):
        return f"{self.kind} {self.name}"


@dataclass
class Outcome:
    how: str  # "passed", "failed", "error", "crash", "time-out"
    margins: list = field(default_factory=list)  # [metric, statement, margin, verdict] of each check of a case
    seconds: float = 0.0

    @property
    def caught(self):
        return self.how != "passed"


class Suite:
    """Of the command and of the unit tests. `environment`: what is set beside the caller's own."""

    def __init__(self, program, unit, environment=None):
        self.program, self.unit, self.environment = program, unit, environment or {}

    @classmethod
    def of_build(cls, build):
        program, unit = Path(build) / "veriflex", Path(build) / "verify" / "veriflex_unit"
        for one in (program, unit):
            if not one.exists():
                raise SystemExit(f"mutants: {one} is missing. Build the targets veriflex and veriflex_unit there")
        return cls(program, unit)

    def tests(self):
        """All of them, without their times."""
        cases = json.loads(self._say([self.program, "list", "--tier", "quick", "--json"]))
        units = self._say([self.unit, "--list-test-names-only"]).splitlines()
        return ([Test("case", case["id"]) for case in cases] + [Test("unit", name) for name in units if name] +
                [Test("script", name) for name in SCRIPTS])

    def timed(self, kept, jobs, show):
        """All tests with their times and margins, which are measured once for these programs and then kept in that file. All must pass."""
        key = hashlib.sha256(self.program.read_bytes() + self.unit.read_bytes()).hexdigest()
        known = {}
        if kept.exists() and (stored := json.loads(kept.read_text()))["programs"] == key:
            known = {test.label: test for test in (Test(**one) for one in stored["tests"])}
        tests = [known.get(test.label, test) for test in self.tests()]
        new = [test for test in tests if test.label not in known]
        broken = []

        def measure(test):
            outcome = self.run([test], cpu=600.0)[test.label]
            if outcome.caught:  # once more: a test that waits for something may fail on a busy machine
                outcome = self.run([test], cpu=600.0)[test.label]
            test.seconds, test.margins = outcome.seconds, outcome.margins
            if outcome.caught:
                broken.append(f"{test.label} ({outcome.how})")

        if new:
            show(f"{len(new)} cases and tests without a bug")
        with ThreadPoolExecutor(jobs) as workers:
            list(workers.map(measure, new))
        kept.parent.mkdir(parents=True, exist_ok=True)
        passed = [asdict(test) for test in tests if not any(b.startswith(test.label) for b in broken)]
        kept.write_text(json.dumps({"programs": key, "tests": passed}, indent=1))
        if broken:
            raise SystemExit(f"mutants: these do not pass without a bug, mend them first: {', '.join(broken)}")
        return tests

    def run(self, tests, mutant=None, until_caught=False, cpu=None):
        """Outcome of each test that was run, by label. `until_caught`: none after the first that is."""
        outcomes = {}
        with Scratch() as folder:
            environment = {**os.environ, **self.environment, "TMPDIR": folder, "XDG_CACHE_HOME": f"{folder}/cache",
                           "OMP_WAIT_POLICY": "passive"}
            if mutant:
                environment["VERIFLEX_MUTANT"] = mutant
            waiting = list(tests)
            while waiting and not (until_caught and any(o.caught for o in outcomes.values())):
                if waiting[0].kind != "unit":
                    test = waiting.pop(0)
                    run_one = self._case if test.kind == "case" else self._script
                    outcomes[test.label] = run_one(test, folder, environment, cpu or limit([test]))
                    continue
                batch = []
                while waiting and waiting[0].kind == "unit" and len(batch) < BATCH:
                    batch.append(waiting.pop(0))
                found = self._units(batch, folder, environment, cpu or limit(batch), until_caught)
                outcomes.update(found)
                # Those that a crash or a time-out has kept from running.
                waiting = [test for test in batch if test.label not in found] + waiting
        return outcomes

    def confirmed(self, outcomes, tests, mutant=None):
        """The same outcomes. Where only one or two tests have caught a mutant those that have failed are asked once more: on a busy machine a test
        may fail that waits for something."""
        caught = [test for test in tests if test.label in outcomes and outcomes[test.label].caught]
        failed = [test for test in caught if outcomes[test.label].how in ("failed", "error")]
        return outcomes | (self.run(failed, mutant) if len(caught) <= 2 and failed else {})

    def _case(self, test, folder, environment, cpu):
        words = [self.program, "run", test.name, "--out", f"{folder}/results", "--threads", "1", "--json"]
        code, said, seconds = run_limited(words, environment, cpu)
        # 5: skipped, for lack of what this program was built without.
        how = {0: "passed", 5: "passed", 1: "failed", None: "time-out"}.get(code, "error" if code > 0 else "crash")
        try:
            checks = json.loads(said)[0]["checks"]
        except (ValueError, IndexError):  # it had nothing to say
            checks = []
        return Outcome(how, [[c["metric"], c["statement"], c["margin"], c["verdict"]] for c in checks], seconds)

    def _script(self, test, folder, environment, cpu):
        code, _, seconds = run_limited([SCRIPTS[test.name], self.program], environment, cpu)
        return Outcome({0: "passed", None: "time-out"}.get(code, "failed"), seconds=seconds)

    def _units(self, batch, folder, environment, cpu, until_caught):
        names = Path(folder) / "names"
        names.write_text("".join(catch_name(test.name) + "\n" for test in batch))
        words = [self.unit, "-f", names, "-r", "xml", "-d", "yes"] + (["-a"] if until_caught else [])
        code, said, seconds = run_limited(words, environment, cpu)
        return read_units(said, batch, code, seconds)

    @staticmethod
    def _say(words):
        return subprocess.run(words, capture_output=True, text=True, check=False).stdout


def limit(tests):
    return SECONDS + TIMES * sum(test.seconds for test in tests)


def catch_name(name):
    """As Catch2's command line wants it."""
    return '"' + name.replace("\\", "\\\\").replace(",", "\\,").replace("[", "\\[") + '"'


def read_units(said, batch, code, seconds):
    """Outcomes out of Catch2's XML, which ends where the program ended."""
    by_name = {test.name: test for test in batch}
    outcomes, last = {}, None
    parser = ET.XMLPullParser(["start", "end"])
    try:
        parser.feed(said)
        for event, element in parser.read_events():
            if element.tag == "TestCase" and event == "start":
                last = by_name.get(element.get("name", "").strip())
            elif element.tag == "TestCase" and last is not None:
                result = element.find("OverallResult")
                if result is not None:
                    ok = result.get("success") == "true"
                    took = seconds if len(batch) == 1 else float(result.get("durationInSeconds", 0.0))
                    outcomes[last.label] = Outcome("passed" if ok else "failed", seconds=took)
                last = None
    except ET.ParseError:
        pass
    died = code is None or code < 0
    if died and (last is None or last.label in outcomes):  # between two tests: the one that was to come
        last = next((test for test in batch if test.label not in outcomes), None)
    if died and last is not None:
        outcomes[last.label] = Outcome("time-out" if code is None else "crash", seconds=seconds)
    if not outcomes:  # nothing was run at all
        outcomes[batch[0].label] = Outcome("crash", seconds=seconds)
    return outcomes


def run_limited(words, environment, cpu):
    """Exit code, None after a time-out, of a program in a process group of its own; what it said; its CPU seconds."""
    def limits():
        resource.setrlimit(resource.RLIMIT_CPU, (int(cpu) + 1, int(cpu) + 3))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        for one in (signal.SIGINT, signal.SIGHUP):  # which are ignored in what a shell starts in the background, or nohup
            signal.signal(one, signal.SIG_DFL)

    with tempfile.TemporaryFile() as said:
        start = time.monotonic()
        child = subprocess.Popen([str(word) for word in words], env=environment, stdin=subprocess.DEVNULL, stdout=said,
                                 stderr=subprocess.DEVNULL, preexec_fn=limits, start_new_session=True)
        ended, status, used = 0, 0, None
        while not ended:
            ended, status, used = os.wait4(child.pid, os.WNOHANG)
            if not ended and time.monotonic() - start > 6.0 * cpu:  # it waits, or the machine is busy
                os.killpg(child.pid, signal.SIGKILL)
                ended, _, used = os.wait4(child.pid, 0)
                status = signal.SIGXCPU
            if not ended:
                time.sleep(0.005)
        child.returncode = 0  # waited for
        code = os.waitstatus_to_exitcode(status)
        said.seek(0)
        text = said.read().decode(errors="replace")
    timed_out = code in (-signal.SIGXCPU, -signal.SIGKILL)
    return (None if timed_out else code), text, used.ru_utime + used.ru_stime


class Scratch:
    """A folder that is gone afterwards, whatever tests have left in it."""

    def __enter__(self):
        self.path = tempfile.mkdtemp(prefix="veriflex-mutant-")
        return self.path

    def __exit__(self, *_):
        subprocess.run(["chmod", "-R", "u+rwX", self.path], check=False, stderr=subprocess.DEVNULL)
        shutil.rmtree(self.path, ignore_errors=True)
