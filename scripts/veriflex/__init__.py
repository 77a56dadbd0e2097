"""Result files of veriflex in Python: `docs/READING.md` shows how.

    import veriflex
    result = veriflex.load("results/tensile-fene-lj.h5")
    curve = result.records["tensile"]
    curve["strain"]                       # numpy array
    curve.columns["strain"].dimension     # "1"; stresses have "M L^-1 T^-2"

Needs h5py and numpy. Nothing is judged here: verdicts, errors and margins are those that the files state.
"""

from .results import (
    Check,
    Column,
    Metric,
    Record,
    Reference,
    Result,
    Unreadable,
    UnreadableResult,
    factor,
    load,
    load_folder,
)

__all__ = [
    "Check",
    "Column",
    "Metric",
    "Record",
    "Reference",
    "Result",
    "Unreadable",
    "UnreadableResult",
    "factor",
    "load",
    "load_folder",
]
