#include "measures/fluid/steady.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/reduce.hpp"

namespace veriflex::measures {

namespace {

constexpr std::int64_t between_checks = 100;  // the change of one step alone would drown in round-off

}  // namespace

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

scene::Simulation run_to_steady(const fluid::Spec& fluid, std::span<const std::int64_t> nodes,
                                const Steady& steady, const observe::MonitorSpec& monitor,
                                Progress& progress) {
  scene::Simulation simulation({.fluid = fluid});
  observe::Run run(simulation, monitor, {}, "", progress);
  Positions before = velocities_of(simulation.fluid(), nodes);
  double change = INFINITY;
  while (!(change <= steady.change)) {
    if (simulation.steps() + between_checks > steady.step_limit) {
      run.finish();
      run.interrupt(NumericalFailure(
          fmt::format("step {}: the velocity still changes by {:.3g} of its largest value a step, steady "
                      "means at most {:.3g}",
                      simulation.steps(), change, steady.change),
          FailureMode::NotConverged));
    }
    run.advance(between_checks, steady.step_limit);
    Positions now = velocities_of(simulation.fluid(), nodes);
    change = relative_to(largest_magnitude(now - before), largest_magnitude(now)) / between_checks;
    if (std::isnan(change)) run.finish();
    before.swap(now);
  }
  run.finish();
  return simulation;
}

std::int64_t steps_to_steady(const Steady& steady, double rate) {
  // The velocity changes by rate exp(-rate t) of its last value a step.
  const double steps = std::log(std::max(1.0, rate / steady.change)) / rate;
  const auto checks = static_cast<std::int64_t>(std::ceil(steps / static_cast<double>(between_checks)));
  return std::min(steady.step_limit, between_checks * (1 + checks));
}

scene::Simulation run_steps(scene::Scene scene, std::int64_t steps, const observe::MonitorSpec& monitor,
                            Progress& progress) {
  scene::Simulation simulation(std::move(scene));
  observe::Run run(simulation, monitor, {}, "", progress);
  run.advance(steps, steps);
  run.finish();
  return simulation;
}

}  // namespace veriflex::measures
