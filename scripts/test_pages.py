#!/usr/bin/python3
"""Pages for users are followed literally: files as they stand there, commands as they are typed.

Usage: scripts/test_pages.py VERIFLEX
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
FENCED = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.M | re.S)


def blocks(page):
    """Of each fenced block its kind, its text, and the file that the paragraph before it names last."""
    at, found = 0, []
    for block in FENCED.finditer(page):
        names = re.findall(r"`([\w-]+\.(?:csv|toml))`", page[at : block.start()])
        found.append((block.group(1), block.group(2), names[0] if names else None))
        at = block.end()
    return found


@unittest.skipUnless(COMMAND, "no command was given")
class Pages(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.path = Path(scratch.name)
        for shared in ("cases", "docs", "reference", "scripts"):
            (self.path / shared).symlink_to(ROOT / shared)
        for folder in ("bin", "build/release"):
            (self.path / folder).mkdir(parents=True)
            (self.path / folder / "veriflex").symlink_to(COMMAND)

    def follow(self, page):
        """Writes its files and types its commands; those of another program (```sh lmp) where that is installed. Kinds of its blocks."""
        environment = os.environ | {
            "PATH": f"{self.path / 'bin'}:{os.environ['PATH']}",
            "XDG_CACHE_HOME": str(self.path / "cache"),
        }
        for kind, text, name in blocks(page):
            if kind in ("csv", "toml"):
                (self.path / name).write_text(text, "utf-8")
            elif kind == "sh" or shutil.which(kind.removeprefix("sh ")):
                ran = subprocess.run(["sh", "-eu", "-c", text], cwd=self.path, env=environment, capture_output=True, text=True)
                self.assertEqual(ran.returncode, 0, text + ran.stdout + ran.stderr)
        return [kind for kind, _, _ in blocks(page)]

    def report(self):
        return (self.path / "results" / "report.html").read_text("utf-8")

    def test_first_case(self):
        page = (ROOT / "README.md").read_text("utf-8")
        section = re.search(r"^## A first case of your own.*?(?=^## )", page, re.M | re.S).group(0)
        self.assertEqual(self.follow(section), ["toml", "sh"])
        self.assertIn("My bar", self.report())

    def test_own_scene(self):
        kinds = self.follow((ROOT / "docs" / "OWN_SCENE.md").read_text("utf-8"))
        self.assertEqual(kinds, ["toml"] + 5 * ["sh"])
        self.assertIn("A flexible rod on the floor of a channel", self.report())
        self.assertTrue((self.path / "results" / "reed.snapshots" / "flow.pvd").exists())
        self.assertIn("rod_support_x", (self.path / "forces.csv").read_text("utf-8"))

    def test_own_solver(self):
        kinds = self.follow((ROOT / "docs" / "OWN_SOLVER.md").read_text("utf-8"))
        self.assertEqual(kinds, ["csv", "toml", "sh", "sh", "sh", "sh lmp", "sh lmp"])
        self.assertIn('<section id="codes">', self.report())
        self.assertIn("my solver 1.3", self.report())


if __name__ == "__main__":
    unittest.main()
