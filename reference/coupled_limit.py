#!/usr/bin/python3
"""What the explicit coupling carries, apart from veriflex: the eigenvalues of a dense matrix of one step.

A rod (nodes with x^2 + z^2 <= radius^2 on sections along y a spacing apart, the z of its last section given) or a free
sheet, of the lattice's bonds k and angles k_a between the bonds of a node, straight and right, linearised at rest. A state is (f, v, W): elastic
forces, velocities half a sub-step old, and the fluid's velocity at the coupled nodes. A step takes F = V (W - v), makes n
sub-steps of leap-frog with it (frozen, or following them), and leaves W - A mean(F), A_ij = sum_x D(x - X_i) D(x - X_j)
with the cosine kernel on the cube: the fluid keeps what it is given where it is given it.

    coupled_limit.py stiffness|density|spacing      prints the values of coupled-limit-<that>.toml
"""

import itertools
import sys

import numpy as np


def rod(radius, sections):
    """Number of each site; the axis is y."""
    n = int(radius)
    cut = [(a, b) for a in range(-n, n + 1) for b in range(-n, n + 1) if a * a + b * b <= radius * radius]
    return {site: number for number, site in enumerate((a, j, b) for j in range(sections) for a, b in cut)}


def sheet(n):
    return {site: number for number, site in enumerate(itertools.product(range(n), range(n), [0]))}


def places(sites, r0, at):
    return r0 * np.array(list(sites), float) + at


STEPS = [np.array(s) for s in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]


def stiffness(sites, r0, k, k_a):
    """The Hessian at rest."""
    n = len(sites)
    rows = []  # (energy = 1/2 row . u)^2, with the root of the stiffness in the row

    def row(entries, weight):
        r = np.zeros((n, 3))
        for node, direction in entries:
            r[node] += direction
        rows.append(np.sqrt(weight) * r.ravel())

    for site, i in sites.items():
        arms = []
        for step, sign in itertools.product(STEPS, (1, -1)):
            j = sites.get(tuple(np.array(site) + sign * step))
            if j is not None:
                arms.append((j, sign * step))
                if sign == 1:
                    row([(j, step), (i, -step)], k)
        for (j, d), (l, e) in itertools.combinations(arms, 2):
            if d @ e == 0:
                row([(j, e / r0), (l, d / r0), (i, -(d + e) / r0)], k_a)
            else:
                for across in STEPS:
                    if across @ d == 0:
                        row([(j, across / r0), (l, across / r0), (i, -2 * across / r0)], k_a)
    B = np.array(rows)
    return B.T @ B


def answered(X):
    """A_ij of markers at X."""
    base = np.floor(X.min(axis=0)).astype(int) - 2
    size = np.ceil(X.max(axis=0)).astype(int) + 3 - base
    D = np.zeros((len(X), *size))
    for weights, x in zip(D, X):
        phi = []
        for axis in range(3):
            d = np.arange(size[axis]) + base[axis] - x[axis]
            phi.append(np.where(np.abs(d) < 2, (1 + np.cos(np.pi * d / 2)) / 4, 0))
        weights += np.einsum("i,j,k->ijk", *phi)
    D = D.reshape(len(X), -1)
    return D @ D.T


def growth(K, A, coupled, free, m, V, n, subcycled):
    """Spectral radius of the step."""
    K = K[np.ix_(free, free)]
    N = len(free)
    place = {dof: i for i, dof in enumerate(free)}
    marks = [place.get(3 * node + axis) for node in coupled for axis in range(3)]
    P = np.zeros((len(marks), N))
    for i, dof in enumerate(marks):
        if dof is not None:
            P[i, dof] = 1.0
    A3 = np.kron(A, np.eye(3))
    M = len(marks)
    size = 2 * N + M
    dt = 1.0 / n
    state = np.eye(size)
    f, v, W = state[:N], state[N : 2 * N], state[2 * N :]
    mean = np.zeros((M, size))
    F = V * (W - P @ v)
    for _ in range(n):
        if subcycled:
            F = V * (W - P @ v)
        v = v + dt / m * (f + P.T @ F)
        f = f - dt * (K @ v)
        mean = mean + F / n
    W = W - A3 @ mean
    return np.abs(np.linalg.eigvals(np.vstack([f, v, W]))).max()


def boundary(unstable, low, high, accuracy=2e-4):
    """Where unstable(x) changes between low (stable) and high, on a logarithmic scale."""
    while abs(high / low - 1) > accuracy:
        middle = np.sqrt(low * high)
        low, high = (low, middle) if unstable(middle) else (middle, high)
    return np.sqrt(low * high)


GROWS = 1 + 1e-6  # the freely moving part has factors of 1 exactly, found to some 1e-8


def coupled_nodes(sites, which):
    """`all`, those with a neighbour less than six, or than the four across the axis."""
    across = {"boundary": STEPS, "ring": (STEPS[0], STEPS[2]), "all": ()}[which]
    inside = lambda s: all(tuple(np.array(s) + sign * step) in sites for step in across for sign in (1, -1))
    return [i for s, i in sites.items() if which == "all" or not inside(s)]


def free_of(sites, driven):
    """All coordinates but z of the last section, or of its middle."""
    last = max(s[1] for s in sites)
    held = {i for s, i in sites.items() if s[1] == last and (driven == "section" or (s[0], s[2]) == (0, 0))}
    return [3 * i + axis for i in range(len(sites)) for axis in range(3) if not (axis == 2 and i in held)]


WAYS = ((1, False), (4, False), (4, True), (16, False), (16, True))


def way(n, subcycled):
    return "1" if n == 1 else f"{n}_{'subcycled' if subcycled else 'frozen'}"


def show(name, value, dimension, meaning):
    print(f'[values.{name}]\nvalue = {value:.6g}\ndimension = "{dimension}"\nmeaning = "{meaning}"\n', flush=True)


def filament(which):
    sites = rod(1.0, 11)
    coupled = coupled_nodes(sites, which)
    return stiffness(sites, 1.0, 0.26, 0.025), answered(places(sites, 1.0, [8.0, 5.0, 10.0])[coupled]), coupled, free_of(sites, "section")


def limits_of_stiffness():
    K, A, coupled, free = filament("boundary")
    for n, live in WAYS:
        at = boundary(lambda s: growth(s * K, A, coupled, free, 1.0, 1.0, n, live) > GROWS, 0.05, 2000.0)
        show(f"stiffness_{way(n, live)}", at, "1", "largest stable factor of all stiffnesses")


def limits_of_density():
    for which in ("boundary", "ring", "all"):
        K, A, coupled, free = filament(which)
        for n, live in WAYS:
            at = boundary(lambda m: growth(K, A, coupled, free, m, 1.0, n, live) > GROWS, 100.0, 0.001)
            show(f"density_{which}_{way(n, live)}", at, "M", "least stable node mass")


def limits_of_spacing():
    for text in ("2.0", "1.0", "0.5", "0.25"):
        r0 = float(text)
        sites = sheet(round(2.0 / r0) + 1)
        nodes = list(sites.values())
        K = stiffness(sites, r0, 0.26 * r0, 0.025 * r0**3)
        A = answered(places(sites, r0, [6.3, 5.2, 5.1]))
        for live in (False, True):
            unstable = lambda V: growth(K, A, nodes, range(3 * len(nodes)), r0**3, V, 8, live) > GROWS
            if unstable(1e-3):
                continue
            at = boundary(unstable, 1e-3, 256.0, 1e-3)
            name = f"volume_{text.removesuffix('.0').replace('.', '_')}_{'subcycled' if live else 'frozen'}"
            show(name, at, "L^3", f"largest stable marker volume at a spacing of {text}, 8 sub-steps")


if __name__ == "__main__":
    {"stiffness": limits_of_stiffness, "density": limits_of_density, "spacing": limits_of_spacing}[sys.argv[1]]()
