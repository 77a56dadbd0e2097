#include "drivers/march.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/reduce.hpp"

namespace veriflex::drivers {

namespace {

constexpr std::int64_t between_looks = 100;  // the change of one step alone would drown in round-off

}  // namespace

void march(std::int64_t steps, observe::Lookout& lookout) {
  for (std::int64_t step = 0; step < steps; ++step) lookout.step();
}

void march(fluid::Fluid& fluid, std::int64_t steps, const observe::Watch& watch) {
  observe::Lookout lookout(fluid, watch);
  march(steps, lookout);
  lookout.at_end();
}

double least_change(fluid::Storage storage) {
  const double rounding = storage == fluid::Storage::Double
                              ? std::numeric_limits<double>::epsilon()
                              : static_cast<double>(std::numeric_limits<float>::epsilon());
  return rounding / static_cast<double>(between_looks);
}

Positions velocities_of(const fluid::Fluid& fluid, std::span<const std::int64_t> nodes) {
  Positions u;
  fluid.velocities(nodes, u);
  return u;
}

void march_to_steady(fluid::Fluid& fluid, std::span<const std::int64_t> nodes, const Steady& steady,
                     const observe::Watch& watch) {
  observe::Lookout lookout(fluid, watch);
  Positions before = velocities_of(fluid, nodes);
  double change = INFINITY;
  while (!(change <= steady.change)) {
    if (fluid.steps() + between_looks > steady.step_limit) {
      lookout.at_end();
      throw NumericalFailure(
          fmt::format("step {}: the velocity still changes by {:.3g} of its largest value a step, steady "
                      "means at most {:.3g}",
                      fluid.steps(), change, steady.change),
          FailureMode::NotConverged);
    }
    march(between_looks, lookout);
    Positions now = velocities_of(fluid, nodes);
    change = relative_to(largest_magnitude(now - before), largest_magnitude(now)) / between_looks;
    if (std::isnan(change)) lookout.at_end();
    before.swap(now);
  }
  lookout.at_end();
}

}  // namespace veriflex::drivers
