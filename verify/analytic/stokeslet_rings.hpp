/// Unsteady Stokes flow around a slender body, as rings of oscillating point forces.
#pragma once

#include <complex>

namespace veriflex::analytic {

/// Velocity across the axis, averaged over a ring of that radius and of `width` along the axis, per force
/// across the axis that is spread evenly over another such ring `distance` along the axis away; oscillating
/// as exp(i omega t) in an unbounded fluid of density 1. Midpoint rule over 96 angles and 8 x 8 slices.
///   G = (A/r + B z^2/r^3)/(8 pi nu), R = r sqrt(i omega/nu),
///   A = 2 exp(-R) (1 + 1/R + 1/R^2) - 2/R^2,  B = -2 exp(-R) (1 + 3/R + 3/R^2) + 6/R^2
///                                                             [pozrikidis-1992]  [T M^-1]
std::complex<double> ring_on_ring(double distance, double radius, double width, double omega,
                                  double viscosity);

}  // namespace veriflex::analytic
