#include "observe/monitor.hpp"

#include "observe/interrupted.hpp"

namespace veriflex::observe {

Monitor::Monitor(fluid::Fluid& fluid, const MonitorSpec& spec)
    : fluid_(fluid), spec_(spec), step_(fluid.steps()), seen_(check(fluid, spec)) {}

template <class Work>
void Monitor::guarded(Work work) {
  try {
    work();
  } catch (const NumericalFailure& failure) {
    throw Interrupted(failure, {.records = {}, .metrics = last_good(step_, seen_)});
  }
}

void Monitor::step(const fluid::NodeForces& forces) {
  guarded([&] {
    fluid_.collide_and_stream(forces);
    if (fluid_.steps() % spec_.every == 0) check_now();
  });
}

void Monitor::at_end() {
  guarded([&] {
    if (fluid_.steps() != step_) check_now();
  });
}

void Monitor::check_now() {
  seen_ = check(fluid_, spec_);
  step_ = fluid_.steps();
}

}  // namespace veriflex::observe
