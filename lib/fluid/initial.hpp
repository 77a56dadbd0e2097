/// Populations to start from where velocity and its gradient are known.
#pragma once

#include "fluid/fluid.hpp"

namespace veriflex::fluid {

/// Local equilibrium plus what viscous stress adds to it in a flow that has been going on: the first term of
/// the Chapman-Enskog expansion, -3 tau rho w_q (c c - 1/3) : grad u. Without it a flow begins with the
/// stress of a fluid at rest and takes a few times tau to build it up. gradient(a, b) is du_b/dx_a [T^-1].
Populations near_equilibrium(double rho, const Vec3& u, const Mat3& gradient, double relaxation_time);

}  // namespace veriflex::fluid
