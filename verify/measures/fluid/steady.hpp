/// Studies of a fluid alone: so many steps, or until nothing changes.
#pragma once

#include "engine/read_scene.hpp"
#include "engine/study.hpp"
#include "observe/run.hpp"

namespace veriflex::measures {

struct Steady {
  double change;            // per step, of the velocities, relative to its largest value
  std::int64_t step_limit;  // beyond which there is no hope
};

/// The smallest change per step that a criterion may ask for: what rounding alone may change at any time.
double min_change(fluid::Storage storage);

/// Velocity sum f c / rho of these nodes, one row each.
Positions velocities_of(const fluid::Fluid& fluid, std::span<const std::int64_t> nodes);

/// The fluid alone from rest, until the velocities of these nodes change by at most steady.change a step,
/// mean over 100 steps; one at rest is steady. Throws observe::Interrupted, which names the change, at the
/// limit of steps.
scene::Simulation run_to_steady(const fluid::Spec& fluid, std::span<const std::int64_t> nodes,
                                const Steady& steady, const observe::MonitorSpec& monitor,
                                Progress& progress);

/// About how many steps that takes, from rest, where what is slowest decays by `rate` a step and is about as
/// large at first as the velocity in the end.
std::int64_t steps_to_steady(const Steady& steady, double rate);

/// A driver's study of one fluid: what was read, what it declares, the run that measures it, and the steps of
/// that run, about, where they are known.
template <class Read>
engine::Study study_of(const io::Table& top, const scene::Outline& outline, observe::Observations declares,
                       const Read& read, void (*run)(const Read&, observe::Observations&, Progress&),
                       std::int64_t steps = 0) {
  engine::Study study{.plan = engine::read_plan(top, outline),
                      .declares = std::move(declares),
                      .run = [read, run](observe::Observations& seen, Progress& progress, engine::Cost&) {
                        run(read, seen, progress);
                      }};
  if (steps > 0) {
    study.expects = [fluid = *outline.fluid, steps] {
      return std::vector{*scene::expected_work({.fluid = fluid}, steps)};
    };
  }
  return study;
}

/// The fluid alone, so many steps.
scene::Simulation run_steps(scene::Scene scene, std::int64_t steps, const observe::MonitorSpec& monitor,
                            Progress& progress);

}  // namespace veriflex::measures
