#include "observe/watch.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "base/error.hpp"

namespace veriflex::observe {

namespace {

std::string place(const fluid::Fluid& fluid, std::int64_t node) {
  const auto [x, y, z] = fluid.spec().grid.node(node);
  return fmt::format("step {}, node ({}, {}, {})", fluid.steps(), x, y, z);
}

}  // namespace

fluid::Extremes check(const fluid::Fluid& fluid, const Watch& watch) {
  const fluid::Extremes worst = fluid.extremes();
  if (!std::isfinite(worst.greatest_speed)) {
    throw NumericalFailure(fmt::format("{}: the velocity is {}, not a finite number",
                                       place(fluid, worst.greatest_speed_node), worst.greatest_speed),
                           FailureMode::NotFinite);
  }
  if (!(worst.least_density > 0.0)) {
    throw NumericalFailure(fmt::format("{}: the density is {:.6g}, it must stay above 0",
                                       place(fluid, worst.least_density_node), worst.least_density),
                           FailureMode::Density);
  }
  const double mach = worst.greatest_speed / std::sqrt(fluid::sound_speed_squared);
  if (mach > watch.mach_limit) {
    throw NumericalFailure(
        fmt::format("{}: the Mach number is {:.6g}, the limit is {:.6g} (watch.mach_limit)",
                    place(fluid, worst.greatest_speed_node), mach, watch.mach_limit),
        FailureMode::Mach);
  }
  return worst;
}

std::vector<Metric> last_good(std::int64_t step, const fluid::Extremes& seen) {
  return {{"last_good_step", static_cast<double>(step), "1", "of the last look that found all sound"},
          {"last_good_mach", seen.greatest_speed / std::sqrt(fluid::sound_speed_squared), "1",
           "greatest speed of the fluid there, over that of sound"},
          {"last_good_least_density", seen.least_density, "M L^-3", "of the fluid there"}};
}

}  // namespace veriflex::observe
