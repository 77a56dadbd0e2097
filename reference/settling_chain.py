#!/usr/bin/python3
"""A chain of markers that settles across its axis in a periodic box of D3Q15 BGK fluid: how fast, and how it bends.

Small deflections of a chain without inertia, written down from the equations and not from the program. Markers stand on
neighbouring nodes along x. A force on one moves the others by what the lattice answers to it, wave by wave: steady
populations f obey exp(i k.c) f = (1 - 1/tau) f + f_eq/tau + 3 w c.F, the velocity is sum f c, and interpolation and
spreading have 1/4, 1/2, 1/4 along each axis at a node. Each marker is faster than the fluid at it by its force over V
(F = V (u_f - u_s)). All move alike, so the drag is larger at the ends; weight less drag bends the chain, whose angles
have the stiffness B. The middle node is held, where there is nothing to hold once the fluid streams past as fast as the
chain would settle.
"""

import argparse

import numpy as np

c = np.array([[0, 0, 0], *([s * (a == i) for a in range(3)] for i in range(3) for s in (1, -1)),
              *([x, y, z] for x in (1, -1) for y in (1, -1) for z in (1, -1))])
w = np.array([2 / 9] + [1 / 9] * 6 + [1 / 72] * 8)


def mobility(side, tau, markers):
    """Velocity along z of a marker per force along z on another, by their distance along x."""
    k = 2 * np.pi * np.arange(-((side - 1) // 2), (side - 1) // 2 + 1) / side  # the kernel lets nothing of k = pi
    kernel = ((1 + np.cos(k)) / 2) ** 2
    collision = (1 - 1 / tau) * np.eye(15) + w[:, None] * (1 + 3 * c @ c.T) / tau
    y, z = (grid.ravel() for grid in np.meshgrid(k, k, indexing="ij"))
    weight = np.outer(kernel, kernel).ravel()
    distance, answer = np.arange(markers), np.zeros(markers)
    for x, of_x in zip(k, kernel):
        phase = np.exp(1j * (x * c[:, 0] + np.outer(y, c[:, 1]) + np.outer(z, c[:, 2])))
        matrix = phase[:, :, None] * np.eye(15) - collision
        matrix[(x == 0) & (y == 0) & (z == 0)] = np.eye(15)
        u = np.linalg.solve(matrix, np.broadcast_to((3 * w * c[:, 2])[:, None], (len(y), 15, 1)))[:, :, 0] @ c[:, 2]
        u[(x == 0) & (y == 0) & (z == 0)] = 0  # the box as a whole is at rest
        answer += of_x * (weight @ u * np.exp(1j * x * distance)).real
    return answer / side**3


def settle(side, tau, volume, nodes, speed, number):
    """Weight of a node, stiffness B and displacement of each node; W L^2/B = number."""
    m = mobility(side, tau, nodes)
    m[0] += 1 / volume
    i = np.arange(nodes)
    drag = np.linalg.solve(m[abs(i[:, None] - i)], np.full(nodes, speed))
    weight = drag.sum() / nodes
    stiffness = drag.sum() * (nodes - 1) ** 2 / number
    bend = np.zeros((nodes - 2, nodes))
    for row in range(nodes - 2):
        bend[row, row : row + 3] = (1, -2, 1)
    up = np.linalg.lstsq(stiffness * bend.T @ bend, drag - weight, rcond=None)[0]
    return weight, stiffness, up - up[nodes // 2]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=int, default=24, help="of the box")
    parser.add_argument("--tau", type=float, default=1.0)
    parser.add_argument("--volume", type=float, default=8.0, help="V of a marker")
    parser.add_argument("--nodes", type=int, default=17)
    parser.add_argument("--speed", type=float, default=1e-3)
    parser.add_argument("--number", type=float, default=2.5, help="W L^2/B")
    given = parser.parse_args()
    weight, stiffness, up = settle(given.side, given.tau, given.volume, given.nodes, given.speed, given.number)
    print(f"# weight of a node {weight:.15g}, B = k_a {stiffness:.15g}, settles with {given.speed:.15g}")
    print("node,z")
    for node, z in enumerate(up):
        print(f"{node},{z:.12f}")
