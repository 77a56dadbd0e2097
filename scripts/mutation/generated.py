"""Generated mutants: one small change of the text of lib at a time, compiled in a copy of the tree.

The copy is built like the planted bugs, with none of them chosen. A change of an operator, a sign, a constant, an index or a bound, or a statement that is dropped. Drawn at random from all places where one
could be made, each folder of lib as often as any other. What cannot matter is left out (EXCLUDED), and what compiles to the same object
code is none. Headers are left out too: a change in one compiles half of the program anew; planted bugs stand in them.
"""

import json
import random
import re
import shutil
import subprocess
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from mutation.suite import Suite

# Lines that match, and why a change there is no bug.
EXCLUDED = [
    (r"^\s*#", "preprocessor"),
    (r"\bstatic_assert\b|\bassert\(", "assertion: it would not compile, or is not compiled"),
    (r"throw |fmt::format|\bfail\w*\(|InputError|BadParameter|\.warn\(|stop_if_asked|stop::|->show\(|\.show\(", "message, or a signal that asks for a stop"),
    (r"\busing\b|\bnamespace\b|\btemplate\b|\bstruct\b|\bclass\b|\benum\b|\bconcept\b|^\s*friend\b", "declaration"),
    (r"worth_threads|if \((links|count|pushes_\.size\(\)) > 1000|omp_get|num_threads|\bthreads?\b", "from when on a loop has several threads"),
    (r"reserve\(|shrink_to_fit|prefetch|cache|\bpage\b|streams|block_size|at_once", "speed alone: buffers, caches, sizes of blocks"),
    (r"seconds_|watch\.|steady_clock|std::clock", "time that something took"),
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


@dataclass
class Mutant:
    file: str
    line: int
    kind: str
    before: str
    after: str
    result: str = ""  # "caught", "survived", "does not compile", "same code"
    by: str = ""


def main(root, minutes, seed, jobs, out, show):
    start = time.monotonic()
    tree, build = copy_of(root, out / "tree", jobs, show)
    suite = Suite(build)
    tests = in_order(suite.timed(out / "generated-times.json", jobs, show))
    mutants, excluded = sites(root)
    drawn = draw(mutants, random.Random(seed))
    done = []
    for mutant in drawn:
        if time.monotonic() - start > 60.0 * minutes:
            break
        judge(mutant, tree, build, suite, tests, jobs)
        done.append(mutant)
        show(f"{len(done)}: {mutant.file}:{mutant.line} {mutant.kind}: {mutant.result} {mutant.by}")
        write(out, seed, done, excluded, mutants)
    caught, survived = (sum(m.result == what for m in done) for what in ("caught", "survived"))
    print(f"generated mutants: {caught} of {caught + survived} caught, {len(done) - caught - survived} do not compile or are the same code\n"
          f"  {out}/generated.md, {out}/generated.json")
    return 0


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
    build = tree / "build/mutants"
    for words in (["cmake", "--preset", "mutants"], compile_words(build, jobs)):
        done = subprocess.run(words, cwd=tree, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise SystemExit(f"mutants: the copy of the tree in {tree} does not compile:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return tree, build


def compile_words(build, jobs):
    return ["cmake", "--build", str(build), "-j", str(jobs), "--target", "veriflex", "veriflex_unit"]


def in_order(tests):
    """The fastest first: all unit tests of a hundredth of a second cost less than one case of a second."""
    return sorted(tests, key=lambda test: (round(test.seconds, 1), test.kind == "case", test.seconds))


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


def judge(mutant, tree, build, suite, tests, jobs):
    path = tree / mutant.file
    whole = path.read_text()
    lines = whole.splitlines(keepends=True)
    lines[mutant.line - 1] = lines[mutant.line - 1].replace(mutant.before, mutant.after)
    folder, file = mutant.file.split("/")[1:]
    compiled = build / f"lib/CMakeFiles/veriflex_{folder}.dir/{folder}/{file}.o"
    code = compiled.read_bytes()
    try:
        path.write_text("".join(lines))
        if subprocess.run(compile_words(build, jobs), cwd=tree, capture_output=True, check=False).returncode != 0:
            mutant.result = "does not compile"
        elif compiled.read_bytes() == code:
            mutant.result = "same code"
        else:
            outcomes = suite.confirmed(suite.run(tests, until_caught=True), tests)
            by = [f"{label} ({outcome.how})" for label, outcome in outcomes.items() if outcome.caught]
            mutant.result, mutant.by = ("caught", by[0]) if by else ("survived", "")
    finally:
        path.write_text(whole)
        subprocess.run(compile_words(build, jobs), cwd=tree, capture_output=True, check=False)


def write(out, seed, done, excluded, all_mutants):
    (out / "generated.json").write_text(json.dumps(
        {"seed": seed, "places": len(all_mutants), "excluded_lines": excluded, "mutants": [asdict(m) for m in done]}, indent=1))
    caught, survived = (sum(m.result == what for m in done) for what in ("caught", "survived"))
    lines = ["# Generated mutants", "", f"Seed {seed}: {len(done)} of {len(all_mutants)} places. {caught} caught, {survived} survived, "
             f"{sum(m.result == 'does not compile' for m in done)} do not compile, {sum(m.result == 'same code' for m in done)} compile to the same code.", "",
             "| place | kind | before | after | result |", "|---|---|---|---|---|"]
    for m in done:
        before, after = (text.replace("|", "\\|") for text in (m.before, m.after))
        lines.append(f"| {m.file}:{m.line} | {m.kind} | `{before}` | `{after}` | {m.result}{': ' + m.by if m.by else ''} |")
    lines += ["", "Left out:", ""] + [f"- {count} lines: {why}" for why, count in sorted(excluded.items())]
    (out / "generated.md").write_text("\n".join(lines) + "\n")
