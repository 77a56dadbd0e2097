#!/usr/bin/python3
"""High-precision references for the FENE-LJ bond, by mpmath, independent of the C++ code.

  U(r) = -1/2 K R0^2 ln(1 - (r/R0)^2) + 4 eta [(sigma/r)^12 - (sigma/r)^6] for r < Rc, the first term alone beyond.

Usage: fene_lj.py rest-state [--fene-k K] [--r-max R0] [--cutoff RC] [--epsilon ETA] [--sigma SIGMA]   TOML values
       fene_lj.py curve                                       CSV: strain, stress of a bar at given strains
       fene_lj.py load                                        CSV: stress, strain of a bar under given stresses
Everything is in units of eta and sigma unless --epsilon and --sigma are given. 40 digits are carried, 25 printed.
"""
import argparse

from mpmath import diff, findroot, inf, mp, mpf, nstr

mp.dps = 40

# The strains at which the bar is pulled: fine around zero, where the modulus changes fastest.
STRAINS = ["-0.20", "-0.15", "-0.10", "-0.08", "-0.06", "-0.05", "-0.04", "-0.03", "-0.02", "-0.01", "-0.005", "-0.002",
           "-0.001", "-0.0001", "0.0001", "0.001", "0.002", "0.005", "0.01", "0.02", "0.03", "0.04", "0.05", "0.06", "0.08",
           "0.10", "0.12", "0.14", "0.15", "0.16", "0.165", "0.17", "0.18", "0.20", "0.225", "0.25", "0.275", "0.30",
           "0.325", "0.35", "0.375", "0.40", "0.425", "0.45", "0.475", "0.50"]
STRESSES = ["-500", "-100", "-20", "-1", "0.01", "1", "10", "30", "60", "90", "110", "130", "150", "200", "250", "300"]


class Bond:
    """Tension and stiffness of the bond, written as derivatives of its energy by mpmath itself."""

    def __init__(self, epsilon, sigma, fene_k, r_max, cutoff):
        self.eta, self.sigma, self.k, self.r0, self.rc = epsilon, sigma, fene_k, r_max, cutoff

    def energy(self, r, lj=True):
        fene = -self.k * self.r0**2 / 2 * mp.log(1 - (r / self.r0)**2)
        return fene + (4 * self.eta * ((self.sigma / r)**12 - (self.sigma / r)**6) if lj else 0)

    def tension(self, r, lj=None):
        lj = r < self.rc if lj is None else lj
        fene = self.k * r / (1 - (r / self.r0)**2)
        return fene - (24 * self.eta / r * (2 * (self.sigma / r)**12 - (self.sigma / r)**6) if lj else 0)

    def stiffness(self, r, lj=None):
        lj = r < self.rc if lj is None else lj
        return diff(lambda x: self.tension(x, lj), r)

    def rest_length(self):
        return findroot(self.tension, (self.sigma * mpf("0.9"), self.sigma * mpf("1.02")), solver="anderson")


def bond(arguments):
    eta, sigma = mpf(float(arguments.epsilon)), mpf(float(arguments.sigma))
    fene_k = mpf(float(arguments.fene_k)) if arguments.fene_k else 30 * eta / sigma**2
    r_max = mpf(float(arguments.r_max)) if arguments.r_max else mpf("1.5") * sigma
    cutoff = (inf if arguments.cutoff == "inf" else mpf(float(arguments.cutoff))) if arguments.cutoff else mpf(2)**(mpf(1) / 6) * sigma
    return Bond(eta, sigma, fene_k, r_max, cutoff)


def least_tangent(b, rest):
    """Infimum of U''(r)/U''(rest) for r in [rest, r_max), one-sided limits at the cut-off included, and its strain."""
    candidates = []
    if rest < b.rc < b.r0:
        candidates.append(b.rc)
    inner_end = min(b.rc, b.r0)
    grid = [rest + (inner_end - rest) * i / 400 for i in range(1, 400)]
    values = [b.stiffness(r, True) for r in grid]
    i = values.index(min(values))
    if 0 < i < len(grid) - 1:
        candidates.append(findroot(lambda r: diff(lambda x: b.stiffness(x, True), r), grid[i]))
    rows = [(b.stiffness(r, False if r == b.rc else None) / b.stiffness(rest), r / rest - 1) for r in candidates]
    return min(rows + [(mpf(1), mpf(0))])


def departure(b, rest, tolerance, sign, ratio):
    """Strain at which ratio leaves [1 - tolerance, 1 + tolerance] on the side of `sign`."""
    target = 1 - sign * tolerance  # this bond hardens in compression and softens in tension
    return findroot(lambda s: ratio(s) - target, (sign * tolerance * mpf("0.05"), sign * tolerance * mpf("0.2")), solver="anderson")


def print_value(name, value, dimension, meaning):
    print(f'[values.{name}]\nvalue = {nstr(value, 25)}\ndimension = "{dimension}"\nmeaning = "{meaning}"\n')


def rest_state(b):
    rest = b.rest_length()
    k = b.stiffness(rest)
    print_value("rest_length", rest, "L", "r_eq, where the tension vanishes")
    print_value("stiffness", k, "M T^-2", "U''(r_eq)")
    print_value("force_per_strain", k * rest, "M L T^-2", "-dF/d(strain) = U''(r_eq) r_eq")
    print_value("young_modulus", k / rest, "M L^-1 T^-2", "E = U''(r_eq)/r_eq")
    print_value("stiffness_over_fene_k", k / b.k, "1", "U''(r_eq)/K")
    print_value("strain_at_r_max", b.r0 / rest - 1, "1", "strain at which R0 is reached")
    ratio, strain = least_tangent(b, rest)
    print_value("min_tangent_ratio", ratio, "1", "infimum of U''(r)/U''(r_eq) in tension")
    print_value("min_tangent_strain", strain, "1", "strain of that infimum")
    if b.rc < b.r0:
        print_value("tension_jump", b.tension(b.rc, False) - b.tension(b.rc, True), "M L T^-2", "jump of dU/dr at the cut-off")
    secant = lambda s: b.tension(rest * (1 + s)) / (k * rest * s)
    for percent in (1, 5, 10):
        print_value(f"secant_valid_to_{percent}pct", departure(b, rest, mpf(percent) / 100, 1, secant), "1",
                    f"strain up to which stress / (E strain) stays within {percent} %")
        print_value(f"secant_valid_from_{percent}pct", departure(b, rest, mpf(percent) / 100, -1, secant), "1",
                    f"strain down to which stress / (E strain) stays within {percent} %")
    rounded = mpf("0.9609") * b.sigma
    print_value("force_per_strain_at_rounded", b.stiffness(rounded) * rounded, "M L T^-2", "U''(r) r at r = 0.9609 sigma")
    print_value("young_modulus_at_rounded", b.stiffness(rounded) / rounded, "M L^-1 T^-2", "U''(r)/r at r = 0.9609 sigma")


def curve(b):
    rest = b.rest_length()
    print("# stress [eta/sigma^3] on the undeformed section of a bar of FENE-LJ bonds, by mpmath with 40 digits")
    print("strain,stress")
    for text in STRAINS:
        print(f"{text},{nstr(b.tension(rest * (1 + mpf(float(text)))) / rest**2, 25)}")


def load(b):
    rest = b.rest_length()
    print("# strain of a bar of FENE-LJ bonds under a dead stress [eta/sigma^3] on its undeformed section, by mpmath with 40 digits")
    print("stress,strain")
    for text in STRESSES:
        balance = lambda s: b.tension(rest * (1 + s)) / rest**2 - mpf(float(text))
        print(f"{text},{nstr(findroot(balance, (mpf('-0.25'), mpf('0.55')), solver='anderson', tol=mpf(10)**-60), 25)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["rest-state", "curve", "load"])
    for name, default in (("epsilon", "1"), ("sigma", "1"), ("fene_k", None), ("r_max", None), ("cutoff", None)):
        parser.add_argument("--" + name.replace("_", "-"), default=default)
    arguments = parser.parse_args()
    {"rest-state": rest_state, "curve": curve, "load": load}[arguments.what](bond(arguments))


if __name__ == "__main__":
    main()
