#!/usr/bin/python3
"""Tests of the report: small result files in, one page out."""

import fcntl
import hashlib
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

from report import equation, studies

REPORT = Path(__file__).with_name("report.py")
TEXT = h5py.string_dtype("utf-8")
CHECK = dict(
    metric="young_modulus", kind="verification", measured=1021.1862965340421, target=1021.1862965340418, tolerance=1e-9,
    tolerance_text="1e-12 relative", reason="round-off", error=3e-13, margin=3e-4, verdict="pass", reference="fene-lj-rest-state",
    target_kind="high-precision", source="30 digits", claim="", holds="within", statement="The modulus is U''/r.",
)  # fmt: skip
NO_UNCERTAINTY = {f"uncertainty_{name}": math.nan for name in ("reference", "numerical", "input")}
REFUTED = CHECK | dict(kind="claim", target=1021.1439, error=0.0424, margin=848.0, verdict="finding")
FAILED = CHECK | dict(metric="order_central", measured=1.62, target=2.0, error=0.38, margin=3.8, verdict="fail")


def write_table(file, place, columns):
    group = file.create_group(place)
    group.attrs.create("columns", np.array(list(columns), dtype=object), dtype=TEXT)
    for name, values in columns.items():
        is_text = len(values) and isinstance(values[0], str)
        kind = TEXT if is_text else float
        group.create_dataset(name, data=np.array(values, dtype=object if is_text else float), dtype=kind)
    return group


def write_rows(file, place, rows):
    write_table(file, place, {name: [row[name] for row in rows] for name in (rows[0] if rows else {})})


def seal(path):
    """Puts the checksum in front, as veriflex does."""
    body = path.read_bytes()[512:]
    head = f"veriflex-result\nbytes {len(body)}\nsha256 {hashlib.sha256(body).hexdigest()}\n"
    path.write_bytes(head.encode().ljust(512, b"\n") + body)


def write_result(folder, name, verdict, checks=(), title="A title", records=(), metrics=(), provenance={}, **more):
    """A result file of schema 2."""
    with h5py.File(folder / f"{name}.h5", "w", userblock_size=512) as file:
        texts = dict(format="veriflex-result", id=name, title=title, question="Does it hold?", equation="E = U''/r₀")
        for key, value in (texts | dict(driver="derive", tier="quick", verdict=verdict) | more).items():
            file.attrs[key] = value
        file.attrs["schema"] = 2
        file.attrs["findings"] = sum(check["verdict"] == "finding" for check in checks)
        for key in ("topics", "sources"):
            file.attrs.create(key, np.array(["wu-qi-2014"], dtype=object), dtype=TEXT)
        case = file.create_dataset("case", data="[bond]\n", dtype=TEXT)
        case.attrs["path"] = f"cases/{name}.toml"
        case.attrs.create("overrides", np.array(["bond.r_max=1.5"], dtype=object), dtype=TEXT)
        write_rows(file, "plan/built", [dict(module="bond", what="fene-lj", memory_bytes=40)])
        write_rows(file, "plan/left_out", [dict(module="fluid", why="not named")])
        file.create_group("provenance").attrs.update(
            dict(version="0.1", revision="abc123", compiler="GNU 12", machine="x86_64", threads=2, date="2025-01-01") | provenance
        )
        for record, columns in records:
            write_table(file, f"records/{record}", columns)
        write_rows(file, "metrics", [dict(name="young_modulus", value=1.0, dimension="M L^-1 T^-2", meaning="E"), *metrics])
        write_rows(file, "checks", list(checks))
        write_rows(file, "timing", [dict(phase="run", wall_seconds=0.5, cpu_seconds=0.5)])
    seal(folder / f"{name}.h5")


CACHE = tempfile.TemporaryDirectory()
ENVIRONMENT = os.environ | {"XDG_CACHE_HOME": CACHE.name}


def run(*arguments, **environment):
    words = [sys.executable, "-B", REPORT, *arguments]
    return subprocess.run(words, capture_output=True, text=True, env=ENVIRONMENT | environment)


def page_of(folder, *arguments, **environment):
    """The page about a folder."""
    ran = run(folder, *arguments, **environment)
    assert ran.returncode == 0, ran.stderr
    return (Path(folder) / "report.html").read_text(encoding="utf-8")


def filament_records():
    """The records of the driven filament with two laws, small."""
    phase = np.repeat([0.25, 0.5, 0.75, 1.0], 5)
    y = np.tile(np.linspace(0, 50, 5), 4)
    line = dict(phase=phase, y=y, z=phase * y, y_compared=y, z_compared=1.1 * phase * y)
    time = np.linspace(0, 1, 9)
    moments = ("drive", "force", "centre_y", "slip", "min_strain", "max_strain")
    history = dict(time=time) | {name: np.sin(6 * time) for name in moments}
    far = dict(z_max=[0.02, 0.03], z_rms=[0.01, 0.02], swimming_max=[0.05, 0.06])
    grid_phase, z, y = np.meshgrid(np.arange(1, 9) / 8, np.arange(-4.0, 5.0), np.arange(-2.0, 50.0), indexing="ij")
    frames = dict(phase=grid_phase, y=y, z=z, speed=grid_phase * np.exp(-(z**2)))
    return [
        ("centre_lines", line),
        ("film", {name: values.ravel() for name, values in frames.items()}),
        ("law_deviation", dict(phase=[0.25, 0.5]) | far),
        ("stroke", history),
        ("stroke_compared", history),
        ("strain_histogram", dict(length=[0.9, 1.0, 1.1], share=[0, 0.9, 0.1], share_compared=[0.1, 0.9, 0])),
        ("modulus_deviation", dict(factor=[0.9, 1.1]) | far),
    ]


def sensitivity():
    """Record and metrics of a base with three variants: one that changes something, one nothing, one that breaks off."""
    effect, apart = [0.0, 0.02, 0.0, np.nan], [0.03, 0.04, 0.03, np.nan]
    table = dict(variant=[0, 1, 2, 3], survived=[1, 1, 1, 0], effect_z=effect, law_deviation_z=apart)
    labels = dict(wide="box: wide", same="nothing", thin="tau = 0.6 (step 3: bond (1, 2) is gone)")
    metrics = [
        dict(name=f"effect_{name}", value=value, dimension="1", meaning=f"max |dz|/z0 from the base: {label}")
        for (name, label), value in zip(labels.items(), effect[1:])
    ]
    return dict(records=[("sensitivity", table)], metrics=metrics)


def harmonic():
    """The record of the first harmonic of a filament beside one theory."""
    section = np.arange(5.0)
    names = ("amplitude", "phase", "amplitude_compared", "phase_compared", "amplitude_rings", "phase_rings")
    return [("first_harmonic", dict(section=section) | {name: section / 4 for name in names})]


class WrittenReport(unittest.TestCase):
    """One page about one folder, looked at from all sides: drawing takes most of the time."""

    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.scratch.name)
        strain = np.linspace(-0.1, 0.4, 26)
        curve = dict(strain=strain, stress=strain * (1 - strain))
        write_result(cls.folder, "derive-one", "pass", [CHECK, REFUTED], title="<script>alert(1)</script>")
        records = [("stress_strain", curve), ("own", curve), ("kinks", dict(strain=[0.168], jump=[-0.059]))]
        write_result(cls.folder, "tensile-two", "fail", [CHECK, FAILED], records=records)
        write_result(cls.folder, "filament-three", "pass", [CHECK], records=filament_records())
        write_result(cls.folder, "filament-variants", "pass", [CHECK], **sensitivity())
        write_result(cls.folder, "filament-linear", "pass", [CHECK], records=harmonic())
        failure = dict(error_kind="NumericalFailure", error_message="step 3: bond < at its limit")
        write_result(cls.folder, "broken-run", "error", **failure)
        whole = (cls.folder / "derive-one.h5").read_bytes()
        (cls.folder / "truncated.h5").write_bytes(whole[: len(whole) // 2])
        (cls.folder / "not-hdf5.h5").write_text("text")
        for name, stated in dict(
            other=dict(format="something-else"),
            newer=dict(format="veriflex-result", schema=99),
            lacking=dict(format="veriflex-result", schema=2),
        ).items():
            with h5py.File(cls.folder / f"{name}.h5", "w", userblock_size=512) as file:
                file.attrs.update(stated)
            seal(cls.folder / f"{name}.h5")
        cls.ran = run(cls.folder)
        cls.page = (cls.folder / "report.html").read_text(encoding="utf-8")

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def figure(self, start):
        """The SVG whose description starts so."""
        return re.search(rf'<svg[^>]*aria-label="{start}.*?</svg>', self.page, flags=re.DOTALL)[0]

    def test_succeeds_whatever_the_verdicts_and_names_the_page_last(self):
        self.assertEqual(self.ran.returncode, 0, self.ran.stderr)
        self.assertEqual(self.ran.stdout.splitlines()[-1], str(self.folder / "report.html"))
        self.assertIn("11 cases: 4 pass, 1 fail, 6 error (5 unreadable)", self.ran.stdout)

    def test_page_needs_nothing_from_outside(self):
        # Pictures within the SVG are part of the page; links may lead to files of the source tree.
        without_links = re.sub(r'<a (?:class="id" )?href="(?:\.\./)+[\w/.-]+">', "", self.page)
        self.assertNotRegex(without_links, r"""(?:src|href)\s*=\s*["'](?!#|data:image/png;base64,)""")
        self.assertNotRegex(self.page, r"@import|url\((?!#)|<img|<link|<script (?!>)|https?:")

    def test_page_states_every_verdict(self):
        for word in ("pass", "fail", "error", "refuted: finding", "unreadable"):
            self.assertRegex(self.page, rf'<span class="verdict \w+">{word}</span>')

    def test_refuted_claim_shows_both_numbers_in_full(self):
        self.assertIn('title="1021.1439"', self.page)
        self.assertIn('title="1021.1862965340421"', self.page)

    def test_unreadable_files_are_rows_that_name_file_and_remedy(self):
        for name in ("truncated.h5", "not-hdf5.h5", "other.h5", "newer.h5", "lacking.h5"):
            self.assertIn(f'<span class="id">{name}</span>', self.page)
            self.assertRegex(self.ran.stderr, rf"{name}: .+ \(.+\)\. .+")

    def test_filaments_have_a_figure_for_each_record_but_the_compared_stroke(self):
        own = "What each variant", "First harmonic", "Speed of the fluid at"
        for start in (*own, "Centre lines in the last", "How far the two laws", "The stroke", "Bond lengths", "Centre lines of one"):
            self.assertEqual(len(re.findall(rf'aria-label="{start}', self.page)), 1, start)

    def test_variants_are_named_as_the_case_names_them_and_one_that_broke_off_says_so(self):
        drawn = re.findall(r"<text[^>]*>([^<]*)</text>", self.figure("What each variant"))
        for text in ("box: wide", "nothing", "tau = 0.6", "broke off", "from the base: 0"):
            self.assertIn(text, drawn)

    def test_film_has_a_picture_for_each_phase_and_stays_small(self):
        drawn = self.figure("Speed of the fluid at 8 phases")
        self.assertEqual(drawn.count('href="data:image/png'), 8)
        for phase in np.arange(1, 9) / 8:
            self.assertIn(f">t = {phase:g} T<", drawn)
        self.assertLess(len(drawn), 30_000)

    def test_text_of_files_is_escaped(self):
        self.assertIn("&lt;script&gt;alert(1)&lt;/script&gt;", self.page)
        self.assertIn("bond &lt; at its limit", self.page)

    def test_ids_are_unique_and_every_link_has_a_target(self):
        ids = re.findall(r'\sid="([^"]+)"', self.page)
        self.assertEqual(len(ids), len(set(ids)))
        self.assertLessEqual(set(re.findall(r'href="#([^"]+)"', self.page)), set(ids))
        self.assertLessEqual(set(re.findall(r"url\(#([^)]+)\)", self.page)), set(ids))

    def test_numbers_lead_to_their_sources(self):
        self.assertRegex(self.page, r'\(reference <a href="(\.\./)+[\w/.-]+/reference/fene-lj-rest-state.toml">fene-lj-rest-state</a>\)')
        self.assertIn('From <a href="#source-wu-qi-2014">wu-qi-2014</a>', self.page)
        self.assertRegex(self.page, r'<dt id="source-wu-qi-2014">wu-qi-2014<dd>Wu, T.-H. and Qi, D. \(2014\)')

    def test_known_and_unknown_records_are_drawn(self):
        drawn = 2 + 6 + 2  # of tensile-two, filament-three and the two other filaments
        self.assertEqual(self.page.count('class="plot"'), drawn + 1)  # and the filament of the first screen
        self.assertEqual(self.page.count('class="thumb"'), 6)

    def test_record_too_short_for_a_figure_is_a_table(self):
        self.assertIn("<td>−0.059", self.page)

    def test_same_input_gives_the_same_page(self):
        again = self.folder / "again.html"
        self.assertEqual(run(self.folder, "--out", again).returncode, 0)
        self.assertEqual(again.read_text(encoding="utf-8"), self.page)


class Ledger(unittest.TestCase):
    def page_of(self, folder, claims, counts):
        ledger = Path(folder, "claims.json")
        ledger.write_text(json.dumps(dict(claims=claims, counts=counts)))
        ran = run(folder, "--claims", ledger)
        self.assertEqual(ran.returncode, 0, ran.stderr)
        return ran.stdout, Path(folder, "report.html").read_text(encoding="utf-8")

    def test_every_entry_is_a_row_with_its_standing_and_its_checks(self):
        entry = dict(where="Eq. 1", states="E = <1>", conditions="", notes="", kind="published-number")
        number = dict(metric="m", statement="s", target_kind="published-number", measured=3.0, target=1.0, tolerance=0.5)
        found = [
            dict(case="one", verdict="finding", holds="within") | number,
            dict(case="one", verdict="pass", holds="outside") | number | dict(target_kind="reading"),
            dict(case="two", verdict="not run"),
        ]
        claims = [
            entry | dict(id="modulus", judgements=found, standing="refuted in part"),
            entry | dict(id="speed", judgements=[], standing="not decidable", kind="not-decidable"),
        ]
        counts = {"holds": 0, "refuted in part": 1, "refuted": 0, "not decidable": 1, "not run": 0, "unsettled": 0}
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "one", "pass")
            out, page = self.page_of(folder, claims, counts)
            words = "0 hold, 1 refuted in part, 0 refuted, 1 not decidable, 0 not run"
            self.assertIn(f"statements of the paper: {words}\n", out)
            self.assertRegex(out, r"not run: \d+ of tier quick, \d+ of tier full, \d+ of tier paper")
            self.assertRegex(page, r"Not run: \d+ of tier quick")
            self.assertIn(f"2 statements: {words}", page)
            self.assertIn("E = &lt;1&gt;", page)
            self.assertIn("published 1", page)
            self.assertIn("must lie beyond 1 ± 0.5", page)
            ran = run(folder, "--claims", Path(folder, "absent.json"))
            self.assertEqual(ran.returncode, 2)

    def test_cases_that_judge_nothing_get_a_report_without_the_paper(self):
        entry = dict(id="modulus", where="Eq. 1", states="E", conditions="", notes="", kind="reading", standing="not run")
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "one", "pass")
            out, page = self.page_of(folder, [entry | dict(judgements=[])], {"not run": 1})
            self.assertNotIn("statements of the paper", out)
            self.assertNotIn("not run", out)
            self.assertNotIn('id="ledger"', page)


class Published(unittest.TestCase):
    def test_values_with_uncertainties_are_drawn_and_summed_up_by_family(self):
        known = CHECK | dict(
            metric="drag", target=100.0, measured=101.0, error=1.0, tolerance=5.0, margin=0.2, reference="zick-homsy-1982",
            target_kind="published-number", uncertainty_reference=3.0, uncertainty_numerical=4.0, uncertainty_input=0.0,
        )  # fmt: skip
        apart = known | dict(measured=109.0, error=9.0, margin=1.8, verdict="fail")
        falling = known | dict(reference="", source="ten-cate-2002, case E1", target=-2.0, measured=-2.0, error=0.0, margin=0.0, tolerance=0.1)
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "array", "fail", [known, apart, CHECK | NO_UNCERTAINTY])
            write_result(Path(folder), "sphere", "pass", [falling])
            page = page_of(folder)
        self.assertIn("2 of 3 agree within their uncertainties", page)
        self.assertIn("zick-homsy-1982</a><td>derive<td>2<td>1<td>5 %<td>5.7 %<td>5 %", page)
        self.assertIn("ten-cate-2002</a><td>derive<td>1<td>1<td>0 %<td>–<td>5 %", page)
        self.assertIn("computed over published", page)
        self.assertIn("<i>numerical</i> 4 ", page)

    def test_benchmarks_say_who_agrees_within_what_and_what_is_not_compared(self):
        entry = dict(where="jeffery-1922", conditions="", notes="", kind="exact-law")
        number = dict(metric="m", statement="s", target_kind="analytic", holds="within", is_uncertainty=False, wall_seconds=90.0)
        found = [
            dict(case="turn", verdict="pass", measured=1.01, target=1.0, tolerance=0.02) | number,
            dict(case="error", verdict="pass", measured=3e-3, target=0.0, tolerance=5e-3) | number,
            dict(case="elsewhere", verdict="not run"),
        ]
        benchmarks = [
            entry | dict(id="orbit", states="T = 2 pi/g", judgements=found, standing="holds"),
            entry | dict(id="flag", states="a flag", notes="Values not confirmed.", kind="not-compared", judgements=[], standing="not run"),
        ]
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "turn", "pass", [CHECK])
            ledger = Path(folder, "claims.json")
            ledger.write_text(json.dumps(dict(claims=[], counts={}, benchmarks=benchmarks)))
            short = page_of(folder, "--claims", ledger)
            for other in ("one", "two", "three"):
                write_result(Path(folder), other, "pass", [CHECK])
            page = page_of(folder, "--claims", ledger)
        self.assertIn("1 of 1 systems agree</p>", short)
        self.assertNotIn("a flag", short)  # a report on few cases leaves out what none of them computes
        self.assertIn("1 of 1 systems agree; 1 are not compared yet", page)
        self.assertIn('<td class="n">1 %<td class="n">2 %', page)
        self.assertIn('<td class="n">0.003<td class="n">0.005', page)
        self.assertIn('<td>tolerance<td class="n">90 s', page)
        self.assertIn("a flag <small>Values not confirmed.</small>", page)

    def test_results_of_before_and_without_uncertainties_have_no_such_section(self):
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "before", "pass", [CHECK])
            write_result(Path(folder), "without", "pass", [CHECK | NO_UNCERTAINTY])
            self.assertNotIn('id="published"', page_of(folder))


class Codes(unittest.TestCase):
    """Numbers of other codes beside this program's."""

    @staticmethod
    def write(folder, name, checks, code="LAMMPS 1", case="ours"):
        write_result(folder, name, "pass", checks, provenance=dict(other_code=code, other_code_obtained="by hand", other_code_case=case))

    def test_their_records_are_drawn_column_by_column_whatever_they_are_called(self):
        with tempfile.TemporaryDirectory() as folder:
            records = [("elastica_exact", dict(load=[0.0, 1.0, 2.0], tip=[0.0, 0.3, 0.5]))]
            write_result(Path(folder), "theirs", "measured", records=records, provenance=dict(other_code="LAMMPS 1"))
            self.assertIn("<figure", page_of(folder))

    def table(self, page):
        section = page.partition('<section id="codes">')[2].partition("</section>")[0]
        return [re.split("<t[dh][^>]*>", row)[1:] for row in section.split("<tr>")[1:]]

    def test_without_other_codes_there_is_no_table(self):
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "ours", "pass", [CHECK])
            self.assertNotIn('id="codes"', page_of(folder))

    def test_a_row_is_a_case_and_a_column_a_code(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder)
            write_result(path, "ours", "pass", [CHECK, CHECK | dict(metric="not_asked_of_them")])
            self.write(path, "theirs", [CHECK | dict(error=0.25, tolerance=0.5)])
            self.write(path, "without-ours", [CHECK], code="LBM 2", case="")
            head, ours, alone = self.table(page_of(folder))
            self.assertEqual([cell.split("<")[0].strip() for cell in head], ["Case", "veriflex", "LAMMPS 1", "LBM 2"])
            self.assertIn("ours", ours[0])
            self.assertIn("off by 3 × 10<sup>−13</sup>", ours[1])
            self.assertNotIn("not_asked_of_them", ours[1])
            self.assertIn("off by 0.25, within 0.5", ours[2])
            self.assertEqual(ours[3].strip().split("<")[0], "–")
            self.assertIn("without-ours", alone[0])
            self.assertEqual(alone[1].strip().split("<")[0], "–")
            self.assertIn("pass", alone[3])


class OddFiles(unittest.TestCase):
    """What may lie among the results is a row each, and never the end of the report."""

    def test_each_is_a_row_and_the_good_one_is_shown(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch)
            write_result(folder, "good", "pass", [CHECK])
            whole = (folder / "good.h5").read_bytes()
            flipped = bytearray(whole)
            flipped[len(whole) // 2] ^= 1
            (folder / "flipped.h5").write_bytes(flipped)
            (folder / "older.h5").write_bytes(whole[512:])
            (folder / "empty.h5").touch()
            (folder / "huge.h5").touch()
            os.truncate(folder / "huge.h5", 1 << 40)
            (folder / "long.h5").write_bytes(whole + b"x")
            os.mkfifo(folder / "pipe.h5")
            (folder / "folder.h5").mkdir()
            (folder / "dangling.h5").symlink_to("nowhere")
            (folder / "circle.h5").symlink_to("circle.h5")
            Path(os.fsdecode(os.fsencode(folder) + b"/b\xffd.h5")).write_text("text")
            write_result(folder, "odd-types", "pass", [CHECK | dict(margin="text")])
            write_result(folder, "odd-record", "pass", [CHECK], records=[("stress_strain", dict(strain=["a"], stress=["b"]))])
            words = dict(a=["x", "y"], outcome=["completed"] * 2, node_updates=["z"] * 2, parts_bytes=["u"] * 2, boundary=["v"] * 2)
            odd = [(name, words) for name in ("sweep", "sweep_cost", "sweep_front", "sweep_reached", "outcome_boundary", "centre_lines", "film")]
            ablation = words | dict(variant=["as it stands", "with"], moved=["w"] * 2, origin=["kept"] * 2)
            write_result(folder, "cost-of-odd", "pass", records=[*odd, ("ablate", ablation), ("ablate_cost", words), ("potential", words)])
            ran = run(folder)
            self.assertEqual(ran.returncode, 0, ran.stderr)
            self.assertNotIn("Traceback", ran.stderr)
            for name in ("flipped", "older", "empty", "huge", "long", "pipe", "folder", "dangling", "circle"):
                self.assertRegex(ran.stdout, rf"(?m)^{name}\.h5 +unreadable")
                self.assertRegex(ran.stderr, rf"{name}\.h5: .+ \(.+\)\. .+")
            self.assertRegex(ran.stdout, r"(?m)^good +pass")
            self.assertIn("does not match its checksum", ran.stderr)
            self.assertIn("no checksum in front", ran.stderr)

    def test_text_that_is_no_utf8_is_shown_with_replacements(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch)
            write_result(folder, "bad", "error", error_kind="input", error_message=np.array(b"b\xffd", dtype=TEXT))
            ran = run(folder)
            self.assertEqual(ran.returncode, 0, ran.stderr)
            self.assertIn("b\ufffdd", (folder / "report.html").read_text(encoding="utf-8"))


class Variants(unittest.TestCase):
    def test_changed_case_is_marked_and_not_counted(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch)
            write_result(folder, "one", "pass", [CHECK])
            changed = dict(case_id="one", variant="bond.epsilon=2.0")
            write_result(folder, "one+bond.epsilon=2.0", "fail", [FAILED, REFUTED], **changed)
            write_result(folder, "bare", "measured")
            ran = run(folder)
            self.assertEqual(ran.returncode, 0, ran.stderr)
            self.assertRegex(ran.stdout, r"(?m)^one\+bond\.epsilon=2\.0 +fail")
            counts = "2 cases: 1 pass, 0 fail, 0 error, 1 measured without a check; not counted: 1 changed by --set"
            self.assertIn(counts, ran.stdout)
            page = (folder / "report.html").read_text(encoding="utf-8")
            self.assertIn("changed: --set bond.epsilon=2.0", page)
            self.assertIn("All cases pass", page)


class Methods(unittest.TestCase):
    @staticmethod
    def family(method):
        """Records of a timed sweep with an error, of which only the last row of each method is beaten by its own."""
        rows = dict(method=np.repeat(method, 3).tolist(), n=[1.0, 2.0, 3.0] * len(method), outcome=["completed"] * 3 * len(method))
        errors, work = np.tile([1e-1, 1e-2, 1e-1], len(method)), np.tile([10.0, 20.0, 40.0], len(method))
        axes = {name: rows[name] for name in ("method", "n")}
        best = {name: values[:2] for name, values in axes.items()} | dict(error=errors[:2])
        return [
            ("sweep", rows | dict(error=errors, node_updates=0 * work, bond_evaluations=work)),
            ("sweep_cost", axes | dict(wall_seconds=1e-3 * work, min_wall_seconds=1e-3 * work, max_wall_seconds=1e-3 * work)),
            ("sweep_front", best | dict(bond_evaluations=work[:2])),
            ("sweep_cost_front", best | dict(wall_seconds=1e-3 * work[:2])),
            ("sweep_cost_reached", dict(asked=[1e-1, 1e-2]) | best | dict(wall_seconds=1e-3 * work[:2], next_step=["", ""])),
        ]

    def picture(self, *names):
        with tempfile.TemporaryDirectory() as folder:
            for name, methods in zip(names, (["plain", "fancy"], ["third"])):
                write_result(Path(folder), name, "measured", records=self.family(methods))
            page = page_of(folder)
        return re.search(r'<svg[^>]*aria-label="[^"]*by other methods.*?</svg>', page, flags=re.DOTALL)

    def test_cases_that_ask_the_same_of_other_methods_share_a_picture_of_what_none_of_their_own_beats(self):
        drawn = self.picture("cost-swing", "cost-swing-other")[0]
        for label in ("plain", "fancy", "other, third"):
            self.assertIn(f">{label}<", drawn)
        told = re.search(r'data-hints="([^"]*)"', drawn)[1]
        self.assertEqual(len(told.split("\n")), 2 * 3 * 2)  # panels, lines, and rows of each that are not beaten

    def test_cases_of_other_questions_share_none(self):
        self.assertIsNone(self.picture("cost-swing", "cost-swinging"))


class Skipped(unittest.TestCase):
    def test_skipped_case_says_why_and_is_neither_passed_nor_broken(self):
        why = "this program was built without SUNDIALS. Install it"
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch)
            write_result(folder, "one", "pass", [CHECK])
            for name in ("absent", "away"):
                write_result(folder, name, "skipped", error_kind="lacking", error_message=why)
            ran = run(folder)
            self.assertEqual(ran.returncode, 0, ran.stderr)
            self.assertIn("3 cases: 1 pass, 0 fail, 0 error, 2 skipped", ran.stdout)
            self.assertIn(f"skipped: absent, away: {why}", ran.stdout)
            page = (folder / "report.html").read_text(encoding="utf-8")
            self.assertIn("All others pass", page)
            self.assertEqual(page.count('<span class="verdict skipped">skipped</span>'), 3)
            self.assertRegex(page, rf'<p class="soft">Skipped: .*absent.*away.*: {why}')


class LeftOut(unittest.TestCase):
    def test_parts_that_change_nothing_and_parts_that_are_needed_are_told_apart(self):
        table = dict(
            variant=["as it stands", "with angles", "with populations", "without walls", "in float"],
            outcome=["completed"] * 5,
            node_updates=[5.0] * 5,
            parts_bytes=[1e6, 1.1e6, 2e6, 1e6, 5e5],
            message=[""] * 5,
            moved=[0.0, 0.0, 1e-13, 2.0, 1e-6],
            origin=["case", "kept", "kept", "given", "given"],
        )
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "ablate-me", "measured", records=[("ablate", table)])
            written = run(folder)
            self.assertEqual(written.returncode, 0, written.stderr)
            page = (Path(folder) / "report.html").read_text("utf-8")
        self.assertIn("1 changed nothing, bit by bit; 1 by rounding; 0 more than that", page)
        self.assertIn("2 other changes of these scenes were seen, the least of them 1e-06 (ablate-me, in float)", page)


    def test_panel_says_what_was_saved_and_seconds_only_of_repeats(self):
        table = dict(variant=["as it stands", "with populations"], outcome=["completed"] * 2, node_updates=[5.0] * 2)
        table |= dict(parts_bytes=[1e6, 3e6], message=[""] * 2, moved=[0.0, 0.0], origin=["case", "kept"])
        cost = dict(wall_seconds=[2.0, 3.0], min_wall_seconds=[1.9, 2.9], max_wall_seconds=[2.1, 3.1])
        for meaning, said in (("median of 3", "2 MB saved beside 1 MB, 1 s beside 2 s."), ("of one run", "2 MB saved beside 1 MB.")):
            with tempfile.TemporaryDirectory() as folder:
                write_result(Path(folder), "ablate-me", "measured", records=[("ablate", table), ("ablate_cost", cost)])
                with h5py.File(Path(folder) / "ablate-me.h5", "r+") as file:
                    file["records/ablate_cost"].attrs["title"] = "What each row cost; rows ran one after another"
                    file["records/ablate_cost/wall_seconds"].attrs["meaning"] = meaning
                seal(Path(folder) / "ablate-me.h5")
                self.assertIn(said, page_of(folder))


class Motive(unittest.TestCase):
    def test_laws_are_compared_under_the_same_conditions_and_what_never_stands_is_counted(self):
        sys.path.insert(0, str(REPORT.parent))
        from report import motive
        from veriflex import results

        table = {"body.0.name": ["harmonic"] * 3 + ["fene-lj"] * 3, "body.0.coupling.subcycled": ["false", "true", "true"] * 2}
        table |= {"body.0.substeps": [1, 4, 4] * 2, "fluid.relaxation_time": [1.0, 0.6, 1.0] * 2, "boundary": [2.0, 4.0, 8.0, 1.0, np.nan, 8.0]}
        table |= {"outcome_behind": ["mach"] * 3 + ["bond"] * 3}
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "limit", "measured", records=[("outcome_boundary", table)])
            with h5py.File(Path(folder) / "limit.h5", "r+") as file:
                file["records/outcome_boundary"].attrs["title"] = "Where the outcome changes along body.0.stiffness, from 1 on"
                file.attrs.create("topics", np.array(["coupling"], dtype=object), dtype=TEXT)
            seal(Path(folder) / "limit.h5")
            rows = motive.rows([results.read_file(Path(folder) / "limit.h5")])
        found = [(row.where, row.ratios, row.lost, row.gained, row.ends) for row in rows]
        ends = ("mach", "bond")
        self.assertEqual(found, [("1 sub-step", (0.5,), 0, 0, ends), ("4 sub-steps, force following", (1.0,), 1, 0, ends)])
        (sentence,) = motive.sentences(rows)
        self.assertIn("of 3 conditions FENE-LJ bonds carry stiffer bodies than harmonic ones under 0, as stiff ones under 1, softer ones under 1", sentence)
        self.assertIn("under 1 they fail at every stiffness tried", sentence)


class Cost(unittest.TestCase):
    def test_prices_and_exponents_are_those_of_the_rows(self):
        nodes = np.array([10.0, 100.0, 1000.0])
        rows = dict(
            [("fluid.nodes.2", nodes), ("outcome", ["completed"] * 3), ("node_updates", 7 * 50 * nodes)]
            + [(name, [0.0] * 3) for name in ("bond_evaluations", "angle_evaluations", "marker_interpolations")]
            + [("parts_bytes", 7 * 64 * nodes)]
        )
        seconds = dict([("fluid.nodes.2", nodes)] + [(n, 7 * 50 * nodes * 2e-9) for n in ("wall_seconds", "min_wall_seconds")])
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "cost-of-nodes", "measured", records=[("sweep", rows), ("sweep_cost", seconds)])
            with h5py.File(Path(folder) / "cost-of-nodes.h5", "r+") as file:
                file["case"][()] = "[run]\nsteps = 50\n"
            seal(Path(folder) / "cost-of-nodes.h5")
            written = run(folder)
            self.assertEqual(written.returncode, 0, written.stderr)
            page = (Path(folder) / "report.html").read_text("utf-8")
        section = page[page.index("What a scene costs by its size") :]
        self.assertIn("<td>2 ns<td>64 B", section)


class FirstScreen(unittest.TestCase):
    """What the answer says stands in results; what it cannot say it says how to find out."""

    CLAIM = dict(kind="claim", verdict="finding", target_kind="published-number")
    ENTRY = dict(id="young-modulus", where="Eq. 25", states="E", conditions="", notes="", kind="published-number", standing="refuted")

    def write_claims(self, folder):
        found = dict(case="derive-fene-lj", verdict="finding", holds="within", metric="m", statement="s", target_kind="published-number")
        entry = self.ENTRY | dict(judgements=[found | dict(measured=3.0, target=1.0, tolerance=0.5)])
        counts = {"holds": 0, "refuted in part": 0, "refuted": 1, "not decidable": 0, "not run": 0, "unsettled": 0}
        path = Path(folder, "claims.json")
        path.write_text(json.dumps(dict(claims=[entry], counts=counts, citation="wu-qi-2014")))
        return "--claims", path

    def test_numbers_of_findings_are_those_of_results_and_lead_to_their_case(self):
        metrics = dict(secant_valid_from_1pct=-0.0015, secant_valid_to_1pct=0.0016, deviation_z_max=0.0389, min_strain=-0.15, max_strain=0.45)
        checks = [
            CHECK | self.CLAIM | dict(metric="young_modulus", target=1021.1439),
            CHECK | self.CLAIM | dict(metric="young_modulus_at_rounded", verdict="pass"),
            CHECK | self.CLAIM | dict(metric="secant_valid_to_1pct", target=0.01),
        ]
        rows = [dict(name=name, value=value, dimension="1", meaning="") for name, value in metrics.items()]
        with tempfile.TemporaryDirectory() as folder:
            for name in ("derive-fene-lj", "filament-stroke"):
                write_result(Path(folder), name, "pass", checks, metrics=rows)
            page = page_of(folder, *self.write_claims(folder))
        sentences = re.findall(r"<li>(.*?)</li>", re.search(r'<ol class="findings">(.*?)</ol>', page, flags=re.DOTALL)[1], flags=re.DOTALL)
        self.assertEqual(len(sentences), 2)
        stated = {1.0, 1021.1439, 0.01, *metrics.values()}
        for sentence in sentences:
            said, _, source = sentence.partition("<small>")
            self.assertRegex(source, r'href="#case-(derive-fene-lj|filament-stroke)"')
            numbers = [float(number) for number in re.findall(r'<data value="([^"]+)"', said)]
            self.assertTrue(numbers)
            self.assertLessEqual(set(numbers), stated)
            self.assertNotRegex(re.sub(r"<data.*?</data>", "", said), r"\d")  # no number of its own

    def test_findings_that_results_no_longer_support_are_not_said(self):
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "derive-fene-lj", "fail", [CHECK | self.CLAIM | dict(verdict="pass")])
            page = page_of(folder, *self.write_claims(folder))
        self.assertNotIn('class="findings"', page)
        self.assertIn("veriflex verify --tier quick", page)

    def test_panels_without_results_say_what_to_run(self):
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "derive-fene-lj", "pass", [CHECK])
            page = page_of(folder, *self.write_claims(folder))
        for command in ("cost-oscillation-pair", "step-limit", "ablate-paper-scene"):
            self.assertIn(f"<code>veriflex run {command}</code>", page)

    def test_panel_of_stability_takes_a_search_whose_laws_it_can_name(self):
        sys.path.insert(0, str(REPORT.parent))
        from report import stability
        from veriflex import results

        read = {}
        with tempfile.TemporaryDirectory() as folder:
            for name, laws in (("many", 10), ("five", 5), ("few", 3)):
                names = [f"law-{number}" for number in range(laws) for _ in (0, 1)]
                table = {"body.0.name": names, "strain": [0.0, 0.1] * laws, "boundary": [1.0, 2.0] * laws, "outcome_behind": ["bond"] * 2 * laws}
                write_result(Path(folder), name, "measured", records=[("outcome_boundary", table)])
                with h5py.File(Path(folder) / f"{name}.h5", "r+") as file:
                    file["records/outcome_boundary"].attrs["title"] = "Where the outcome changes along body.0.node_mass, from 1 on"
                    file["case"].attrs.create("overrides", np.array([], dtype=object), dtype=TEXT)
                seal(Path(folder) / f"{name}.h5")
                read[name] = results.read_file(Path(folder) / f"{name}.h5")
        for names, chosen in ((("many", "five", "few"), "few"), (("many", "five"), "five"), ((), None)):
            shown = stability.plainest([read[name] for name in names])
            self.assertEqual(shown and shown.id, chosen)

    def test_own_case_gets_a_short_report_without_the_paper(self):
        entry = self.ENTRY | dict(judgements=[], standing="not run")
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "mine", "pass", [CHECK], title="My bar")
            ledger = Path(folder, "claims.json")
            ledger.write_text(json.dumps(dict(claims=[entry], counts={"not run": 1}, citation="wu-qi-2014")))
            page = page_of(folder, "--claims", ledger)
        self.assertIn("<h1>My bar</h1>", page)
        for text in ('id="ledger"', 'class="panels"', 'class="findings"', "What the paper states", 'class="origin">Wu', 'id="filter"'):
            self.assertNotIn(text, page)
        self.assertRegex(page, r"<details open>\s*<summary>\s*<span")  # one case is shown at once
        self.assertLess(len(page), 40_000)


class Equations(unittest.TestCase):
    def test_letters_are_italic_words_are_not(self):
        for text, made in {
            "F_int = rho_f V (u_f - u_s)": "<i>F</i><sub>int</sub> = <i>ρ</i><sub><i>f</i></sub> <i>V</i> (<i>u</i><sub><i>f</i></sub> − <i>u</i><sub><i>s</i></sub>)",
            "a step of a sqrt(nu t)": "a step of <i>a</i> √(<i>ν</i> <i>t</i>)",
            "U''(r0)^(3/2) -> inf": "<i>U</i>′′(<i>r</i><sub>0</sub>)<sup>3/2</sup> → ∞",
            "64 x 32, the body's leap-frog <b>": "64 × 32, the body’s leap-frog &lt;<i>b</i>&gt;",
        }.items():
            self.assertEqual(equation.typeset(text), made)


class Page(unittest.TestCase):
    def test_powers_of_ten_are_raised_in_ranges_of_errors(self):
        self.assertEqual(studies.between(1e-6, math.inf).__html__(), "from 1 × 10<sup>−6</sup> up")
        self.assertEqual(studies.between(0.5, 2.0).__html__(), "from 0.5 to 2")

    def test_long_curves_cost_little(self):
        x = np.linspace(0, 1, 10000)
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "long", "measured", records=[("own", dict(time=x, value=np.sin(40 * x)))])
            figure = re.search(r'<svg[^>]*class="plot".*?</svg>', page_of(folder), flags=re.DOTALL)[0]
        self.assertLess(len(figure), 8000)

    def test_headings_are_in_order_and_inputs_have_labels(self):
        with tempfile.TemporaryDirectory() as folder:
            for number in range(5):
                write_result(Path(folder), f"case-{number}", "pass", [CHECK])
            page = page_of(folder)
        levels = [int(level) for level in re.findall(r"<h([1-6])", page)]
        self.assertEqual((levels[0], levels.count(1)), (1, 1))
        self.assertTrue(all(after <= before + 1 for before, after in zip(levels, levels[1:])))
        self.assertEqual(len(re.findall(r"<label>[^<]+<(?:input|select)", page)), len(re.findall(r"<(?:input|select)", page)))

    def test_hints_say_every_point_in_full_once_words_left_out_are_put_back(self):
        rows = dict(tau=[0.6, 0.6, 0.8, 0.8], nodes=[8.0, 16.0] * 2, outcome=["completed"] * 4, error=[1e-2, 2.5e-3, 4e-2, 1e-2])
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "grid", "measured", records=[("sweep", rows | dict(node_updates=[1.0, 2.0] * 2))])
            told = re.search(r'data-hints="([^"]*)"', page_of(folder))[1]
        texts, before = [], []
        for line in told.split("\n"):
            words = line.split(",", 2)[2].split(" ")
            before = [word or before[index] for index, word in enumerate(words)]  # as script.js does
            texts.append(" ".join(before))
        wanted = [f"tau {tau:g}, nodes {nodes:g}: error {error:g}" for tau, nodes, error in zip(rows["tau"], rows["nodes"], rows["error"])]
        self.assertEqual(sorted(texts), sorted(wanted))
        self.assertLess(len(told), len("\n".join(wanted)) + 10 * len(wanted))  # each has its place before it

    def test_what_is_known_of_a_column_in_time_is_one_row(self):
        parts = dict(last=3.0, mean=2.0, min=1.0, max=4.0)
        metrics = [dict(name=f"forces.x.{part}", value=value, dimension="1", meaning=part) for part, value in parts.items()]
        metrics.append(dict(name="alone.last", value=5.0, dimension="1", meaning="no others"))
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "scene", "measured", metrics=metrics)
            page = page_of(folder)
        self.assertIn("<tr><td>forces.x<td>last 3, mean 2, min 1, max 4<td>1<td>last", page)
        self.assertIn("<tr><td>alone.last<td>5<td>", page)

    def test_a_scene_is_drawn_in_time_and_on_its_plane_under_its_bodies(self):
        steps = np.arange(0.0, 60.0, 10.0)
        forces = dict(step=steps, time=steps, rod_fluid_x=np.sin(steps), rod_fluid_z=0.0 * steps)
        z, x = (values.ravel() for values in np.meshgrid(np.arange(3.0), np.arange(5.0), indexing="ij"))
        flow = dict(step=0 * x + 50, time=0 * x + 50, x=x, y=0 * x, z=z, velocity_x=x, velocity_y=0 * x, velocity_z=0 * x)
        rod = dict(step=[50.0, 50.0], time=[50.0, 50.0], node=[0.0, 1.0], x=[1.0, 2.0], y=[0.0, 0.0], z=[1.0, 1.0])
        records = [("forces", forces), ("plane", flow), ("nodes", rod)]
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "flows", "pass", driver="scene", records=records)
            page = page_of(folder)
        self.assertEqual(page.count('class="plot"'), 2)  # forces, and the plane with the nodes in it
        self.assertIn("not drawn, 0 but for rounding: rod_fluid_z", page)
        self.assertIn("step 50: speed of the fluid", page)
        self.assertIn("Dots are nodes of bodies", page)

    def test_a_study_that_meets_what_is_known_stands_under_its_subject(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, claim in (("compared", "falling-sphere"), ("costly", "")):
                write_result(Path(folder), name, "pass", checks=[CHECK | dict(claim=claim)])
                with h5py.File(Path(folder) / f"{name}.h5", "r+") as file:
                    file.attrs.create("topics", np.array(["coupling", "study"], dtype=object), dtype=TEXT)
                seal(Path(folder) / f"{name}.h5")
            page = page_of(folder)
        self.assertLess(page.index("<h2>Coupling of body and fluid"), page.index('id="case-compared"'))
        self.assertLess(page.index('id="case-compared"'), page.index("<h2>Cost, and parts left out"))
        self.assertLess(page.index("<h2>Cost, and parts left out"), page.index('id="case-costly"'))

    def test_labels_of_an_axis_have_room_beside_its_title(self):
        steps = np.arange(0.0, 60.0)
        pull = {}
        for name, top in dict(a=1.0, b=0.5, c=-0.55).items():
            pull |= {f"{name}_x": 0.2 * top * steps / 59, f"{name}_y": 0.0093 * top * steps / 59}
        records = [("forces", dict(step=steps, time=steps) | pull)]
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "scene", "pass", driver="scene", records=records)
            page = page_of(folder)
        for drawing in re.findall(r'<svg[^>]*class="plot".*?</svg>', page, re.S):
            for place in re.findall(r'<text x="(-?\d+)"[^>]*rotate\(-90', drawing):
                self.assertGreaterEqual(int(place), 8 * 10)  # a line's height, in tenths of a point

    def test_figures_of_times_need_repeats(self):
        rows = dict(nodes=[8.0, 16.0], outcome=["completed"] * 2, error=[1e-2, 2.5e-3], node_updates=[1.0, 2.0])
        cost = dict(nodes=[8.0, 16.0], wall_seconds=[1.0, 2.0], min_wall_seconds=[0.9, 1.9], max_wall_seconds=[1.1, 2.2])
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "once", "measured", records=[("sweep", rows), ("sweep_cost", cost)])
            page = page_of(folder)
        self.assertEqual(page.count('class="plot"'), 1)  # the error, not the time


class Cache(unittest.TestCase):
    """What was drawn is kept by its content, and nothing that is wrong with what was kept reaches the page."""

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder, self.home = Path(scratch.name, "results"), Path(scratch.name, "cache")
        self.folder.mkdir()
        strain = np.linspace(-0.1, 0.4, 26)
        write_result(self.folder, "one", "pass", [CHECK], records=[("stress_strain", dict(strain=strain, stress=strain))])
        self.first = self.drawn()

    def drawn(self):
        return page_of(self.folder, XDG_CACHE_HOME=str(self.home))

    def entries(self):
        return sorted((self.home / "veriflex" / "report").iterdir())

    def test_second_report_is_the_same_and_draws_nothing(self):
        kept = {path.name for path in self.entries()}
        self.assertEqual(len(kept), 2)  # the figures of the case, and the page
        self.assertEqual(self.drawn(), self.first)
        self.assertEqual({path.name for path in self.entries()}, kept)

    def test_damaged_entries_cost_a_redraw(self):
        for damage in (b"", b"{}", b"\xff\xfe", None):
            for path in self.entries():
                path.write_bytes(path.read_bytes()[:-40] + b"x" * 40 if damage is None else damage)
            self.assertEqual(self.drawn(), self.first)

    def test_changed_and_damaged_results_are_seen(self):
        write_result(self.folder, "one", "fail", [FAILED])
        self.assertNotEqual(self.drawn(), self.first)
        whole = bytearray((self.folder / "one.h5").read_bytes())
        whole[len(whole) // 2] ^= 1
        (self.folder / "one.h5").write_bytes(whole)
        self.assertIn("does not match its checksum", self.drawn())

    def test_old_entries_are_swept(self):
        stale = self.home / "veriflex" / "report" / "0.json"
        stale.write_text("{}")
        os.utime(stale, (0, 0))
        write_result(self.folder, "two", "pass", [CHECK])
        self.drawn()
        self.assertFalse(stale.exists())

    def test_without_a_place_for_it_the_report_is_the_same(self):
        self.assertEqual(page_of(self.folder, XDG_CACHE_HOME="/dev/null"), self.first)


class WhereItIsWritten(unittest.TestCase):
    """What stands at --out is written to, or refused, but never replaced by a file."""

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)
        write_result(self.folder, "one", "pass")

    def test_pipe_without_reader_is_refused(self):
        os.mkfifo(self.folder / "pipe")
        ran = run(self.folder, "--out", self.folder / "pipe")
        self.assertEqual(ran.returncode, 4)
        self.assertTrue((self.folder / "pipe").is_fifo())

    def test_pipe_with_reader_gets_the_page(self):
        os.mkfifo(self.folder / "pipe")
        with subprocess.Popen(["cat", self.folder / "pipe"], stdout=subprocess.PIPE) as reader:
            self.addCleanup(reader.kill)
            with open(self.folder / "pipe", "wb", buffering=0):  # waits for the reader
                self.assertEqual(run(self.folder, "--out", self.folder / "pipe").returncode, 0)
            self.assertTrue(reader.stdout.read().endswith(b"</html>"))

    def test_links_stay_and_their_targets_get_the_page(self):
        (self.folder / "target").write_text("mine")
        (self.folder / "link").symlink_to("target")
        (self.folder / "stdout").symlink_to("/proc/self/fd/1")
        for name in ("link", "stdout"):
            ran = run(self.folder, "--out", self.folder / name)
            self.assertEqual(ran.returncode, 0, ran.stderr)
            self.assertTrue((self.folder / name).is_symlink())
        self.assertIn("</html>", (self.folder / "target").read_text())
        self.assertIn("</html>", ran.stdout)

    def test_what_killed_writers_left_is_swept_and_what_is_being_written_stays(self):
        stale, held = (self.folder / f".veriflex-{number}-0.part" for number in (1, 2))
        stale.touch()
        with held.open("w") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            self.assertEqual(run(self.folder).returncode, 0)
        self.assertFalse(stale.exists())
        self.assertTrue(held.exists())

    def test_full_standard_output_is_an_error(self):
        with open("/dev/full", "w") as full:
            words = [sys.executable, "-B", REPORT, self.folder]
            ran = subprocess.run(words, stdout=full, stderr=subprocess.PIPE, text=True, env=ENVIRONMENT)
        self.assertEqual(ran.returncode, 4)
        self.assertRegex(ran.stderr, r"^standard output: cannot be written \(.+\)\. ")
        self.assertNotIn("Exception ignored", ran.stderr)


class RefusedReport(unittest.TestCase):
    def test_missing_folder_empty_folder_and_bad_usage(self):
        with tempfile.TemporaryDirectory() as folder:
            too_long = "a" * 300
            for arguments in ([f"{folder}/absent"], [too_long], [folder], [], [folder, "--colour"]):
                ran = run(*arguments)
                self.assertEqual(ran.returncode, 2, arguments)
                self.assertNotIn("Traceback", ran.stderr)

    def test_unwritable_output_leaves_nothing_behind(self):
        with tempfile.TemporaryDirectory() as folder:
            write_result(Path(folder), "one", "pass")
            ran = run(folder, "--out", f"{folder}/absent/report.html")
            self.assertEqual(ran.returncode, 4)
            self.assertRegex(ran.stderr, r"report.html: cannot be written \(.+\)\. ")
            blocked = Path(folder, "blocked.html")
            blocked.mkdir()
            self.assertEqual(run(folder, "--out", blocked).returncode, 4)
            self.assertEqual(sorted(path.name for path in Path(folder).iterdir()), ["blocked.html", "one.h5"])


if __name__ == "__main__":
    unittest.main()
