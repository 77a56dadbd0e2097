/// What a bond law means for the solid built of it: rest length, stiffness, Young's modulus, and how far they
/// hold.
/// [wu-qi-2014, Eqs. 21-25, Appendix A]
///
/// A cubic lattice of bonds with one chain per area r_eq^2 has, at rest, C11 = E = U''(r_eq)/r_eq and C12 =
/// 0. Strain is r/r_eq - 1; stress is tension per undeformed area r_eq^2.
#pragma once

#include <optional>
#include <vector>

#include "base/root.hpp"
#include "bond/laws.hpp"

namespace veriflex::bond {

/// Strains around 0 (connected) in which a modulus stays within `tolerance` of its value at rest. An end is
/// the law's own limit (-1 for a length of zero, infinity) where no deviation occurs before it.
struct Validity {
  double tolerance;
  Interval secant;   // stress / (E strain)
  Interval tangent;  // U''(r) / U''(r_eq)
};

/// A length at which the law's stiffness jumps.
struct Kink {
  double length;         // [L]
  double strain;         // [1]
  double tension_jump;   // dU/dr above - below  [M L T^-2]
  double tangent_below;  // U''(r)/U''(r_eq), one-sided limits  [1]
  double tangent_above;
};

struct Derivation {
  double rest_length;                           // r_eq: U'(r_eq) = 0               [L]
  double stiffness;                             // U''(r_eq)                        [M T^-2]
  double force_per_strain;                      // -dF/d(strain) = U''(r_eq) r_eq   [M L T^-2]
  double young_modulus;                         // E = U''(r_eq)/r_eq               [M L^-1 T^-2]
  std::optional<double> stiffness_over_fene_k;  // U''(r_eq)/K for a law with a `fene_k`  [1]
  std::optional<double> strain_at_r_max;        // where the longest length is reached          [1]
  double min_tangent_ratio;        // infimum of U''(r)/U''(r_eq) in tension, one-sided limits included  [1]
  double min_tangent_strain;       // where                                                             [1]
  std::vector<Kink> kinks;         // those in tension or compression that the domain contains
  std::vector<Validity> validity;  // for 1, 5 and 10 %
  double smooth_radius;            // distance from r_eq to the nearest kink or limit of the law  [L]
  /// gsl_deriv_central of the tension at r_eq, an independent check of U''; not a number where the law
  /// changes within so short a distance of r_eq that doubles cannot resolve it.
  Derivative stiffness_by_differences;
};

/// Rest length by bracketing and Brent's method, polished by Newton's to round-off; the rest follows from it.
/// Scaling the law by powers of two changes no dimensionless result by a bit.
/// Throws BadParameter when the law has no rest length (a cut-off below it), NumericalFailure when its
/// numbers leave double precision.
Derivation derive(const AnyLaw& law);

/// The lengths at which the search for the rest length asks for the tension, in that order. Throws as
/// derive() does.
std::vector<double> rest_length_search(const AnyLaw& law);

/// -dF/d(strain) and E if r were the rest length: what a rounded r_eq gives.
struct AtLength {
  double force_per_strain;  // U''(r) r  [M L T^-2]
  double young_modulus;     // U''(r)/r  [M L^-1 T^-2]
};
AtLength derive_at(const AnyLaw& law, double length);

struct Calibration {
  AnyLaw law;
  double angle_stiffness;  // k_a = r0^3 E / (8 (1 + nu))  [M L^2 T^-2]
  Derivation derivation;   // of that law
};

/// The law shaped like `prototype` (given in any units) with Young's modulus `young` [M L^-1 T^-2] at rest
/// length `spacing` [L], and the angle stiffness that gives the lattice the shear modulus G = 4 k_a/r0^3 =
/// E/(2 (1 + nu)). nu is Poisson's ratio in the shear sense only: the lattice's lateral contraction is zero.
/// Throws BadParameter (parameters "young", "spacing", "poisson"), also where a parameter of the law or k_a
/// would leave the range in which doubles carry all their digits.
Calibration calibrate(const AnyLaw& prototype, double young, double spacing, double poisson);

}  // namespace veriflex::bond
