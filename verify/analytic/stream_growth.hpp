/// How fast small perturbations of a uniform stream grow: the linear stability of the scheme itself.
///
/// Around a stream each wave of a periodic box changes by a 15 x 15 matrix of its own (one_step); the largest
/// of the moduli of all their eigenvalues is the factor by which the worst perturbation grows per step. It is
/// never below 1: mass and momentum are kept.                                      [sterling-chen-1996]
#pragma once

#include "analytic/lattice_wave.hpp"
#include "base/grid.hpp"

namespace veriflex::analytic {

struct GrowingWave {
  double factor;                      // by which a step multiplies it, its modulus  [1]
  std::array<std::int64_t, 3> waves;  // in the box, along each axis, from -n/2 + 1 to n/2
};

/// Of the waves that a periodic box of that size holds, the one that grows fastest on the stream; the first
/// of several. Throws NumericalFailure when eigenvalues are not found.
GrowingWave fastest_wave(const Grid& box, double relaxation_time, const Vec3& stream);

}  // namespace veriflex::analytic
