/// Static equilibrium of a network under dead loads, with some degrees of freedom fixed.
#pragma once

#include "solid/elastic.hpp"

namespace veriflex::solid {

/// Per node and axis: true where the coordinate is fixed at its present value.
using FixedDofs = Eigen::Matrix<bool, Eigen::Dynamic, 3>;

struct Equilibrium {
  Positions u;         // displacement  [L]
  Positions reaction;  // force the holds exert on the network; zero where free  [M L T^-2]
  int iterations;      // Newton steps
  double residual;     // largest out-of-balance force over the largest bond tension  [1]
};

/// A spring of every coordinate to a place of its own: what inertia is to a step that is solved for its
/// middle.
struct Inertia {
  Eigen::VectorXd stiffness = {};  // of each node; empty: there is none  [M T^-2]
  Positions predicted = {};        // where each node would be without forces  [L]
};

/// Minimises energy(u) - sum load . u + sum inertia.stiffness/2 |u - inertia.predicted|^2 over the free
/// coordinates by Newton's method with Eigen's sparse Cholesky factorisation, starting at the displacement u.
/// A step is shortened until every bond stays inside its domain and the out-of-balance force or the energy
/// falls. Converged at a residual of 1e-12, or when rounding keeps a further step from helping. Throws
/// NumericalFailure:
///   "mechanism: N zero modes"  the network can move without force (never regularised),
///   "unstable: N negative"     the state is no minimum,
///   what_is_inadmissible() at the start, forces beyond double precision, or no convergence.
Equilibrium equilibrium(const Material& material, const Network& network, const Positions& u,
                        const FixedDofs& held, const Positions& load, const Inertia& inertia = {});

/// Throws NumericalFailure when a bond points against its undeformed direction at displacement u: for bodies
/// that are stretched or compressed, not for those that bend far.
void refuse_turned_bonds(const Network& network, const Positions& u);

}  // namespace veriflex::solid
