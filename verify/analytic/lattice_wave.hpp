/// Plane waves of the D3Q15 BGK fluid, exactly as the lattice has them.
///
/// Small deviations from rest, or from a uniform stream U, obey h(x + c, t + 1) = [(1 - omega) + omega P] h
/// with P the derivative of the local equilibrium. For h = a exp(i k.x) one step is the product with a 15 x
/// 15 matrix, whose eigenvalues are the factors by which the lattice's own waves change per step: the exact
/// discrete answer at any resolution, which the continuum's exp(-nu k^2) and exp(-nu k^2 - i k/sqrt(3))
/// only approach.                                                                  [lallemand-luo-2000]
#pragma once

#include <Eigen/Core>
#include <complex>

#include "base/vec.hpp"
#include "fluid/lattice.hpp"

namespace veriflex::analytic {

using Complex = std::complex<double>;
using ComplexPopulations = Eigen::Matrix<Complex, fluid::Q, 1>;

/// Density and momentum of a wave in the continuum, which tells which of the fifteen is meant: (0, a vector
/// across k) for shear, (1, k/(sqrt(3) |k|)) for sound that travels along k.
struct ContinuumWave {
  double density;
  Vec3 momentum;
};

struct LatticeWave {
  Complex factor;                 // by which a step multiplies the wave
  ComplexPopulations shape;       // of the arriving populations; a unit of the continuum's wave put into it
  ComplexPopulations projection;  // left eigenvector: projection . shape = 1, and 0 for every other wave

  double decay_rate() const { return -std::log(std::abs(factor)); }  // [T^-1]
  double angular_frequency() const { return -std::arg(factor); }     // [T^-1]
};

/// The matrix of one step on the arriving populations of a wave exp(i k.x).
Eigen::Matrix<Complex, fluid::Q, fluid::Q> one_step(const Vec3& k, double relaxation_time,
                                                    const Vec3& stream = Vec3::Zero());

/// The wave, or the one of two with the same factor, that is most like the continuum's. k: radians per node.
LatticeWave lattice_wave(const Vec3& k, double relaxation_time, const ContinuumWave& like,
                         const Vec3& stream = Vec3::Zero());

}  // namespace veriflex::analytic
