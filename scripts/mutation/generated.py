"""Generated mutants: one small change of the text of lib at a time.

A change of an operator, a sign, a constant, an index or a bound, or a statement that is dropped. Drawn at random from all places where one
could be made, each folder of lib as often as any other. What cannot matter is left out (EXCLUDED), and what compiles to the same object
code is none. Headers are left out too: a change in one compiles half of the program anew; planted bugs stand in them.

A copy of the tree is built once. Of a mutant one object is compiled, and both programs are linked with it in front of the libraries, which
then do not give theirs; several mutants are at work side by side.
"""

import hashlib
import json
import random
import re
import shlex
import shutil
import subprocess
import threading
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

from mutation.equivalent import EQUIVALENT
from mutation.suite import Suite

# Lines that match, and why a change there is no bug.
EXCLUDED = [
    (r"^\s*#", "preprocessor"),
    (r"\bstatic_assert\b|\bassert\(", "assertion: it would not compile, or is not compiled"),
    (r"throw |fmt::format|\bfail\w*\(|InputError|BadParameter|\.warn\(|stop_if_asked|stop::|->show\(|\.show\(", "message, or a signal that asks for a stop"),
    (r"\busing\b|\bnamespace\b|\btemplate\b|\bstruct\b|\bclass\b|\benum\b|\bconcept\b|^\s*friend\b", "declaration"),
    (r"worth_threads|if \((links|count|pushes_\.size\(\)) > 1000|omp_get|num_threads|\bthreads?\b", "from when on a loop has several threads"),
    (r"reserve\(|shrink_to_fit|prefetch|cache|\bpage\b|streams|block_size|at_once", "speed alone: buffers, caches, sizes of blocks"),
    (r"seconds_|watch\.|steady_clock|std::clock|\bto\.(wall|cpu)\b", "time that something took"),
    (r"planted\(", "a planted bug's switch"),
    (r"\bmeaning\b|columns\.push_back\(\{|add_vector\(|Column ", "words of a table"),
]
# Functions of which the same is true as a whole: file, first line, why.
EXCLUDED_FUNCTIONS = [
    ("lib/fluid/blocking.cpp", r"^Blocking blocking_for", "speed alone: how many steps and rows a cache holds"),
    ("lib/solid/modes.cpp", r"^void refuse_beyond_memory", "how much memory the machine has"),
]
EXCLUDED_FILES = {
    "lib/base/memory.cpp": "memory of the machine", "lib/base/progress.cpp": "what the terminal shows", "lib/base/stop.cpp": "signals",
    "lib/base/error.cpp": "messages", "lib/base/mutant.cpp": "planted bugs' switch", "lib/scene/offers.cpp": "words and estimates",
    "lib/solid/inadmissible.cpp": "messages",
}
# Kind, what is found, what takes its place. A group `keep` is what must stand before it.
CHANGES = [
    ("operator", r" \+ ", " - "), ("operator", r" - ", " + "), ("operator", r" \* ", " / "), ("operator", r" / ", " * "),
    ("operator", r" \+= ", " -= "), ("operator", r" -= ", " += "), ("operator", r" \*= ", " /= "), ("operator", r" /= ", " *= "),
    ("operator", r" && ", " || "), ("operator", r" \|\| ", " && "), ("operator", r" == ", " != "), ("operator", r" != ", " == "),
    ("off by one", r" < ", " <= "), ("off by one", r" <= ", " < "), ("off by one", r" > ", " >= "), ("off by one", r" >= ", " > "),
    ("off by one", r"(?<= = )0(?=;)", "1"),
    ("sign", r"(?<=[(,=?:] )-(?=[\w(])|(?<=[(])-(?=[\w(])", ""), ("sign", r"!(?=[\w(])(?!=)", ""),
    ("index", r"\[0\]", "[1]"), ("index", r"\[1\]", "[0]"), ("index", r"\[i\]", "[0]"),
    ("constant", r"(?<![\w.])\d+\.\d+(?:e-?\d+)?(?![\w.])", "constant"), ("constant", r"(?<![\w.\[])[1-9]\d?(?![\w.\]])", "constant"),
]
STATEMENT = re.compile(r"^\s+(?!return\b|break\b|continue\b|throw\b|const\b|auto\b|using\b|static\b|case\b|else\b|delete\b|if\b|for\b|while\b|do\b)"
                       r"[\w.\->\[\]()*:]+(?:\(.*\)| [-+*/]?= .*);$")


EVERYWHERE = ("base/error", "io/file")  # headers that say nothing of what a test is about
QUICK = 0.5  # seconds of a test that may go before those of the usual order


@dataclass
class Mutant:
    file: str
    line: int
    kind: str
    before: str
    after: str
    result: str = ""  # "caught", "survived", "does not compile", "same code", "equivalent"
    by: str = ""  # the test that caught it, or why it is equivalent
    how: str = ""

    @property
    def folder(self):
        return self.file.split("/")[1]

    @property
    def place(self):
        return self.file, self.line, self.kind, self.before, self.after


class Bench:
    """A folder in which mutants are made, one after the other, of the objects that a build of the unchanged tree has left."""

    def __init__(self, tree, build, folder):
        self.tree, self.build, self.folder = tree, build, folder
        folder.mkdir(parents=True, exist_ok=True)
        entries = json.loads((build / "compile_commands.json").read_text())
        self.compilers = {entry["file"]: shlex.split(entry["command"]) for entry in entries}
        self.linkers = {name: linker(build, target) for name, target in (("veriflex", "veriflex"), ("veriflex_unit", "verify/veriflex_unit"))}
        self.suite = Suite(folder / "veriflex", folder / "veriflex_unit", {"VERIFLEX_COMMAND": str(folder / "veriflex")})

    def judge(self, mutant, tests):
        """Its result, with the tests in that order up to the first that catches it."""
        original = self.tree / mutant.file
        lines = original.read_text().splitlines(keepends=True)
        lines[mutant.line - 1] = lines[mutant.line - 1].replace(mutant.before, mutant.after)
        source, made = self.folder / original.name, self.folder / f"{original.name}.o"
        source.write_text("".join(lines))
        words = list(self.compilers[str(original)])
        at = words.index("-o") + 1
        unchanged = self.build / words[at]
        words[at] = str(made)
        words[words.index(str(original))] = str(source)
        if not self._done(words):
            mutant.result = "does not compile"
        elif made.read_bytes() == unchanged.read_bytes():
            mutant.result = "same code"
        elif not all(self._done(put(words, "-o", [str(self.folder / name), str(made)])) for name, words in self.linkers.items()):
            mutant.result = "does not compile"
        else:
            mutant.result, mutant.by, mutant.how = self._met(tests)
        for file in (source, made):
            file.unlink(missing_ok=True)

    def _met(self, tests):
        """What the tests say. One that fails only after others in the same program is passed over: it goes on with those behind it."""
        waiting = list(tests)
        while waiting:
            outcomes = self.suite.confirmed(self.suite.run(waiting, until_caught=True), waiting)
            for label, outcome in outcomes.items():
                if outcome.caught:
                    return "caught", label, outcome.how
            waiting = [test for test in waiting if test.label not in outcomes]
        return "survived", "", ""

    def _done(self, words):
        return subprocess.run(words, cwd=self.build, capture_output=True, check=False).returncode == 0


def linker(build, target):
    """The words that link a program, without what follows once it is linked; by lld where it is installed, which takes a fifth of the time."""
    said = subprocess.run(["ninja", "-C", str(build), "-t", "commands", target], capture_output=True, text=True, check=True).stdout
    words = shlex.split(said.strip().splitlines()[-1])
    words = words[words.index("&&") + 1:]
    return words[:words.index("&&")] + (["-fuse-ld=lld"] if shutil.which("ld.lld") else [])


def put(words, option, values):
    """The words, with other values behind that option."""
    at = words.index(option) + 1
    return words[:at] + values + words[at + 1:]


def main(root, minutes, seed, seconds, near, jobs, out, show):
    start = time.monotonic()
    tree, build = copy_of(root, out / "tree", jobs, show)
    tests = in_order(test for test in Suite.of_build(build).timed(out / "generated-times.json", jobs, show) if test.seconds <= seconds)
    mutants, excluded = sites(root)
    drawn = draw(mutants, random.Random(seed))
    marks = marks_of(tree, 0.0 if near else seconds)
    judged = kept(out / "generated.json", marks)
    judged |= {place: Mutant(*place, "equivalent", why) for place, why in known_equivalent(drawn)}
    nearness = Nearness(root)
    waiting = iter([mutant for mutant in drawn if mutant.place not in judged])
    one_at_a_time = threading.Lock()
    benches = [Bench(tree, build, out / f"bench-{number}") for number in range(jobs)]

    def work(bench):
        while time.monotonic() - start < 60.0 * minutes and (mutant := next(waiting, None)):
            bench.judge(mutant, nearness.order(tests, mutant, judged.values(), near))
            with one_at_a_time:
                judged[mutant.place] = mutant
                done = so_far(drawn, judged)
                show(f"{len(done)}: {mutant.file}:{mutant.line} {mutant.kind}: {mutant.result} {mutant.by} {mutant.how}")
                write(out, seed, done, judged.values(), marks, excluded, len(mutants))

    with ThreadPoolExecutor(jobs) as workers:
        list(workers.map(work, benches))
    done = so_far(drawn, judged)
    write(out, seed, done, judged.values(), marks, excluded, len(mutants))
    print(f"generated mutants: {score(done)}\n  {out}/generated.md, {out}/generated.json")
    return 0


def so_far(drawn, judged):
    """Those that have a result, in the order in which they were drawn."""
    return [judged[mutant.place] for mutant in drawn if mutant.place in judged]


def known_equivalent(drawn):
    """Places of those that change nothing that anybody could see, and why."""
    told = {(file, before, after): why for file, before, after, why in EQUIVALENT}
    return [(m.place, told[m.file, m.before, m.after]) for m in drawn if (m.file, m.before, m.after) in told]


def marks_of(tree, seconds):
    """What results hold for: the sources, the tests and cases, and which of these were run."""
    def mark(paths):
        all_of_it = hashlib.sha256()
        for path in sorted(path for path in paths if path.is_file()):
            all_of_it.update(f"{path.relative_to(tree)} {hashlib.sha256(path.read_bytes()).hexdigest()}\n".encode())
        return all_of_it.hexdigest()

    return {"sources": mark(tree.glob("lib/**/*")),
            "tests": mark([*tree.glob("verify/**/*"), *tree.glob("cases/*"), *tree.glob("reference/**/*")]), "seconds": seconds}


def kept(path, marks):
    """Earlier results by place: all of them for the same sources, and those that no new test would change for the same sources alone."""
    if not path.exists():
        return {}
    stored = json.loads(path.read_text())
    if stored.get("marks", {}).get("sources") != marks["sources"]:
        return {}
    results = [Mutant(**one) for one in stored["judged"]]
    same_tests = stored["marks"]["tests"] == marks["tests"] and stored["marks"]["seconds"] >= marks["seconds"]
    return {m.place: m for m in results if m.result != "equivalent" and (same_tests or m.result != "survived")}


def copy_of(root, tree, jobs, show):
    """A copy of what git knows of, built. What has not changed since the last time keeps its age, so that it is not compiled again."""
    files = subprocess.run(["git", "ls-files", "-z"], cwd=root, capture_output=True, text=True, check=True).stdout.split("\0")
    for name in filter(None, files):
        source, target = root / name, tree / name
        if not source.is_file() or target.is_file() and target.read_bytes() == source.read_bytes():
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, target)
    if not (tree / ".git").exists():  # a revision of its own, so that it does not change with the original's
        for words in (["init", "-q"], ["-c", "user.name=mutants", "-c", "user.email=mutants", "commit", "-q", "--allow-empty", "-m", "copy"]):
            subprocess.run(["git", *words], cwd=tree, check=True)
    show("compiling the copy of the tree")
    build = tree / "build/release"
    for words in (["cmake", "--preset", "release"], ["cmake", "--build", str(build), "-j", str(jobs), "--target", "veriflex", "veriflex_unit"]):
        done = subprocess.run(words, cwd=tree, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise SystemExit(f"mutants: the copy of the tree in {tree} does not compile:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return tree, build


def in_order(tests):
    """The fastest first: all unit tests of a hundredth of a second cost less than one case of a second."""
    return sorted(tests, key=lambda test: (round(test.seconds, 1), test.kind == "case", test.seconds))


class Nearness:
    """Which tests have to do with a file of lib: those whose own file includes its header, by itself or through another file of tests, or names
    something of its folder. And those that have caught a mutant there."""

    def __init__(self, root):
        unit = root / "verify/unit"
        texts = {path.name: path.read_text() for path in unit.glob("*.[ch]pp")}
        self.includes = {}  # of a test
        for text in texts.values():
            here = {*re.findall(r'#include "(\w+/\w+)\.hpp"', text), *(f"{space}/" for space in re.findall(r"\b(\w+)::", text))}
            all_of_it = here.union(*(re.findall(r'#include "(\w+/\w+)\.hpp"', texts[name]) for name in texts if f'#include "unit/{name}"' in text))
            for name in re.findall(r'TEST_CASE\(\s*((?:"(?:[^"\\]|\\.)*"\s*)+)', text):
                self.includes["unit " + "".join(re.findall(r'"((?:[^"\\]|\\.)*)"', name))] = all_of_it

    def order(self, tests, mutant, judged, alone):
        """The tests, those first that have caught a mutant in that file or folder, then by their headers. `alone`: no others."""
        caught = [other for other in list(judged) if other.result == "caught" and other.folder == mutant.folder]
        in_file, in_folder = (Counter(other.by for other in some) for some in ([c for c in caught if c.file == mutant.file], caught))
        header = mutant.file.removeprefix("lib/").removesuffix(".cpp")

        def rank(test):
            includes = self.includes.get(test.label, ())
            by_header = 2 if header in includes else any(i.startswith(mutant.folder + "/") for i in includes if i not in EVERYWHERE)
            return (-in_file[test.label], -in_folder[test.label], -by_header) if test.seconds <= QUICK else (0, 0, 0)

        ordered = sorted(tests, key=rank)
        return [test for test in ordered if rank(test) < (0, 0, 0)] if alone else ordered


def sites(root):
    """Every mutant that could be made, and how many lines are excluded for which reason."""
    found, excluded = [], {}
    for path in sorted(root.glob("lib/*/*.cpp")):
        name = str(path.relative_to(root))
        lines = path.read_text().splitlines()
        if name in EXCLUDED_FILES:
            excluded[f"{name}: {EXCLUDED_FILES[name]}"] = len(lines)
            continue
        within, reason = False, None  # of a statement that is excluded, and ends further down
        function = None
        for number, line in enumerate(lines, 1):
            code = bare(line)
            function = next((why for file, first, why in EXCLUDED_FUNCTIONS if file == name and re.search(first, line)), function)
            if function:
                excluded[function] = excluded.get(function, 0) + 1
                if line == "}":
                    function = None
                continue
            if not within:
                reason = next((why for pattern, why in EXCLUDED if re.search(pattern, code)), None)
            if reason:
                excluded[reason] = excluded.get(reason, 0) + 1
                within = bool(code.strip()) and not re.search(r"[;{}:]\s*$", code)
                continue
            within = False
            found += of_line(name, number, line, code)
    return found, excluded


def bare(line):
    """A line in which comments and texts are blanks."""
    line = re.sub(r'"(?:[^"\\]|\\.)*"', lambda m: '"' + " " * (len(m.group()) - 2) + '"', line)
    return re.sub(r"//.*", lambda m: " " * len(m.group()), line).rstrip()


def of_line(name, number, line, code):
    all_of_it = []
    for kind, pattern, by in CHANGES:
        for match in re.finditer(pattern, code):
            put = other(match.group()) if by == "constant" else by
            after = line[:match.start()] + put + line[match.end():]
            all_of_it.append(Mutant(name, number, kind, line.strip(), after.strip()))
    if STATEMENT.match(code):
        all_of_it.append(Mutant(name, number, "dropped statement", line.strip(), ";"))
    return all_of_it


def other(number):
    """Another constant: a whole number one more, any other 1 % more."""
    return str(int(number) + 1) if number.isdigit() else repr(float(number) * 1.01 if float(number) != 0.0 else 0.01)


def draw(mutants, chance):
    """All of them at random, a folder as often as any other."""
    folders = {}
    for mutant in mutants:
        folders.setdefault(mutant.file.split("/")[1], []).append(mutant)
    for some in folders.values():
        chance.shuffle(some)
    drawn = []
    while any(folders.values()):
        drawn += [folders[folder].pop() for folder in sorted(folders) if folders[folder]]
    return drawn


def score(done):
    count = Counter(mutant.result for mutant in done)
    judged = count["caught"] + count["survived"]
    return (f"{count['caught']} of {judged} caught ({100.0 * count['caught'] / max(1, judged):.1f} %); beside these {count['equivalent']} change "
            f"nothing that could be seen, {count['does not compile']} do not compile, {count['same code']} are the same code")


def write(out, seed, done, judged, marks, excluded, places):
    told = {"seed": seed, "places": places, "marks": marks, "excluded_lines": excluded, "judged": [asdict(m) for m in judged]}
    aside = out / "generated.json.part"
    aside.write_text(json.dumps(told, indent=1))
    aside.replace(out / "generated.json")
    folders = {folder: Counter(m.result for m in done if m.folder == folder) for folder in sorted({m.folder for m in done})}
    lines = ["# Generated mutants", "", f"Seed {seed}: {len(done)} of {places} places; {score(done)}. Tests and cases that take up to {marks['seconds']:g} s.", "",
             "| folder | caught | survived | equivalent | does not compile | same code |", "|---|---|---|---|---|---|"]
    lines += [f"| {folder} | " + " | ".join(str(count[what]) for what in ("caught", "survived", "equivalent", "does not compile", "same code")) + " |"
              for folder, count in folders.items()]
    lines += ["", "| place | kind | before | after | result |", "|---|---|---|---|---|"]
    for m in sorted(done, key=lambda m: m.result != "survived"):
        before, after, by = (text.replace("|", "\\|") for text in (m.before, m.after, m.by))
        how = f" ({m.how})" if m.how else ""
        lines.append(f"| {m.file}:{m.line} | {m.kind} | `{before}` | `{after}` | {m.result}{f': {by}{how}' if by else ''} |")
    lines += ["", "Left out:", ""] + [f"- {count} lines: {why}" for why, count in sorted(excluded.items())]
    (out / "generated.md").write_text("\n".join(lines) + "\n")
