"""Result files of `veriflex run` as plain values; the schema is described in verify/README.md.

Nothing is judged here: verdicts, errors and margins are those that the files state.
"""

import hashlib
import math
import stat
from dataclasses import dataclass, fields
from pathlib import Path

import h5py
import numpy as np

FORMAT = "veriflex-result"
SCHEMA = 2
SEAL = 512  # bytes before the HDF5 structure: name, size and SHA-256 of what follows


class UnreadableResult(Exception):
    """A file that is not a result of this schema; the text is `path: problem (why). Remedy`."""


@dataclass(frozen=True)
class Column:
    """One column of a record or reference; `dimension` is such as "M L^-1 T^-2", "1" for none, empty if not stated."""

    name: str
    values: np.ndarray
    symbol: str = ""
    dimension: str = ""
    meaning: str = ""


@dataclass(frozen=True)
class Record:
    """What a driver observed: columns of equal length, by name, in the order of the file."""

    name: str
    title: str
    columns: dict[str, Column]

    def __getitem__(self, name):
        """The numpy array of a column."""
        return self.columns[name].values

    def keys(self):
        """With it a record is a mapping: `dict(record)` has the arrays by name."""
        return self.columns.keys()

    @property
    def dimensions(self):
        """Dimension of each column, by name."""
        return {name: column.dimension for name, column in self.columns.items()}

    def has(self, *names):
        return all(name in self.columns for name in names)

    def __len__(self):
        return max((len(column.values) for column in self.columns.values()), default=0)


@dataclass(frozen=True)
class Metric:
    name: str
    value: float
    dimension: str
    meaning: str


@dataclass(frozen=True)
class Check:
    """A metric held against a target; `kind` is "verification" (must hold) or "claim" (is what was published true?)."""

    metric: str
    kind: str
    measured: float
    target: float
    tolerance: float  # absolute, in the metric's dimension
    tolerance_text: str
    reason: str
    error: float
    margin: float  # error / tolerance; its inverse where the statement holds outside
    holds: str  # within or outside the tolerance of the target
    verdict: str  # pass, fail, finding
    reference: str
    target_kind: str
    source: str
    claim: str
    statement: str
    # Half-widths whose root of the sum of squares is the tolerance; no numbers where a tolerance was stated.
    uncertainty_reference: float = math.nan
    uncertainty_numerical: float = math.nan
    uncertainty_input: float = math.nan

    @property
    def has_uncertainty(self):
        return not math.isnan(self.uncertainty_reference)


@dataclass(frozen=True)
class Reference:
    """What a check was held against, and where that comes from."""

    id: str
    kind: str
    source: str
    obtained: str
    command: str
    sha256: str
    columns: Record


@dataclass(frozen=True)
class Result:
    """One result file. Rows of `assumed`, `built`, `parts`, `left_out` and `timing` are dicts keyed by the columns of the schema."""

    file: Path
    id: str  # of the case, and what was set if it was changed
    case_id: str
    variant: str  # what was changed by --set; empty for the case as it stands
    title: str
    question: str
    equation: str
    driver: str
    tier: str
    topics: list[str]
    sources: list[str]
    verdict: str
    findings: int
    error_kind: str
    error_message: str
    warnings: list[str]
    case_text: str
    case_path: str
    overrides: list[str]
    assumed: list[dict]
    built: list[dict]
    parts: list[dict]
    left_out: list[dict]
    provenance: dict[str, str]
    records: dict[str, Record]
    metrics: list[Metric]
    checks: list[Check]
    references: list[Reference]
    timing: list[dict]

    def metric(self, name):
        """Value of a metric, None where the case has no such metric."""
        return next((metric.value for metric in self.metrics if metric.name == name), None)

    def record(self, name):
        """A record by its name; KeyError names those that there are."""
        if name not in self.records:
            raise KeyError(f"{self.id} has no record '{name}', but: {', '.join(self.records) or 'none'}")
        return self.records[name]


@dataclass(frozen=True)
class Unreadable:
    """A file of the results folder that could not be read, and the message that says why."""

    file: Path
    message: str


def plain(value):
    """HDF5 value as str, int, float, list or numpy array of numbers."""
    if isinstance(value, h5py.Empty):
        return []
    if isinstance(value, str):  # bytes that are no UTF-8 came as surrogates
        return value.encode("utf-8", "surrogateescape").decode("utf-8", "replace")
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    if isinstance(value, np.ndarray) and value.dtype.kind in "OSU":
        return [plain(item) for item in value.ravel().tolist()]
    if isinstance(value, np.generic):
        return plain(value.item())
    return value


def attributes(node):
    return {name: plain(value) for name, value in node.attrs.items()}


def table(group, of=lambda name, data: plain(data[()])):
    """Columns of a table by name, in the order that the table states; `of` says what is wanted of each."""
    columns = {name: group[name] for name in (plain(group.attrs["columns"]) if "columns" in group.attrs else group)}
    if len({data.shape for data in columns.values()}) > 1:
        raise ValueError(f"the columns of {group.name} differ in length")
    return {name: of(name, data) for name, data in columns.items()}


def rows(file, place):
    """Rows of a table as dicts; none for a table that the file lacks (a run that ended in an error)."""
    if place not in file:
        return []
    columns = table(file[place])
    return [dict(zip(columns, row)) for row in zip(*(np.asarray(values).tolist() for values in columns.values()))]


def typed(kind, row):
    """A row as a dataclass whose texts are texts and whose numbers are numbers."""
    for field in fields(kind):
        if not isinstance(row.get(field.name, field.default), field.type):
            raise TypeError(f"{field.name} is no {field.type.__name__}")
    return kind(**row)


def column(name, data):
    stated = attributes(data)
    described = {key: stated.get(key, "") for key in ("symbol", "dimension", "meaning")}
    return Column(name=plain(name), values=np.asarray(plain(data[()])), **described)


def record(group, name):
    return Record(name=plain(name), title=plain(group.attrs.get("title", "")), columns=table(group, column))


def reference(group, name):
    stated = attributes(group)
    return Reference(
        id=plain(name),
        **{key: stated.get(key, "") for key in ("kind", "source", "obtained", "command", "sha256")},
        columns=record(group, name),
    )


def read(file, path):
    """Values of an open result file."""
    top = attributes(file)
    case = attributes(file["case"]) if "case" in file else {}
    return Result(
        file=path,
        **{key: top[key] for key in ("id", "title", "question", "equation", "driver", "tier", "verdict")},
        case_id=top.get("case_id", top["id"]),
        variant=top.get("variant", ""),
        topics=list(top["topics"]),
        sources=list(top["sources"]),
        findings=int(top["findings"]),
        error_kind=top.get("error_kind", ""),
        error_message=top.get("error_message", ""),
        warnings=list(top.get("warnings", [])),
        case_text=plain(file["case"][()]) if "case" in file else "",
        case_path=case.get("path", ""),
        overrides=list(case.get("overrides", [])),
        assumed=rows(file, "assumed"),
        built=rows(file, "plan/built"),
        parts=rows(file, "parts"),
        left_out=rows(file, "plan/left_out"),
        provenance={key: str(value) for key, value in attributes(file["provenance"]).items()},
        records={name: record(group, name) for name, group in file.get("records", {}).items()},
        metrics=[typed(Metric, row) for row in rows(file, "metrics")],
        checks=[typed(Check, row) for row in rows(file, "checks")],
        references=[reference(group, name) for name, group in file.get("references", {}).items()],
        timing=rows(file, "timing"),
    )


def check_seal(path):
    """Raises UnreadableResult unless the file is one of veriflex and whole: damage crashes the HDF5 library."""
    again = "Run the case again, or remove the file"
    if not stat.S_ISREG(path.stat().st_mode):  # a pipe would be waited for
        raise UnreadableResult(f"{path}: no file (a folder, pipe or device). Remove it")
    with path.open("rb") as file:
        seal = file.read(SEAL)
        if not seal.startswith(FORMAT.encode() + b"\n"):
            raise UnreadableResult(
                f"{path}: no checksum in front (no result of veriflex, or one of an earlier version). {again}"
            )
        words = dict(line.split(b" ", 1) for line in seal.split(b"\n") if b" " in line)
        size = path.stat().st_size - SEAL
        whole = len(seal) == SEAL and words.get(b"bytes") == str(size).encode()
        if not whole or words.get(b"sha256") != hashlib.file_digest(file, "sha256").hexdigest().encode():
            raise UnreadableResult(f"{path}: does not match its checksum (damaged or truncated). {again}")


def load(path):
    """Result file as a Result; UnreadableResult names the file, what is wrong and what to do."""
    path = Path(path)
    again = "Run the case again"
    try:
        check_seal(path)
        with h5py.File(path, "r") as file:
            form, schema = plain(file.attrs.get("format", "")), plain(file.attrs.get("schema", 0))
            if form != FORMAT:
                raise UnreadableResult(
                    f'{path}: not a result of veriflex (attribute format is "{form}", not "{FORMAT}"). '
                    "Move it out of the results folder"
                )
            if schema != SCHEMA:
                raise UnreadableResult(
                    f"{path}: schema {schema} (this script reads schema {SCHEMA}). "
                    "Use the script of the revision that wrote the file, or run the case again"
                )
            return read(file, path)
    except UnreadableResult:
        raise
    except FileNotFoundError as problem:
        raise UnreadableResult(f"{path}: cannot be read (a link to nothing). Remove it") from problem
    except PermissionError as problem:
        raise UnreadableResult(f"{path}: cannot be read ({problem.strerror}). Change its permissions") from problem
    except OSError as problem:
        raise UnreadableResult(f"{path}: damaged or truncated ({problem}). {again}") from problem
    except Exception as problem:  # whatever a file may hold, it is one row of the report and not its end
        why = problem.args[0] if problem.args else type(problem).__name__
        raise UnreadableResult(f"{path}: not as schema {SCHEMA} says ({why}). {again}") from problem


def load_folder(folder):
    """All results of a folder by id; UnreadableResult where one is none."""
    return {result.id: result for result in map(load, files(folder))}


def factor(dimension, *, mass, length, time):
    """What a number of that dimension ("M L^-1 T^-2") in lattice units is to be multiplied with, where the units of mass, length and
    time are so much in the units wanted; 1 for a pure number. ValueError for anything else.
    """
    unit = {"M": mass, "L": length, "T": time}
    product = 1.0
    for part in dimension.split():
        base, _, power = part.partition("^")
        if base not in unit and part != "1":
            raise ValueError(f"'{dimension}' is no dimension (powers of M, L and T with spaces between). Give that of a column")
        product *= unit.get(base, 1.0) ** float(power or 1)
    return product


def read_file(path):
    """The Result of a file, or why there is none."""
    try:
        return load(path)
    except UnreadableResult as problem:
        return Unreadable(path, plain(str(problem)))


def files(folder):
    """All *.h5 of a folder, sorted by the stems of their names."""
    return sorted(Path(folder).glob("*.h5"), key=lambda path: path.stem)


def fingerprint(path):
    """Text that changes with the content of a file; of one that is no whole result, with its size and date."""
    try:
        state = path.stat()
        if stat.S_ISREG(state.st_mode):
            with path.open("rb") as file:
                if f"\nbytes {state.st_size - SEAL}\n".encode() in file.read(SEAL):
                    return hashlib.file_digest(file, "sha256").hexdigest()
        return f"odd {state.st_mode} {state.st_size} {state.st_mtime_ns}"
    except OSError as problem:
        return str(problem)
