/// Newton's method for equilibria with either solver of its linear equations; the user's side is statics.hpp.
#pragma once

#include "solid/dof_map.hpp"
#include "solid/statics.hpp"

namespace veriflex::solid {

enum class LinearSolver { Factor, Iterate };

/// A factor that is used again as long as steps with it help.
struct KeptFactor {
  Positions at{};  // the displacement whose Hessian it is of; empty before the first
  Cholesky factor{};
  double stiffest = 0.0;  // largest absolute row sum of that Hessian  [M T^-2]
  bool is_made = false;   // false with a place: it is made there when it is asked for
};

/// As equilibrium(), with inertia. A step by `kept`, whole, is taken where it stays clear of the bonds'
/// limits and leaves half of the out-of-balance force at most; else the factor is made anew and Newton's own
/// step taken. The inertia's stiffness must be the same from call to call.
Equilibrium newton_with(KeptFactor& kept, const Material& material, const Network& network,
                        const Positions& u, const FixedDofs& held, const Positions& load,
                        const Inertia& inertia, double residual);

/// As equilibrium(). Eigen's conjugate gradients with a diagonal preconditioner solve each step's equations
/// to a thousandth, need no factor, and do not count modes: what is no minimum is "unstable" only when a step
/// would go uphill.
Equilibrium newton(LinearSolver solver, const Material& material, const Network& network, const Positions& u,
                   const FixedDofs& held, const Positions& load, const Inertia& inertia, double residual);

}  // namespace veriflex::solid
