/// How fast small perturbations of a scene at rest grow: the spectrum of its step, with all that the fluid
/// does to its momentum between two exchanges.
///
/// coupling_stability leaves streaming and collision out and needs no fluid; here the simulation itself is
/// the operator (SimulatedStep), a Krylov space over some steps at a time finds the eigenvalues of largest
/// magnitude, and none counts without its residual. Known invariants are taken out, so that a stable scene
/// shows what decays slowest.
#pragma once

#include <complex>
#include <vector>

#include "scene/scene.hpp"

namespace veriflex::scene {

struct Eigenvalue {
  std::complex<double> value;  // of one step
  double residual;             // |G x - lambda x| / |x|, in energies
  double bodies;               // share of the bodies in the energy of x
};

struct ExactGrowth {
  double factor;                     // largest |lambda| of a step, where known invariants are taken out
  double residual;                   // of the eigenvalue that it is of
  double resolution;                 // what grows by less than this above 1 might not have been seen
  std::vector<Eigenvalue> spectrum;  // of largest magnitude, those that converged, falling; pairs in full
  std::int64_t steps;                // of the simulation that were made
  bool grows() const { return factor > 1.0 + resolution; }
};

struct GrowthSearch {
  int eigenvalues = 4;       // that must converge
  double resolution = 1e-3;  // wanted
  std::int64_t most_steps = 100'000;
};

/// Of a scene with a fluid, about rest (see SimulatedStep). Throws BadParameter for a scene without fluid or
/// with float populations, and NumericalFailure (NotConverged) when the eigenvalues are not found to their
/// residual or the resolution not reached in that many steps.
ExactGrowth exact_growth(const Scene& scene, const GrowthSearch& search = {});

/// The factor of all node masses at which the growth comes down to 1, to a relative accuracy: the last mass
/// at which it grew, or where the growth would be 1 on the straight line through the last two, if that is
/// nearer than the accuracy. `guess`: where it is looked for first. 0 when the scene is stable down to 1/1000
/// of its masses. Throws NumericalFailure (Coupling) when it is unstable up to 1000 times of them.
double critical_mass_factor(const Scene& scene, double guess, double accuracy,
                            const GrowthSearch& search = {});

}  // namespace veriflex::scene
