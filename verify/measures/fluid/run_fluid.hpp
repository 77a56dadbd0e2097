/// Runs of a fluid that is checked on the way.
#pragma once

#include "fluid/fluid.hpp"
#include "observe/monitor.hpp"

namespace veriflex::measures {

/// So many steps of a run. Throws observe::Interrupted with what the last good check saw.
void run_steps(std::int64_t steps, observe::Monitor& monitor);

/// So many steps that are a run of their own: the fluid is checked before them and after them, too.
void run_steps(fluid::Fluid& fluid, std::int64_t steps, const observe::MonitorSpec& monitor);

struct Steady {
  double change;            // per step, of the velocities, relative to its largest value
  std::int64_t step_limit;  // beyond which there is no hope
};

/// The smallest change per step that a criterion may ask for: what rounding alone may change at any time.
double min_change(fluid::Storage storage);

/// Velocity sum f c / rho of these nodes, one row each.
Positions velocities_of(const fluid::Fluid& fluid, std::span<const std::int64_t> nodes);

/// Steps until the velocities of these nodes change by at most steady.change a step, mean over 100 steps; a
/// fluid at rest is steady. Throws NumericalFailure, which names the change, at the limit of steps.
void run_to_steady(fluid::Fluid& fluid, std::span<const std::int64_t> nodes, const Steady& steady,
                   const observe::MonitorSpec& monitor);

}  // namespace veriflex::measures
