#!/usr/bin/python3
"""A driven filament in a periodic box, written down from the paper's equations, independent of the C++ code.

Fluid: D3Q15 BGK on two plain lattices; a node's force g adds 3 w_q c_q.g after the collision. Body: a cubic lattice of
nodes around the axis along y, bonds and angles as lists, leap-frog with equal sub-steps. Exchange: F = V (u_f - u_s) at
each node with fewer than six bonds, u_f interpolated with the cosine kernel on 4 x 4 x 4 nodes, u_s half a sub-step old; -F
is spread with the same weights; with --subcycled F follows u_s through the sub-steps and its mean is spread. The node on the axis
at the end of larger y is at z0 sin(omega t). All is double precision in numpy, in no order that the C++ code has.

Usage: filament.py lines [options]      CSV: point, y, z, y_compared, z_compared in the last period; the first law is FENE-LJ
       filament.py swimming [options]   TOML values: displacement of the centre of mass along y in the last period
Phases between two steps are interpolated linearly, as is stated with the scene.
"""
import argparse
import math

import numpy as np

C = np.array([(0, 0, 0)] + [tuple(s * (a == axis) for a in range(3)) for axis in range(3) for s in (1, -1)] +
             [(a, b, c) for a in (1, -1) for b in (1, -1) for c in (1, -1)])
W = np.array([2 / 9] + [1 / 9] * 6 + [1 / 72] * 8)
PHASES = 8


class Fluid:
    """Populations less their weights: what rounding takes is then relative to the flow."""

    def __init__(self, size, tau):
        self.size, self.tau = np.array(size), tau
        self.h = np.zeros((15, *size))

    def moments(self, h):
        density = h.sum(axis=0)
        momentum = np.zeros((3, *h.shape[1:]))
        for q in range(1, 15):
            for axis in range(3):
                if C[q, axis]:
                    momentum[axis] += C[q, axis] * h[q]
        return density, momentum

    def velocity(self, nodes):
        """Of nodes given as three index arrays, without any half step of a force."""
        density, momentum = self.moments(self.h[:, nodes[0], nodes[1], nodes[2]])
        return momentum / (1 + density)

    def step(self, nodes, force):
        """Collide, add the force of these nodes (each may stand there several times), stream."""
        density, momentum = self.moments(self.h)
        rho = 1 + density
        u = momentum / rho
        square = (u * u).sum(axis=0)
        after = np.empty_like(self.h)
        for q in range(15):
            along = sum(C[q, axis] * u[axis] for axis in range(3) if C[q, axis]) if q else 0.0
            rest = W[q] * (density + rho * (3 * along + 4.5 * along * along - 1.5 * square))
            moved = self.h[q] + (rest - self.h[q]) / self.tau
            if q:
                np.add.at(moved, nodes, 3 * W[q] * (force @ C[q]))
            after[q] = np.roll(moved, tuple(C[q]), axis=(0, 1, 2))
        self.h = after


class Harmonic:
    def __init__(self, stiffness, length):
        self.k, self.r0 = stiffness, length

    def tension(self, r):
        return self.k * (r - self.r0)


class FeneLj:
    def __init__(self, eta, sigma):
        self.eta, self.sigma = eta, sigma
        self.k, self.reach, self.cutoff = 30 * eta / sigma**2, 1.5 * sigma, 2**(1 / 6) * sigma

    def tension(self, r):
        assert (r < self.reach).all()
        s = (self.sigma / r)**6
        repulsion = 24 * self.eta / r * (2 * s * s - s)
        return self.k * r / (1 - (r / self.reach)**2) - np.where(r < self.cutoff, repulsion, 0.0)


class Body:
    """Nodes at rest with the free end at y = 0."""

    def __init__(self, radius, sections, law, angle_stiffness, mass):
        reach = range(-int(radius), int(radius) + 1)
        places = [(x, y, z) for y in range(sections) for x in reach for z in reach if x * x + z * z <= radius * radius]
        number = {place: i for i, place in enumerate(places)}
        self.rest = np.array(places, dtype=float)
        self.axis = [number[0, y, 0] for y in range(sections)]
        arms = [[number[tuple(p)] for p in np.array(place) + C[1:7] if tuple(p) in number] for place in places]
        self.bonds = np.array([(i, j) for i, others in enumerate(arms) for j in others if i < j])
        self.angles = np.array([(a, i, b) for i, others in enumerate(arms) for a in others for b in others if a < b])
        a, i, b = self.angles.T
        self.straight = (((self.rest[a] - self.rest[i]) * (self.rest[b] - self.rest[i])).sum(axis=1) < -0.5)
        self.coupled = np.array([i for i, others in enumerate(arms) if len(others) < 6])
        self.law, self.angle_stiffness, self.mass = law, angle_stiffness, mass

    def force(self, x):
        force = np.zeros_like(x)
        i, j = self.bonds.T
        d = x[j] - x[i]
        r = np.sqrt((d * d).sum(axis=1))
        pull = d * (self.law.tension(r) / r)[:, None]
        np.add.at(force, i, pull)
        np.add.at(force, j, -pull)

        first, middle, last = self.angles.T
        a, b = x[first] - x[middle], x[last] - x[middle]
        la, lb = np.sqrt((a * a).sum(axis=1)), np.sqrt((b * b).sum(axis=1))
        dot, cross = (a * b).sum(axis=1), np.sqrt((np.cross(a, b)**2).sum(axis=1))
        deviation = np.where(self.straight, -np.arctan2(cross, -dot), -np.arctan2(dot, cross))
        sine, cosine = cross / (la * lb), dot / (la * lb)
        # At 180 degrees the deviation over the sine is -1.
        ratio = np.where(sine > 1e-7, deviation / np.where(sine > 1e-7, sine, 1.0), -1.0)
        ua, ub = a / la[:, None], b / lb[:, None]
        on_first = (self.angle_stiffness * ratio / la)[:, None] * (ub - cosine[:, None] * ua)
        on_last = (self.angle_stiffness * ratio / lb)[:, None] * (ua - cosine[:, None] * ub)
        np.add.at(force, first, on_first)
        np.add.at(force, last, on_last)
        np.add.at(force, middle, -on_first - on_last)
        return force


def support(markers, size):
    """For each marker its 64 nodes, wrapped, and their weights."""
    lowest = np.floor(markers).astype(int) - 1
    offsets = np.arange(4)
    nodes, weights = [], []
    for axis in range(3):
        at = lowest[:, axis, None] + offsets
        distance = at - markers[:, axis, None]
        nodes.append(at % size[axis])
        weights.append(np.where(np.abs(distance) < 2, (1 + np.cos(np.pi * distance / 2)) / 4, 0.0))
    shape = (len(markers), 4, 4, 4)
    x = np.broadcast_to(nodes[0][:, :, None, None], shape)
    y = np.broadcast_to(nodes[1][:, None, :, None], shape)
    z = np.broadcast_to(nodes[2][:, None, None, :], shape)
    w = weights[0][:, :, None, None] * weights[1][:, None, :, None] * weights[2][:, None, None, :]
    return (x.ravel(), y.ravel(), z.ravel()), w.reshape(len(markers), 64)


class Stroke:
    """The centre line (displacements of the axis) and the centre of mass at each eighth of a period."""

    def __init__(self, options, law):
        nu = (options.tau - 0.5) / 3
        length = options.sections - 1
        omega = options.reynolds * nu / (options.amplitude * length)
        period = 2 * math.pi / omega
        ramp = options.ramp_periods * period

        def drive(time):
            risen = min(1.0, time / ramp) if ramp > 0 else 1.0
            return risen * options.amplitude * math.sin(omega * time)

        body = Body(options.radius, options.sections, law, options.angle_stiffness, options.node_mass)
        fluid = Fluid(options.box, options.tau)
        origin = np.array([n // 2 for n in options.box], dtype=float) + np.array(options.offset)
        origin[1] -= length / 2
        driven = body.axis[-1]
        h = 1.0 / options.substeps
        x = body.rest.copy()
        v = -0.5 * h / body.mass * body.force(x)  # at rest now, half a sub-step ago it was not
        self.lines, self.centres = [], []
        step = 0
        while len(self.lines) < PHASES * options.periods:
            nodes, weights = support(origin + x[body.coupled], fluid.size)
            u = fluid.velocity(nodes).reshape(3, len(body.coupled), 64)
            wanted = (u * weights).sum(axis=2).T
            exchanged = options.marker_volume * (wanted - v[body.coupled])
            mean = np.zeros_like(exchanged)
            before = x.copy()
            for i in range(1, options.substeps + 1):
                if options.subcycled:
                    exchanged = options.marker_volume * (wanted - v[body.coupled])
                mean += exchanged / options.substeps
                force = body.force(x)
                force[body.coupled] += exchanged
                v += h / body.mass * force
                v[driven, 2] = (drive(step + i * h) - (x[driven, 2] - body.rest[driven, 2])) / h
                x = x + h * v
            spread = (-mean[:, None, :] * weights[:, :, None]).reshape(-1, 3)
            fluid.step(nodes, spread)
            step += 1
            while len(self.lines) < PHASES * options.periods and (len(self.lines) + 1) * period / PHASES <= step:
                part = (len(self.lines) + 1) * period / PHASES - (step - 1)
                between = (1 - part) * before + part * x - body.rest
                self.lines.append(between[body.axis])
                self.centres.append(between.mean(axis=0))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["lines", "swimming", "all"])
    parser.add_argument("--box", type=int, nargs=3, required=True)
    parser.add_argument("--radius", type=float, required=True)
    parser.add_argument("--sections", type=int, required=True)
    parser.add_argument("--amplitude", type=float, required=True)
    parser.add_argument("--reynolds", type=float, required=True)
    parser.add_argument("--tau", type=float, default=1.0)
    parser.add_argument("--node-mass", type=float, default=1.0)
    parser.add_argument("--marker-volume", type=float, default=1.0)
    parser.add_argument("--substeps", type=int, default=4)
    parser.add_argument("--subcycled", action="store_true")
    parser.add_argument("--periods", type=int, default=1)
    parser.add_argument("--ramp-periods", type=float, default=0.0)
    parser.add_argument("--offset", type=float, nargs=3, default=[0.0, 0.0, 0.0])
    parser.add_argument("--angle-stiffness", type=float, default=0.025)
    parser.add_argument("--law", choices=["both", "harmonic", "fene-lj"], default="both")
    options = parser.parse_args()
    laws = {"fene-lj": FeneLj(0.000287, 1.0407), "harmonic": Harmonic(0.26, 1.0)}
    if options.what == "all":
        print("law,phase,section,y,z,centre_y")
        for name in laws if options.law == "both" else [options.law]:
            stroke = Stroke(options, laws[name])
            for k, (line, centre) in enumerate(zip(stroke.lines, stroke.centres)):
                for section, place in enumerate(line):
                    print(f"{name},{k + 1},{section},{section + place[1]:.15g},{place[2]:.15g},{centre[1]:.15g}")
        return
    first, other = (Stroke(options, law) for law in laws.values())
    if options.what == "swimming":
        for name, stroke, law in (("swum", first, "FENE-LJ"), ("swum_compared", other, "harmonic")):
            start = stroke.centres[-1 - PHASES][1] if len(stroke.centres) > PHASES else 0.0
            print(f'[values.{name}]\nvalue = {stroke.centres[-1][1] - start:.15g}\ndimension = "L"\n'
                  f'meaning = "displacement of the centre of mass along y in the last period, {law}"\n')
        return
    print("point,y,z,y_compared,z_compared")
    point = 0
    for line, compared in zip(first.lines[-PHASES:], other.lines[-PHASES:]):
        for section, (a, b) in enumerate(zip(line, compared)):
            print(f"{point},{section + a[1]:.15g},{a[2]:.15g},{section + b[1]:.15g},{b[2]:.15g}")
            point += 1


if __name__ == "__main__":
    main()
