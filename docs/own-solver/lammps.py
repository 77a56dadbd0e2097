#!/usr/bin/python3
"""A CSV table of what LAMMPS wrote: thermodynamic output (a log) or a dump in text.

Usage: lammps.py FILE NAME=EXPRESSION ... [--where CONDITION] > table.csv

Expressions and the condition are numpy's, of the names that LAMMPS gives its columns, without `v_`, `c_`, `f_`, and of
`step`: stress=-Pzz, load=load/20.5**2. Rows whose condition holds are kept.
"""

import re
import sys

import numpy as np


def blocks(lines):
    """Header and rows of each table, of a log or a dump; the steps of a dump's frames become a column."""
    header, rows, step = None, [], None
    for number, line in enumerate(lines):
        words = line.split()
        if words[:1] == ["Step"] or words[:2] == ["ITEM:", "ATOMS"]:
            header = words if words[0] == "Step" else ["Step", *words[2:]]
        elif words[:2] == ["ITEM:", "TIMESTEP"]:
            header, step = None, lines[number + 1]
        elif words[:1] == ["Loop"]:
            header = None
        elif header and re.match(r"[-+]?[0-9.]", line.strip()):  # not one of the warnings between rows
            rows.append(dict(zip(header, ([step] if step is not None else []) + words)))
    return rows


def main(file, *words):
    condition = words[words.index("--where") + 1] if "--where" in words else "True"
    wanted = dict(word.split("=", 1) for word in words[: words.index("--where") if "--where" in words else None])
    rows = blocks(open(file, encoding="utf-8").read().splitlines())
    if not rows or not wanted:
        sys.exit(f"lammps.py: no rows in {file}, or no NAME=EXPRESSION. See lammps.py's head")
    names = {re.sub("^[vcf]_", "", name): np.array([row[name] for row in rows], float) for row in rows[:1] for name in row}
    names["step"] = names.pop("Step")
    kept = np.broadcast_to(eval(condition, vars(np), names), len(rows))
    table = [np.broadcast_to(eval(expression, vars(np), names), len(rows))[kept] for expression in wanted.values()]
    print(",".join(wanted))
    print("\n".join(",".join(repr(float(value)) for value in row) for row in zip(*table)))


if __name__ == "__main__":
    main(*sys.argv[1:])
