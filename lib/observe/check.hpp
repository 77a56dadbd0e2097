/// Checks of a running fluid: a run that has left its validity must end with its name and place, not with
/// numbers that look like a result.
#pragma once

#include <cstdint>

#include "fluid/fluid.hpp"
#include "observe/body_check.hpp"
#include "observe/record.hpp"

namespace veriflex::observe {

struct MonitorSpec {
  std::int64_t every = 100;  // steps from one check to the next
  /// Largest speed over the speed of sound. At 0.3 pressure changes the density by Ma^2/2 = 4.5 %, and the
  /// terms of order Ma^3 that the equilibrium leaves out come to a few per cent of what it keeps.
  double mach_limit = 0.3;
  BodyLimits bodies{};
};

/// The extremes of the fluid, when all is well. Throws NumericalFailure, which names step, node, quantity,
/// value and bound, when any node is not a number, has no positive density, or is faster than the limit.
/// Costs about as much as a step or two.
fluid::Extremes check(const fluid::Fluid& fluid, const MonitorSpec& spec);

/// What a result says of the last check that passed.
Metric last_good_step(std::int64_t step);
std::vector<Metric> last_good(std::int64_t step, const fluid::Extremes& seen);

}  // namespace veriflex::observe
