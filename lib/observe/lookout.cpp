#include "observe/lookout.hpp"

#include "observe/interrupted.hpp"

namespace veriflex::observe {

Lookout::Lookout(const fluid::Fluid& fluid, const Watch& watch)
    : fluid_(fluid), watch_(watch), step_(fluid.steps()), seen_(check(fluid, watch)) {}

void Lookout::after_step() {
  if (fluid_.steps() % watch_.every == 0) look();
}

void Lookout::at_end() {
  if (fluid_.steps() != step_) look();
}

void Lookout::look() {
  try {
    seen_ = check(fluid_, watch_);
    step_ = fluid_.steps();
  } catch (const NumericalFailure& failure) {
    throw Interrupted(failure, {.records = {}, .metrics = last_good(step_, seen_)});
  }
}

}  // namespace veriflex::observe
