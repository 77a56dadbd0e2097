/// Newton's method for equilibria with either solver of its linear equations; the user's side is statics.hpp.
#pragma once

#include "solid/statics.hpp"

namespace veriflex::solid {

enum class LinearSolver { Factor, Iterate };

/// As equilibrium(). Eigen's conjugate gradients with a diagonal preconditioner solve each step's equations
/// to a thousandth, need no factor, and do not count modes: what is no minimum is "unstable" only when a step
/// would go uphill.
Equilibrium newton(LinearSolver solver, const Material& material, const Network& network, const Positions& u,
                   const FixedDofs& held, const Positions& load, const Inertia& inertia, double residual);

}  // namespace veriflex::solid
