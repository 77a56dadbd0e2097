#!/usr/bin/python3
"""Plane waves of the D3Q15 BGK lattice in high precision, by mpmath, independent of the C++ code.

A wave exp(i k.x) is multiplied per step by an eigenvalue of S A, with S = diag(exp(-i k.c_q)) for the streaming and
A_qp = (1 - 1/tau) delta_qp + (1/tau) w_q (1 + 3 c_q.c_p) for the collision, linearised around rest.

Usage: lattice_wave.py constants KIND DIRECTION     CSV: tau, C of value/continuum = 1 + C |k|^2 + ... for long waves
       lattice_wave.py eigenvalue KIND DIRECTION TAU N     the eigenvalue itself, k = 2 pi/N along DIRECTION
KIND is sound, or shear-XYZ with the direction of motion: shear-010. DIRECTION: 100, 011; m stands for -1: shear-01m 011.
60 digits are carried, 20 printed.
"""
import sys

from mpmath import arg, eig, exp, log, matrix, mp, mpc, mpf, nstr, pi, sqrt

mp.dps = 60

C = [(0, 0, 0)] + [tuple(s * (a == axis) for a in range(3)) for axis in range(3) for s in (1, -1)]
C += [(a, b, c) for a in (1, -1) for b in (1, -1) for c in (1, -1)]
W = [mpf(2) / 9] + [mpf(1) / 9] * 6 + [mpf(1) / 72] * 8
TAUS = ["0.51", "0.55", "0.6", "0.8", "1", "1.5", "2"]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def direction(text):
    return [{"0": 0, "1": 1, "m": -1}[letter] for letter in text]


def step(k, tau):
    return matrix(
        [[exp(mpc(0, -dot(k, C[q]))) * ((q == p) * (1 - 1 / tau) + W[q] * (1 + 3 * dot(C[q], C[p])) / tau) for p in range(15)]
         for q in range(15)])


def eigenvalue(kind, k, tau):
    """The eigenvalue of the wave whose left eigenvector sees most of the continuum's wave, per its right one."""
    motion = direction(kind.split("-")[1]) if kind != "sound" else k
    scale = sqrt(dot(motion, motion))
    density = 1 if kind == "sound" else 0
    along = [x / scale * (1 if kind != "sound" else 1 / sqrt(mpf(3))) for x in motion]
    wanted = matrix([W[q] * (density + 3 * dot(C[q], along)) for q in range(15)])
    k2 = dot(k, k)
    nu = (tau - mpf(1) / 2) / 3
    guess = exp(mpc(-nu * k2, -sqrt(k2 / 3) if kind == "sound" else 0))
    values, vectors = eig(step(k, tau))
    # Near the continuum's factor, and moving as the continuum's wave does.
    def distance(i):
        moved = [sum(vectors[q, i] * C[q][axis] for q in range(15)) for axis in range(3)]
        size = sqrt(sum(abs(x)**2 for x in moved)) + mpf(10)**-30
        parallel = abs(dot(moved, [x / sqrt(dot(along, along)) for x in along])) / size
        return abs(values[i] - guess) + (10 if parallel < mpf("0.5") else 0)
    return values[min(range(15), key=distance)]


def constants(kind, towards):
    unit = [mpf(x) / sqrt(mpf(dot(towards, towards))) for x in towards]
    names = ["constant_speed", "constant_attenuation"] if kind == "sound" else ["constant_viscosity"]
    print("# " + " ".join(["lattice_wave.py"] + sys.argv[1:]))
    print(",".join(["relaxation_time"] + names))
    small = mpf(10)**-6
    for text in TAUS:
        tau = mpf(text)
        k = [small * x for x in unit]
        factor = eigenvalue(kind, k, tau)
        damping = (-log(abs(factor)) / ((tau - mpf(1) / 2) / 3 * small**2) - 1) / small**2
        speed = (-arg(factor) / (small / sqrt(mpf(3))) - 1) / small**2
        found = [speed, damping] if kind == "sound" else [damping]
        print(",".join([text] + [nstr(mp.chop(x, mpf(10)**-9), 10) for x in found]))


kind, towards = sys.argv[2], direction(sys.argv[3])
if sys.argv[1] == "constants":
    constants(kind, towards)
else:
    n = mpf(sys.argv[5])
    value = eigenvalue(kind, [2 * pi * x / n for x in towards], mpf(sys.argv[4]))
    print(nstr(value, 20))
