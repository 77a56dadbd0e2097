#include "measures/coupling/run_monitored.hpp"

#include "observe/interrupted.hpp"

namespace veriflex::measures {

void run_monitored(const fluid::Fluid& fluid, const observe::MonitorSpec& monitor, const std::string& name,
                   std::int64_t steps, const std::function<void(std::int64_t step)>& advance) {
  observe::Observations good;
  const auto check = [&] {
    const fluid::Extremes seen = observe::check(fluid, monitor);
    good.metrics = observe::last_good(fluid.steps(), seen);
  };
  try {
    check();
    for (std::int64_t step = 0; step < steps; ++step) {
      advance(step);
      if (fluid.steps() % monitor.every == 0) check();
    }
    check();
  } catch (const NumericalFailure& failure) {
    throw observe::Interrupted(failure.at(name), std::move(good));
  }
}

}  // namespace veriflex::measures
