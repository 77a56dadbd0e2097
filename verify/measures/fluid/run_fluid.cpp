#include "measures/fluid/run_fluid.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/reduce.hpp"

namespace veriflex::measures {

namespace {

constexpr std::int64_t between_checks = 100;  // the change of one step alone would drown in round-off

}  // namespace

void run_steps(std::int64_t steps, observe::Monitor& monitor) {
  for (std::int64_t step = 0; step < steps; ++step) monitor.step();
}

void run_steps(fluid::Fluid& fluid, std::int64_t steps, const observe::MonitorSpec& spec) {
  observe::Monitor monitor(fluid, spec);
  run_steps(steps, monitor);
  monitor.at_end();
}

double min_change(fluid::Storage storage) {
  const double rounding = storage == fluid::Storage::Double
                              ? std::numeric_limits<double>::epsilon()
                              : static_cast<double>(std::numeric_limits<float>::epsilon());
  return rounding / static_cast<double>(between_checks);
}

Positions velocities_of(const fluid::Fluid& fluid, std::span<const std::int64_t> nodes) {
  Positions u;
  fluid.velocities(nodes, u);
  return u;
}

void run_to_steady(fluid::Fluid& fluid, std::span<const std::int64_t> nodes, const Steady& steady,
                   const observe::MonitorSpec& spec) {
  observe::Monitor monitor(fluid, spec);
  Positions before = velocities_of(fluid, nodes);
  double change = INFINITY;
  while (!(change <= steady.change)) {
    if (fluid.steps() + between_checks > steady.step_limit) {
      monitor.at_end();
      throw NumericalFailure(
          fmt::format("step {}: the velocity still changes by {:.3g} of its largest value a step, steady "
                      "means at most {:.3g}",
                      fluid.steps(), change, steady.change));
    }
    run_steps(between_checks, monitor);
    Positions now = velocities_of(fluid, nodes);
    change = relative_to(largest_magnitude(now - before), largest_magnitude(now)) / between_checks;
    if (std::isnan(change)) monitor.at_end();
    before.swap(now);
  }
  monitor.at_end();
}

}  // namespace veriflex::measures
