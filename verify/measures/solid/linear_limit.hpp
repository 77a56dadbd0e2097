/// Time steps beyond what leap-frog can follow.
#pragma once

#include <fmt/format.h>

#include "base/error.hpp"

namespace veriflex::measures {

/// Throws NumericalFailure when the time step reaches the linear limit 2/omega_max of the body at rest: what
/// would then be measured is leap-frog's instability.
inline void refuse_unstable_step(double dt, double limit) {
  if (dt < limit) return;
  throw NumericalFailure(
      fmt::format(
          "leap-frog is unstable: the time step {:.6g} is {:.4g} times the linear limit 2/omega_max = {:.6g} "
          "of the body at rest",
          dt, dt / limit, limit),
      FailureMode::TimeStep);
}

}  // namespace veriflex::measures
