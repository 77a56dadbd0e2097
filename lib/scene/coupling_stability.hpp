/// Whether the exchange between a body and the fluid is stable, before the first step.
///
/// One step of body and fluid is a linear map about the undeformed body in a fluid at rest, see CoupledStep.
/// Everything that the fluid does with its momentum (streaming, pressure, viscosity) is left out: W keeps all
/// that it was given. With all coupled nodes alike, one step for the solid and K the stiffness, S the
/// eigenvalue of A = interpolate o spread in a common mode, V the marker volume, the map is stable while
///
///   m > K/4 + V/(2 - V S)
///
/// What the rest changes is measured (cases coupling-stability*): nothing where the motion that grows first
/// is short and S near 0, as in stiff bodies; 1 to 6 % of the mass, always for the better, where it is long.
#pragma once

#include "scene/alternating_growth.hpp"

namespace veriflex::scene {

/// Beyond this growth no measured scene was held by the fluid's own motion (cases coupling-stability*).
constexpr double growth_refused = 1.1;

struct Growth {
  double factor;  // by which the motion grows most that grows most in a step, 1 where none does; may be inf
  /// What grows by less than this above 1 would not have been seen: growth_resolution; more where a small
  /// motion had to be stepped forward in the map, which is so while F follows the sub-steps, and where the
  /// body stands under stress, so that it may leave its place slowly without any fluid.
  double resolution;
  bool grows() const { return factor > 1.0 + growth_resolution; }
};

/// The spectral radius of that map: of a small state all eigenvalues, by a dense solver.
Growth dense_growth(const CoupledStep& step);

/// The same of any state: frozen forces by AlternatingGrowth; others by many steps of the map from a motion
/// without pattern, and the Krylov space of what is left, whose eigenvalues count only with their residual.
Growth large_growth(const CoupledStep& step);

/// The one or the other, of bodies with a coupling: one, or several that share nodes of the fluid, which may
/// grow where each of them alone does not. Throws NumericalFailure when one has no energy where it stands.
Growth coupling_growth(const fluid::Spec& fluid, std::span<const Body> bodies,
                       FluidMemory memory = FluidMemory::Keeps);
inline Growth coupling_growth(const fluid::Spec& fluid, const Body& body,
                              FluidMemory memory = FluidMemory::Keeps) {
  return coupling_growth(fluid, std::span(&body, 1), memory);
}

/// V S, S the largest eigenvalue of A: the part of a slip that the exchange takes away at once where it takes
/// most. From 2 on it turns every slip of that pattern into a larger one, whatever the bodies weigh.
double answered_slip(const fluid::Spec& fluid, std::span<const Body> bodies);
inline double answered_slip(const fluid::Spec& fluid, const Body& body) {
  return answered_slip(fluid, std::span(&body, 1));
}

/// The node mass at which coupling_growth() comes down to 1, to a relative accuracy: smaller ones are
/// unstable; 0 when none is. Throws NumericalFailure when all are, which is so for V S >= 2.
double critical_node_mass(const fluid::Spec& fluid, const Body& body, double accuracy,
                          FluidMemory memory = FluidMemory::Keeps);

}  // namespace veriflex::scene
