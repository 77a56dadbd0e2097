#!/usr/bin/python3
"""Tests of how another program's numbers come in: the scripts of docs/own-solver/ read small outputs, and the shipped tables are those of
reference/own-solver/README.md. What docs/OWN_SOLVER.md says is tested by test_pages.py.
"""

import hashlib
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SCRIPTS = ROOT / "docs" / "own-solver"
TABLES = ROOT / "reference" / "own-solver"

LOG = """Step v_strain Pzz
       0 0.10000000000000001 -2.5
Loop time of 1e-06 on 1 procs
Step v_strain Pzz
WARNING: FENE bond too long
       0 0.20000000000000001 -3.5
Loop time of 1e-06 on 1 procs
"""
DUMP = """ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
2
ITEM: BOX BOUNDS ff ff ff
-5 30
ITEM: ATOMS id v_load x y
1 0.5 0 0
2 0.5 1 0
ITEM: TIMESTEP
10
ITEM: NUMBER OF ATOMS
2
ITEM: BOX BOUNDS ff ff ff
-5 30
ITEM: ATOMS id v_load x y
1 0.5 0 0
2 0.5 1 0.25
"""
VTK = """# vtk DataFile Version 3.0
fluid_state
ASCII
DATASET RECTILINEAR_GRID
DIMENSIONS 2 2 1
X_COORDINATES 2 float
0.5 1.5
Y_COORDINATES 2 float
0.5 1.5
Z_COORDINATES 1 float
0
POINT_DATA 4
SCALARS density_difference float 1
LOOKUP_TABLE default
0
0
-0.5
0
VECTORS velocity_vector float
0.1 0 0
0.2 0 0
0.3 0 0
0.4 0 0
"""


class Scripts(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.path = Path(scratch.name)

    def read_by(self, script, *words):
        ran = subprocess.run([sys.executable, SCRIPTS / script, *words], cwd=self.path, capture_output=True, text=True)
        return ran.stdout if ran.returncode == 0 else ran.stderr

    def test_a_log_becomes_a_table_without_its_warnings(self):
        (self.path / "log").write_text(LOG)
        self.assertEqual(self.read_by("lammps.py", "log", "strain=strain", "stress=-Pzz"), "strain,stress\n0.1,2.5\n0.2,3.5\n")

    def test_rows_of_a_dump_are_chosen_by_atom_and_step(self):
        (self.path / "dump").write_text(DUMP)
        table = self.read_by("lammps.py", "dump", "load=load", "tip=y/2", "--where", "(id == 2) & (step > 0)")
        self.assertEqual(table, "load,tip\n0.5,0.125\n")

    def test_what_holds_no_table_is_refused(self):
        (self.path / "log").write_text("LAMMPS (29 Sep 2021)\n")
        self.assertIn("no rows in log", self.read_by("lammps.py", "log", "stress=Pzz"))

    def test_a_field_becomes_its_mean_over_x_at_the_last_step(self):
        (self.path / "vtk_fluid").mkdir()
        (self.path / "vtk_fluid" / "fluid_t900.vtk").write_text(VTK.replace("0.4", "9"))
        (self.path / "vtk_fluid" / "fluid_t1000.vtk").write_text(VTK)
        height, velocity = zip(*(map(float, row.split(",")) for row in self.read_by("iblbm.py", ".", "profile").split()[1:]))
        self.assertEqual(height, (0.5, 1.5))
        self.assertAlmostEqual(velocity[0], 0.15)
        self.assertAlmostEqual(velocity[1], 0.35)
        (self.path / "data.dat").write_text("900 0 0\n1000 -0.4 0\n")
        # slopes 0.3 + 0.1 and 0.7 + 0.1 with g/(4 nu) = 0.1; friction 0.5 x 2 x 1.2, drag 0.4, force 0.2 x 4
        self.assertAlmostEqual(float(self.read_by("iblbm.py", ".", "balance", "0.5", "0.2").split()[1]), (1.2 + 0.4) / 0.8)

    def test_a_script_is_short(self):
        for script in SCRIPTS.glob("*.py"):
            self.assertLessEqual(len(script.read_text("utf-8").splitlines()), 50, script.name)


class Tables(unittest.TestCase):
    def test_shipped_tables_are_those_of_the_page(self):
        page = (TABLES / "README.md").read_text("utf-8")
        stated = dict(re.findall(r"^\| `(\S+\.csv)` .*`([0-9a-f]{64})` \|$", page, re.M))
        self.assertEqual(stated, {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in TABLES.glob("*.csv")})


if __name__ == "__main__":
    unittest.main()
