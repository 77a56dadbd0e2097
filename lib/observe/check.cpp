#include "observe/check.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "base/error.hpp"
#include "base/mutant.hpp"

namespace veriflex::observe {

namespace {

std::string place(const fluid::Fluid& fluid, std::int64_t node) {
  const auto [x, y, z] = fluid.spec().grid.node(node);
  return fmt::format("step {}, node ({}, {}, {})", fluid.steps(), x, y, z);
}

}  // namespace

fluid::Extremes check(const fluid::Fluid& fluid, const MonitorSpec& spec) {
  const fluid::Extremes worst = fluid.extremes();
  if (!std::isfinite(worst.max_speed)) {
    throw NumericalFailure(fmt::format("{}: the velocity is {}, not a finite number",
                                       place(fluid, worst.max_speed_node), worst.max_speed),
                           FailureMode::NotFinite);
  }
  if (!(worst.min_density > 0.0)) {
    throw NumericalFailure(fmt::format("{}: the density is {:.6g}, it must stay above 0",
                                       place(fluid, worst.min_density_node), worst.min_density),
                           FailureMode::Density);
  }
  const double mach =
      worst.max_speed / (planted(Mutant::mach_without_sound) ? 1.0 : std::sqrt(fluid::sound_speed_squared));
  if (mach > spec.mach_limit) {
    throw NumericalFailure(
        fmt::format("{}: the Mach number is {:.6g}, the limit is {:.6g} (monitor.mach_limit)",
                    place(fluid, worst.max_speed_node), mach, spec.mach_limit),
        FailureMode::Mach);
  }
  return worst;
}

Metric last_good_step(std::int64_t step) {
  return {"last_good_step", static_cast<double>(step), "1", "of the last check that passed"};
}

std::vector<Metric> last_good(std::int64_t step, const fluid::Extremes& seen) {
  return {last_good_step(step),
          {"last_good_mach", seen.max_speed / std::sqrt(fluid::sound_speed_squared), "1",
           "largest speed of the fluid there, over that of sound"},
          {"last_good_min_density", seen.min_density, "M L^-3", "of the fluid there"}};
}

}  // namespace veriflex::observe
