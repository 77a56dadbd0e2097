#include "drivers/under_watch.hpp"

#include <fmt/format.h>

#include "observe/interrupted.hpp"

namespace veriflex::drivers {

void under_watch(const fluid::Fluid& fluid, const observe::Watch& watch, const std::string& name,
                 const Steps& steps) {
  observe::Observations good;
  const auto look = [&] {
    const fluid::Extremes seen = observe::check(fluid, watch);
    good.metrics = observe::last_good(fluid.steps(), seen);
  };
  try {
    look();
    steps([&] {
      if (fluid.steps() % watch.every == 0) look();
    });
    look();
  } catch (const NumericalFailure& failure) {
    throw observe::Interrupted(NumericalFailure(fmt::format("{}: {}", name, failure.what())),
                               std::move(good));
  }
}

}  // namespace veriflex::drivers
