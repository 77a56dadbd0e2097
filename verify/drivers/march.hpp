/// Runs of a fluid, under watch.
#pragma once

#include <functional>

#include "fluid/fluid.hpp"
#include "observe/watch.hpp"

namespace veriflex::drivers {

/// So many steps. Throws observe::Interrupted with what the last good look saw.
void march(fluid::Fluid& fluid, std::int64_t steps, const observe::Watch& watch);

struct Steady {
  double change;            // per step, of what is looked at, relative to its largest value
  std::int64_t step_limit;  // beyond which there is no hope
};

/// Velocity sum f c / rho of these nodes, one row each.
Positions velocities_of(const fluid::Fluid& fluid, std::span<const std::int64_t> nodes);

/// Steps until the velocities of these nodes change by at most steady.change a step, mean over 100 steps.
/// Throws NumericalFailure, which names the change, at the limit of steps.
void march_to_steady(fluid::Fluid& fluid, std::span<const std::int64_t> nodes, const Steady& steady,
                     const observe::Watch& watch);

}  // namespace veriflex::drivers
