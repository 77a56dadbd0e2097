#!/usr/bin/python3
"""Pages for users are followed literally: files as they stand there, commands as they are typed.

Usage: scripts/test_pages.py [OwnBondLaw] VERIFLEX
OwnBondLaw builds the whole program once more with the law of docs/OWN_BOND_LAW.md, in minutes; without it only what is compiled of laws alone.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
COMMAND = Path(sys.argv.pop()).resolve() if len(sys.argv) > 1 and not sys.argv[-1].startswith("-") else None
BUILD = COMMAND.parent if COMMAND else None
FENCED = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.M | re.S)


def blocks(page):
    """Of each fenced block its kind, its text, and the file that the paragraph before it names last."""
    at, found = 0, []
    for block in FENCED.finditer(page):
        names = re.findall(r"`([\w-]+\.(?:csv|toml)|lib/[\w/-]+\.hpp)`", page[at : block.start()])
        found.append((block.group(1), block.group(2), names[0] if names else None))
        at = block.end()
    return found


class Followed(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.path = Path(scratch.name)

    def follow(self, page, builds=False):
        """Writes its files, applies its changes and types its commands; those of another program (```sh lmp) where that is installed, those
        that need a build (```sh build) if it `builds`. Kinds of its blocks."""
        environment = os.environ | {
            "PATH": f"{self.path / 'bin'}:{os.environ['PATH']}",
            "XDG_CACHE_HOME": str(self.path / "cache"),
        }
        for kind, text, name in blocks(page):
            if kind in ("csv", "toml", "cpp"):
                (self.path / name).write_text(text, "utf-8")
            elif kind == "diff":
                self.type_in("patch -p1 --fuzz=0", text, input=text)
            elif {"sh": True, "sh build": builds}.get(kind, shutil.which(kind.removeprefix("sh "))):
                self.type_in(text, text, env=environment)
        return [kind for kind, _, _ in blocks(page)]

    def follow_page(self, name, builds=False):
        return self.follow((ROOT / "docs" / f"{name}.md").read_text("utf-8"), builds)

    def type_in(self, command, what, **options):
        ran = subprocess.run(["sh", "-eu", "-c", command], cwd=self.path, capture_output=True, text=True, **options)
        self.assertEqual(ran.returncode, 0, what + ran.stdout + ran.stderr)
        return ran.stdout

    def report(self):
        return (self.path / "results" / "report.html").read_text("utf-8")


class Links(unittest.TestCase):
    def test_each_leads_to_a_file(self):
        for page in (ROOT / "README.md", ROOT / "ARCHITECTURE.md", *(ROOT / "docs").rglob("*.md")):
            for target in re.findall(r"\]\(([^)#\s]+)\)", page.read_text("utf-8")):
                self.assertTrue((page.parent / target).exists(), f"{page.name}: {target}")


@unittest.skipUnless(COMMAND, "no command was given")
class Pages(Followed):
    def setUp(self):
        super().setUp()
        for shared in ("cases", "docs", "reference", "scripts"):
            (self.path / shared).symlink_to(ROOT / shared)
        for folder in ("bin", "build/release"):
            (self.path / folder).mkdir(parents=True)
            (self.path / folder / "veriflex").symlink_to(COMMAND)

    def test_first_case(self):
        self.assertEqual(self.follow_page("FIRST_CASE"), ["toml", "sh", "sh"])
        self.assertIn("My bar", self.report())
        self.assertIn("strain,stress", (self.path / "curve.csv").read_text("utf-8"))

    def test_studies(self):
        self.follow_page("FIRST_CASE")
        self.assertEqual(self.follow_page("STUDIES"), ["sh", "sh", "slurm", "sh"])
        kept = [len(list((self.path / f"part-{n}").glob("*rows/*.h5"))) for n in (1, 2, 3, 4)]
        self.assertEqual(kept, [1, 1, 1, 1])

    def test_own_scene(self):
        kinds = self.follow_page("OWN_SCENE")
        self.assertEqual(kinds, ["toml"] + 5 * ["sh"])
        self.assertIn("A flexible rod on the floor of a channel", self.report())
        self.assertTrue((self.path / "results" / "reed.snapshots" / "flow.pvd").exists())
        self.assertIn("rod_support_x", (self.path / "forces.csv").read_text("utf-8"))

    def test_own_solver(self):
        kinds = self.follow_page("OWN_SOLVER")
        self.assertEqual(kinds, ["csv", "toml", "sh", "sh", "sh", "sh lmp", "sh lmp"])
        self.assertIn('<section id="codes">', self.report())
        self.assertIn("my solver 1.3", self.report())

    def test_own_bond_law(self):
        """Laws alone: with the page's own list of them, on the libraries below it and the main function of the unit tests as they are built."""
        for shared in ("cases", "lib/bond", "verify/unit"):
            (self.path / shared).unlink(missing_ok=True)
            shutil.copytree(ROOT / shared, self.path / shared)
        kinds = self.follow_page("OWN_BOND_LAW")
        self.assertEqual(kinds, ["cpp", "diff"] + 3 * ["sh build"] + 3 * ["toml"] + ["sh build"])
        (self.path / "lib" / "CMakeLists.txt").write_text(LAWS_ALONE, "utf-8")
        cache = dict(re.findall(r"^(\w+):\w+=(.*)$", (BUILD / "CMakeCache.txt").read_text("utf-8"), re.M))
        flags = cache["CMAKE_CXX_FLAGS"]
        (main,) = BUILD.glob("verify/CMakeFiles/veriflex_unit_main.dir/**/main.cpp.o")
        options = f"-DCMAKE_CXX_COMPILER={cache['CMAKE_CXX_COMPILER']} -DCMAKE_CXX_FLAGS='{flags}' -DBUILD={BUILD} -DROOT={ROOT} -DMAIN={main}"
        self.type_in(f"cmake -G Ninja -S lib -B laws {options} && cmake --build laws", "")
        said = self.type_in("laws/laws --success", "")
        self.assertIn("All tests passed", said)
        self.assertIn("morse at r = ", said)


LAWS_ALONE = """cmake_minimum_required(VERSION 3.25)
project(laws LANGUAGES CXX)
include(GNUInstallDirs)
find_package(GSL REQUIRED)
find_package(fmt REQUIRED)
add_library(veriflex_bond bond/laws.cpp bond/derive.cpp)
include(bond/laws.cmake)
target_compile_features(veriflex_bond PUBLIC cxx_std_20)
target_include_directories(veriflex_bond SYSTEM PUBLIC /usr/include/eigen3)
target_include_directories(veriflex_bond PUBLIC . ${BUILD}/include/base)
target_link_libraries(veriflex_bond PUBLIC ${BUILD}/lib/libveriflex_base.a GSL::gsl fmt::fmt)
add_executable(laws ../verify/unit/bond_test.cpp ${MAIN})
target_link_libraries(laws veriflex_bond)
"""


@unittest.skipUnless("OwnBondLaw" in sys.argv, "takes minutes: scripts/test_pages.py OwnBondLaw VERIFLEX")
class OwnBondLaw(Followed):
    def test_with_the_whole_build(self):
        files = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\n")
        for file in filter(None, files):
            (self.path / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / file, self.path / file)
        self.type_in("cmake --preset release", "")
        (self.path / "bin").mkdir()
        (self.path / "bin" / "veriflex").symlink_to(self.path / "build" / "release" / "veriflex")
        self.follow_page("OWN_BOND_LAW", builds=True)
        self.assertIn("Stiffest body that a step carries, by bond law", self.report())


if __name__ == "__main__":
    unittest.main()
