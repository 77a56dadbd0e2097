#!/usr/bin/python3
"""Tests of the reader of results: what docs/READING.md shows is executed, on results of the command given; snapshots are read back.

Usage: scripts/test_reading.py VERIFLEX
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree
from pathlib import Path

import h5py
import numpy as np

try:
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOHDF import vtkHDFReader
    from vtkmodules.vtkIOXML import vtkXMLImageDataReader, vtkXMLUnstructuredGridReader
except ImportError:
    vtkHDFReader = None

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import veriflex

COMMAND = Path(sys.argv.pop()).resolve() if len(sys.argv) > 1 and not sys.argv[-1].startswith("-") else None
SCENE = """
schema = 2
id = "mine"
title = "Two chains in a fluid"
question = "?"
equation = "-"
sources = []
tier = "quick"
topics = []
driver = "scene"

[fluid]
nodes = [16, 12, 10]
tau = 0.8

[[body]]
name = "chain"
shape.chain = { nodes = 5 }
place = [8.0, 6.0, 3.0]
bond = { law = "harmonic", k = 0.02, r0 = 1.0 }
node_mass = 2.0
start = { strain = 0.01 }
coupling = {}

[[body]]
name = "moved"
shape.chain = { nodes = 2 }
place = [3.0, 6.0, 5.0]
motion = { velocity = [0.001, 0.0, 0.0] }
coupling = {}

[run]
steps = 20

[[observe]]
what = "body snapshot"
name = "bodies"
every = 10

[[observe]]
what = "body snapshot"
name = "chain"
body = "chain"

[[observe]]
what = "fluid snapshot"
name = "all"
fields = ["density", "velocity", "stress"]

[[observe]]
what = "fluid snapshot"
name = "slice"
from = [0, 6, 0]
to = [15, 6, 9]
fields = ["density", "velocity", "stress"]
every = 5

[[observe]]
what = "body snapshot"
name = "bodies_hdf"
every = 10
format = "vtkhdf"

[[observe]]
what = "fluid snapshot"
name = "all_hdf"
fields = ["density", "velocity", "stress"]
format = "vtkhdf"

[[observe]]
what = "fluid snapshot"
name = "slice_hdf"
from = [0, 6, 0]
to = [15, 6, 9]
fields = ["density", "velocity", "stress"]
every = 5
format = "vtkhdf"

[[observe]]
what = "fluid snapshot"
name = "line_hdf"
from = [3, 6, 4]
to = [3, 11, 4]
format = "vtkhdf"

[[observe]]
what = "fluid snapshot"
name = "node_hdf"
from = [3, 6, 4]
to = [3, 6, 4]
format = "vtkhdf"

[[observe]]
what = "body snapshot"
name = "atoms"
body = "chain"
every = 10
format = "lammps-data"

[[observe]]
what = "fluid snapshot"
name = "corner"
from = [2, 5, 1]
to = [9, 7, 6]

[[observe]]
what = "plane"
axis = "y"
at = 6
fields = ["density", "velocity", "stress"]
every = 5

[[observe]]
what = "nodes"
body = "chain"
every = 10

[[observe]]
what = "forces"
every = 10

[[observe]]
what = "strain"
every = 20
"""


def appended(path):
    """Arrays of a file of VTK's XML formats by name, and its XML; without VTK."""
    data = Path(path).read_bytes()
    start = data.index(b'<AppendedData encoding="raw">')
    raw = data[data.index(b"_", start) + 1 :]
    tree = xml.etree.ElementTree.fromstring(data[:start] + b"</VTKFile>")
    kinds = {"Float64": "<f8", "Int64": "<i8", "UInt8": "u1"}
    arrays = {}
    for node in tree.iter("DataArray"):
        if node.get("format") != "appended":
            continue
        at = int(node.get("offset"))
        size = int(np.frombuffer(raw, "<u8", 1, at)[0])
        kind = np.dtype(kinds[node.get("type")])
        values = np.frombuffer(raw, kind, size // kind.itemsize, at + 8)
        width = int(node.get("NumberOfComponents"))
        arrays[node.get("Name")] = values.reshape(-1, width) if width > 1 else values
    return arrays, tree


@unittest.skipUnless(COMMAND, "no command was given")
class OfTheCommand(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = Path(cls.folder.name)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def run_cases(self, *words):
        ran = subprocess.run([COMMAND, "run", *words], cwd=self.path, capture_output=True, text=True)
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)

    def test_the_page_is_true(self):
        page = (HERE.parent / "docs" / "READING.md").read_text("utf-8")
        line = re.search(r"veriflex run (.*)", page).group(1)
        self.run_cases(*line.split())
        blocks = re.findall(r"```python\n(.*?)```", page, re.S)
        self.assertGreater(len(blocks), 3)
        names, before = {}, Path.cwd()
        os.chdir(self.path)
        try:
            with open(os.devnull, "w") as silent:
                out, sys.stdout = sys.stdout, silent
                try:
                    for block in blocks:
                        exec(compile(block, "docs/READING.md", "exec"), names)
                finally:
                    sys.stdout = out
        finally:
            os.chdir(before)
        self.assertEqual(names["E"], names["results"]["tensile-fene-lj"].metric("young_modulus"))
        self.assertEqual(names["failed"], [])

    def test_snapshots_hold_what_the_records_hold(self):
        (self.path / "mine.toml").write_text(SCENE, "utf-8")
        self.run_cases("mine.toml", "--out", "results")
        result = veriflex.load(self.path / "results" / "mine.h5")
        folder = self.path / "results" / "mine.snapshots"
        self.assertEqual(list(result.record("bodies")["step"]), [0, 10, 20])

        plane = result.record("plane")
        now = plane["step"] == 20
        slice_, tree = appended(folder / "slice-000000020.vti")
        self.assertEqual(tree.find("ImageData").get("Origin"), "0 6 0")
        self.assertEqual(tree.find("ImageData").get("WholeExtent"), "0 15 0 0 0 9")
        self.assertTrue(np.array_equal(slice_["density"], plane["density"][now]))
        for axis, name in enumerate("xyz"):
            self.assertTrue(np.array_equal(slice_["velocity"][:, axis], plane[f"velocity_{name}"][now]))
        for column, name in enumerate(["xx", "yy", "zz", "xy", "yz", "xz"]):
            self.assertTrue(np.array_equal(slice_["stress"][:, column], plane[f"stress_{name}"][now]))
        whole, _ = appended(folder / "all-000000020.vti")
        self.assertEqual(whole["density"].shape, (16 * 12 * 10,))
        self.assertEqual(whole["stress"].shape, (16 * 12 * 10, 6))
        density = whole["density"].reshape(10, 12, 16)
        self.assertTrue(np.array_equal(density[:, 6, :].ravel(), slice_["density"]))
        corner, tree = appended(folder / "corner-000000020.vti")
        self.assertEqual(tree.find("ImageData").get("Origin"), "2 5 1")
        self.assertEqual(tree.find("ImageData").get("WholeExtent"), "0 7 0 2 0 5")
        self.assertTrue(np.array_equal(density[1:7, 5:8, 2:10].ravel(), corner["density"]))

        nodes = result.record("nodes")
        now = nodes["step"] == 20
        chain, _ = appended(folder / "bodies-chain-000000020.vtu")
        for axis, name in enumerate("xyz"):
            self.assertTrue(np.array_equal(chain["Points"][:, axis], nodes[name][now]))
        self.assertEqual(list(chain["connectivity"]), [0, 1, 1, 2, 2, 3, 3, 4])
        lengths = np.linalg.norm(np.diff(chain["Points"], axis=0), axis=1)
        self.assertTrue(np.allclose(chain["strain"], lengths - 1.0, atol=1e-14))
        self.assertTrue(np.allclose(chain["tension"], 0.02 * (lengths - 1.0), atol=1e-15))
        forces = result.record("forces")
        self.assertAlmostEqual(chain["fluid_force"][:, 2].sum(), forces["chain_fluid_z"][-1], delta=1e-17)
        moved, _ = appended(folder / "bodies-moved-000000020.vtu")
        self.assertTrue(np.allclose(moved["velocity"], [0.001, 0.0, 0.0]))
        self.assertNotIn("strain", moved)
        start, _ = appended(folder / "bodies-chain-000000000.vtu")
        self.assertTrue(np.allclose(start["strain"], 0.01, atol=1e-14))

        series = xml.etree.ElementTree.parse(folder / "bodies.pvd").getroot()
        members = [(float(m.get("timestep")), m.get("file")) for m in series.iter("DataSet")]
        self.assertEqual([time for time, _ in members], [0, 0, 10, 10, 20, 20])
        self.assertTrue(all((folder / name).is_file() for _, name in members))

        self.read_by_vtk(folder, chain, slice_)
        self.compare_hdf(folder, chain, whole, slice_)
        self.compare_atoms(folder, chain)

    def compare_hdf(self, folder, chain, whole, slice_):
        """VTK's HDF5 files hold the arrays of the XML ones bit by bit, to h5py and to VTK's reader; flat pieces are grids."""
        series = json.loads((folder / "bodies_hdf-chain.hdf.series").read_text("utf-8"))
        times = [(member["time"], member["name"]) for member in series["files"]]
        self.assertEqual(times, [(step, f"bodies_hdf-chain-{step:09}.hdf") for step in (0, 10, 20)])
        for file, arrays, cells in (
            ("bodies_hdf-chain", chain, [[0, 1], [1, 2], [2, 3], [3, 4]]),
            ("all_hdf", whole, None),
            ("slice_hdf", slice_, [[16 * z + x, 16 * z + x + 1, 16 * z + x + 16, 16 * z + x + 17] for z in range(9) for x in range(15)]),
        ):
            with h5py.File(folder / f"{file}-000000020.hdf") as opened:
                group = opened["VTKHDF"]
                self.assertEqual(list(group.attrs["Version"]), [1, 0])
                self.assertEqual(group.attrs["TimeValue"], 20.0)
                held = {name: data[()] for of in ("PointData", "CellData") if of in group for name, data in group[of].items()}
                for name, values in held.items():
                    self.assertTrue(np.array_equal(values.reshape(arrays[name].shape), arrays[name]), name)
                left_out = {"Points", "connectivity", "offsets", "types"}
                self.assertEqual(set(held), set(arrays) - left_out)
                if cells is None:
                    self.assertEqual(group["PointData/velocity"].shape, (10, 12, 16, 3))
                else:
                    self.assertEqual(group["Connectivity"][()].reshape(-1, len(cells[0])).tolist(), cells)
            grid = self.by_vtk_hdf(folder / f"{file}-000000020.hdf")
            if grid is None:
                continue
            self.assertEqual(grid.GetClassName(), "vtkImageData" if cells is None else "vtkUnstructuredGrid")
            self.assertEqual(grid.GetNumberOfCells(), 15 * 11 * 9 if cells is None else len(cells))
            for name, values in held.items():
                got = grid.GetPointData().GetArray(name) or grid.GetCellData().GetArray(name)
                self.assertTrue(np.array_equal(vtk_to_numpy(got), values.reshape(arrays[name].shape)), name)
        grid = self.by_vtk_hdf(folder / "slice_hdf-000000020.hdf")
        if grid is not None:
            self.assertEqual(grid.GetBounds(), (0.0, 15.0, 6.0, 6.0, 0.0, 9.0))
            self.assertEqual(self.by_vtk_hdf(folder / "all_hdf-000000020.hdf").GetBounds(), (0.0, 15.0, 0.0, 11.0, 0.0, 9.0))
            self.assertEqual(self.by_vtk_hdf(folder / "line_hdf-000000020.hdf").GetBounds(), (3.0, 3.0, 6.0, 11.0, 4.0, 4.0))
            self.assertEqual(self.by_vtk_hdf(folder / "line_hdf-000000020.hdf").GetNumberOfCells(), 5)
            self.assertEqual(self.by_vtk_hdf(folder / "node_hdf-000000020.hdf").GetNumberOfCells(), 1)

    def by_vtk_hdf(self, path):
        """The grid of a file by VTK's own reader, None where that is not installed."""
        if vtkHDFReader is None:
            return None
        reader, errors = vtkHDFReader(), []
        reader.AddObserver("ErrorEvent", lambda *_: errors.append(path.name))
        reader.SetFileName(str(path))
        reader.Update()
        self.assertEqual(errors, [])
        return reader.GetOutput()

    def compare_atoms(self, folder, chain):
        """A data file is read as a body of another scene, at the same places; and by LAMMPS, where that is installed."""
        text = SCENE[: SCENE.index("[[body]]")].replace('"mine"', '"again"')
        text += """
[[body]]
name = "read"
shape.lammps = { file = "mine.snapshots/atoms-000000020.data" }
bond = { law = "harmonic", k = 0.02, r0 = 1.0 }
node_mass = 2.0
[run]
steps = 1
[[observe]]
what = "nodes"
body = "read"
every = 1
"""
        (folder.parent / "again.toml").write_text(text, "utf-8")
        self.run_cases("results/again.toml", "--out", "results")
        nodes = veriflex.load(folder.parent / "again.h5").record("nodes")
        start = nodes["step"] == 0
        self.assertTrue(np.array_equal(np.stack([nodes[name][start] for name in "xyz"], axis=1), chain["Points"]))
        if not shutil.which("lmp"):
            return
        script = (
            "units lj\natom_style angle\nboundary f f f\nread_data atoms-000000020.data\nbond_style zero\nbond_coeff *\n"
            "pair_style zero 1.0\npair_coeff * *\n"
            "dump all all custom 1 read.dump id x y z vx vy vz mass\ndump_modify all sort id format float %.17g\nrun 0\n"
        )
        ran = subprocess.run(["lmp", "-log", "none"], input=script, cwd=folder, capture_output=True, text=True)
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
        rows = np.loadtxt(folder / "read.dump", skiprows=9)
        self.assertTrue(np.array_equal(rows[:, 1:4], chain["Points"]))
        self.assertTrue(np.array_equal(rows[:, 4:7], chain["velocity"]))
        self.assertTrue(np.all(rows[:, 7] == 2.0))

    def read_by_vtk(self, folder, chain, slice_):
        """The same arrays by VTK's own readers, where they are installed."""
        if vtkHDFReader is None:
            return
        body = vtkXMLUnstructuredGridReader()
        body.SetFileName(str(folder / "bodies-chain-000000020.vtu"))
        body.Update()
        grid = body.GetOutput()
        self.assertEqual(grid.GetNumberOfCells(), 4)
        self.assertTrue(np.array_equal(vtk_to_numpy(grid.GetPoints().GetData()), chain["Points"]))
        self.assertTrue(np.array_equal(vtk_to_numpy(grid.GetCellData().GetArray("tension")), chain["tension"]))
        fluid = vtkXMLImageDataReader()
        fluid.SetFileName(str(folder / "slice-000000020.vti"))
        fluid.Update()
        image = fluid.GetOutput()
        self.assertEqual(image.GetDimensions(), (16, 1, 10))
        self.assertEqual(image.GetOrigin(), (0.0, 6.0, 0.0))
        self.assertTrue(np.array_equal(vtk_to_numpy(image.GetPointData().GetArray("velocity")), slice_["velocity"]))

    def test_a_shorter_run_leaves_no_files_of_the_longer_one(self):
        (self.path / "mine.toml").write_text(SCENE, "utf-8")
        folder = self.path / "again" / "mine.snapshots"
        self.run_cases("mine.toml", "--out", "again")
        self.assertTrue((folder / "slice-000000015.vti").exists())
        text = SCENE.replace("steps = 20", "steps = 10")
        (self.path / "mine.toml").write_text(text, "utf-8")
        self.run_cases("mine.toml", "--out", "again")
        self.assertFalse((folder / "slice-000000015.vti").exists())
        self.assertTrue((folder / "slice-000000010.vti").exists())
        self.assertFalse((folder / "slice_hdf-000000015.hdf").exists() or (folder / "atoms-000000020.data").exists())


class Units(unittest.TestCase):
    def test_dimensions_scale(self):
        self.assertEqual(veriflex.factor("M L^-1 T^-2", mass=8.0, length=2.0, time=4.0), 0.25)
        self.assertEqual(veriflex.factor("1", mass=8.0, length=2.0, time=4.0), 1.0)
        with self.assertRaises(ValueError):
            veriflex.factor("kg", mass=1.0, length=1.0, time=1.0)


class BadFiles(unittest.TestCase):
    def test_what_is_no_result_says_so(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "x.h5")
            path.write_text("no result")
            with self.assertRaisesRegex(veriflex.UnreadableResult, "x.h5: no checksum in front"):
                veriflex.load(path)
            with self.assertRaises(veriflex.UnreadableResult):
                veriflex.load_folder(folder)


if __name__ == "__main__":
    unittest.main()
