#include "observe/lookout.hpp"

#include "observe/interrupted.hpp"

namespace veriflex::observe {

Lookout::Lookout(fluid::Fluid& fluid, const Watch& watch)
    : fluid_(fluid), watch_(watch), step_(fluid.steps()), seen_(check(fluid, watch)) {}

template <class Work>
void Lookout::guarded(Work work) {
  try {
    work();
  } catch (const NumericalFailure& failure) {
    throw Interrupted(failure, {.records = {}, .metrics = last_good(step_, seen_)});
  }
}

void Lookout::step(const fluid::NodeForces& forces) {
  guarded([&] {
    fluid_.collide_and_stream(forces);
    if (fluid_.steps() % watch_.every == 0) look();
  });
}

void Lookout::at_end() {
  guarded([&] {
    if (fluid_.steps() != step_) look();
  });
}

void Lookout::look() {
  seen_ = check(fluid_, watch_);
  step_ = fluid_.steps();
}

}  // namespace veriflex::observe
