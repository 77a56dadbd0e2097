#!/usr/bin/python3
"""Mean thrust of a slender elastic filament that is driven at one end, over that of an endless one.

xi_perp w_t = - B w'''' in units of l = (B/(xi_perp omega))^(1/4), driven in one of three ways: hinged (w = 1, w'' = 0),
clamped (w = 1, w' = 0) or turned (w = 0, w' = 1) at s = 0, free at s = Sp. By finite elements, cubic in each, and not by the
exponentials that solve it in closed form, so that both check each other: what a mesh of half as many elements gives differs by
less than the last digit that is printed.
"""

import numpy as np

GAUSS = np.polynomial.legendre.leggauss(4)
UNIT = {"hinged": 1 / (4 * 2**0.5), "clamped": 1 / 4, "angle": (2 - 2**0.5) / 4}


def shapes(t, h):
    """Cubic shapes of displacement and slope at both ends of an element, 0 <= t <= 1, and their derivatives by s."""
    value = np.array([1 - 3 * t**2 + 2 * t**3, h * (t - 2 * t**2 + t**3), 3 * t**2 - 2 * t**3, h * (t**3 - t**2)])
    slope = np.array([6 * (t**2 - t) / h, 1 - 4 * t + 3 * t**2, 6 * (t - t**2) / h, 3 * t**2 - 2 * t])
    bend = np.array([(12 * t - 6) / h**2, (6 * t - 4) / h, (6 - 12 * t) / h**2, (6 * t - 2) / h])
    return value, slope, bend


def thrust(drive, sperm_number, elements):
    h = sperm_number / elements
    mass, stiffness, pushes = np.zeros((4, 4)), np.zeros((4, 4)), np.zeros((4, 4))
    for place, weight in zip(*GAUSS):
        value, slope, bend = shapes((place + 1) / 2, h)
        mass += weight * h / 2 * np.outer(value, value)
        stiffness += weight * h / 2 * np.outer(bend, bend)
        pushes += weight * h / 2 * np.outer(value, slope)
    size = 2 * elements + 2
    balance, along = np.zeros((size, size), complex), np.zeros((size, size))
    for e in range(elements):
        part = slice(2 * e, 2 * e + 4)
        balance[part, part] += stiffness + 1j * mass
        along[part, part] += pushes
    held = [0] if drive == "hinged" else [0, 1]
    w = np.zeros(size, complex)
    w[1 if drive == "angle" else 0] = 1
    free = [i for i in range(size) if i not in held]
    w[free] = np.linalg.solve(balance[np.ix_(free, free)], -balance[np.ix_(free, held)] @ w[held])
    return -0.5 * (1j * w @ along @ w.conj()).real / UNIT[drive]


if __name__ == "__main__":
    print("# Y = F over that of an endless filament")
    print("sperm_number," + ",".join(UNIT))
    for sperm_number in np.arange(1.0, 8.25, 0.5):
        row = [[thrust(drive, sperm_number, int(n * sperm_number)) for drive in UNIT] for n in (20, 40)]
        assert np.allclose(*row, rtol=0, atol=5e-7), (sperm_number, row)
        print(f"{sperm_number:g}," + ",".join(f"{y:.6f}" for y in row[1]))
