#!/usr/bin/python3
"""CSV tables of what T. Krueger's 2D immersed boundary lattice Boltzmann code wrote at its last step.

Usage: iblbm.py FOLDER profile > table.csv     velocity along the channel, mean over its length, against the height
       iblbm.py FOLDER balance NU G > table.csv    (friction of both walls + drag of the cylinder) / (G times the fluid's area)
"""

import sys
from pathlib import Path

import numpy as np


def last_field(folder):
    """Heights of the nodes above the lower wall, and the velocity along x by height and x."""
    file = max(Path(folder, "vtk_fluid").glob("fluid_t*.vtk"), key=lambda path: int(path.stem.removeprefix("fluid_t")))
    lines = file.read_text().splitlines()
    start = {line.split()[0]: number for number, line in enumerate(lines) if line[:1].isalpha()}
    nx, ny = map(int, lines[start["DIMENSIONS"]].split()[1:3])
    vectors = lines[start["VECTORS"] + 1 : start["VECTORS"] + 1 + nx * ny]
    velocity = np.array([line.split()[0] for line in vectors], float).reshape(ny, nx)
    return np.array(lines[start["Y_COORDINATES"] + 1].split(), float), velocity


def balance(folder, nu, g):
    """Half a spacing from a wall u = s/2 - g/(8 nu), where s is the slope at the wall: no body is near it."""
    y, velocity = last_field(folder)
    mean = velocity.mean(axis=1)
    friction = nu * velocity.shape[1] * sum(2 * (u + g / (8 * nu)) for u in (mean[0], mean[-1]))
    drag = -float(Path(folder, "data.dat").read_text().splitlines()[-1].split()[1])
    return (friction + drag) / (g * velocity.size)


if __name__ == "__main__":
    if sys.argv[2] == "balance":
        print(f"momentum_balance\n{balance(sys.argv[1], float(sys.argv[3]), float(sys.argv[4]))!r}")
    else:
        print("y,velocity")
        for height, row in zip(*last_field(sys.argv[1])):
            print(f"{float(height)!r},{float(row.mean())!r}")
