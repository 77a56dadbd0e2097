/// Whether the exchange between a body and the fluid is stable, before the first step.
///
/// One step of body and fluid is a linear map about the undeformed body in a fluid at rest: of the nodes'
/// displacements and half-step velocities, and of the fluid's velocity W at the coupled nodes, which is all
/// that the exchange sees of the fluid. The exchange leaves - A F in W, with F the force on the coupled nodes
/// and A = interpolate o spread at their places. Everything else that the fluid does with its momentum
/// (streaming, pressure, viscosity) is left out: W keeps all that it was given. With all coupled nodes alike,
/// one step for the solid and K the stiffness, S the eigenvalue of A in a common mode, the map is stable
/// while
///
///   m > K/4 + 1/(2 - S)
///
/// What the rest changes is measured (cases coupling-stability*): nothing where the motion that grows first
/// is short and S near 0, as in stiff bodies; 1 to 6 % of the mass, always for the better, where it is long.
#pragma once

#include "scene/simulation.hpp"

namespace veriflex::scene {

/// Largest factor by which a small motion grows in a step: the spectral radius of that map, and 1 where
/// nothing grows, for a body that drifts with the fluid neither grows nor decays. What exceeds 1 by less than
/// growth_resolution is rounding. `memory`: the part of W that is left a step later. Throws NumericalFailure
/// when the body has no energy where it stands.
double coupling_growth(const fluid::Spec& fluid, const Body& body, const CouplingSpec& coupling,
                       double memory = 1.0);

constexpr double growth_resolution = 1e-5;

/// Beyond this growth no measured scene was held by the fluid's own motion (cases coupling-stability*).
constexpr double growth_refused = 1.1;

/// The node mass at which coupling_growth() comes down to 1, to a relative accuracy: smaller ones are
/// unstable; 0 when none is. Looked for upwards from the body's own mass if that is unstable, else downwards.
double critical_node_mass(const fluid::Spec& fluid, Body body, const CouplingSpec& coupling, double accuracy,
                          double memory = 1.0);

}  // namespace veriflex::scene
