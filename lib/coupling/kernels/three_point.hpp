/// Three nodes along an axis.
/// [roma-1999]
#pragma once

#include <cmath>

#include "base/mutant.hpp"
#include "coupling/delta_kernel.hpp"

namespace veriflex::coupling {

struct ThreePoint {
  static constexpr std::string_view name = "3-point";
  static constexpr std::string_view text = "3 nodes along an axis";
  static constexpr int width = 3;
  static constexpr bool in_ball = false;
  static double phi(double d) {
    const double r = std::abs(d);
    if (r < 0.5) return (1.0 + std::sqrt(1.0 - 3.0 * r * r)) / 3.0;
    if (r < (planted(Mutant::three_point_cut_short) ? 1.4 : 1.5))
      return (5.0 - 3.0 * r - std::sqrt(1.0 - 3.0 * (1.0 - r) * (1.0 - r))) / 6.0;
    return 0.0;
  }
};
static_assert(DeltaKernel<ThreePoint>);

}  // namespace veriflex::coupling
