#include "drivers/march.hpp"

#include <fmt/format.h>

#include <cmath>

#include "observe/interrupted.hpp"

namespace veriflex::drivers {

namespace {

constexpr std::int64_t between_looks = 100;  // the change of one step alone would drown in round-off

struct LastGood {
  std::int64_t step;
  fluid::Extremes seen;
};

LastGood look(const fluid::Fluid& fluid, const observe::Watch& watch) {
  return {fluid.steps(), observe::check(fluid, watch)};
}

void march_on(fluid::Fluid& fluid, std::int64_t steps, const observe::Watch& watch, LastGood& good) {
  try {
    for (std::int64_t step = 0; step < steps; ++step) {
      fluid.collide_and_stream();
      if (fluid.steps() % watch.every == 0) good = look(fluid, watch);
    }
  } catch (const NumericalFailure& failure) {
    throw observe::Interrupted(failure, {.records = {}, .metrics = observe::last_good(good.step, good.seen)});
  }
}

}  // namespace

void march(fluid::Fluid& fluid, std::int64_t steps, const observe::Watch& watch) {
  LastGood good = look(fluid, watch);
  march_on(fluid, steps, watch, good);
}

Positions velocities_of(const fluid::Fluid& fluid, std::span<const std::int64_t> nodes) {
  Positions u;
  fluid.velocities(nodes, u);
  return u;
}

void march_to_steady(fluid::Fluid& fluid, std::span<const std::int64_t> nodes, const Steady& steady,
                     const observe::Watch& watch) {
  LastGood good = look(fluid, watch);
  Positions before = velocities_of(fluid, nodes);
  double change = INFINITY;
  while (!(change <= steady.change)) {
    if (fluid.steps() + between_looks > steady.step_limit) {
      observe::check(fluid, watch);
      throw NumericalFailure(
          fmt::format("step {}: the velocity still changes by {:.3g} of its largest value a step, steady "
                      "means at most {:.3g}",
                      fluid.steps(), change, steady.change));
    }
    march_on(fluid, between_looks, watch, good);
    Positions now = velocities_of(fluid, nodes);
    change = (now - before).cwiseAbs().maxCoeff() / now.cwiseAbs().maxCoeff() / between_looks;
    before.swap(now);
  }
}

}  // namespace veriflex::drivers
