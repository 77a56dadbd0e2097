/// Four nodes along an axis; even and odd nodes get the same.
/// [peskin-2002]
#pragma once

#include <cmath>

#include "coupling/delta_kernel.hpp"

namespace veriflex::coupling {

struct FourPoint {
  static constexpr std::string_view name = "4-point";
  static constexpr std::string_view text = "4 nodes along an axis";
  static constexpr int width = 4;
  static constexpr bool in_ball = false;
  static double phi(double d) {
    const double r = std::abs(d);
    if (r < 1.0) return (3.0 - 2.0 * r + std::sqrt(1.0 + 4.0 * r - 4.0 * r * r)) / 8.0;
    if (r < 2.0) return (5.0 - 2.0 * r - std::sqrt(-7.0 + 12.0 * r - 4.0 * r * r)) / 8.0;
    return 0.0;
  }
};
static_assert(DeltaKernel<FourPoint>);

}  // namespace veriflex::coupling
