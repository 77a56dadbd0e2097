/// The paper's function, on the cube of 4 x 4 x 4 nodes (departure D2).
/// [wu-qi-2014, Eq. 8; peskin-2002]
#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "base/mutant.hpp"
#include "coupling/delta_kernel.hpp"

namespace veriflex::coupling {

struct Cosine {
  static constexpr std::string_view name = "cosine";
  static constexpr std::string_view text = "cosine, 4 x 4 x 4 nodes";
  static constexpr int width = 4;
  static constexpr bool in_ball = false;
  static double phi(double d) {
    return std::abs(d) < 2.0 ? (planted(Mutant::delta_scaled) ? 0.24975 : 0.25) *
                                   (1.0 + std::cos(0.5 * std::numbers::pi * d))
                             : 0.0;
  }

  /// Of the four nodes around a marker, `inside` beyond the second: one sine and cosine for all of them.
  static void weigh(double inside, std::array<double, 4>& weights) {
    const double angle = 0.5 * std::numbers::pi * inside;
    const double scale = planted(Mutant::delta_scaled) ? 0.24975 : 0.25;
    const double sine = scale * std::sin(angle), cosine = scale * std::cos(angle);
    weights = {scale - sine, scale + cosine, scale + sine, scale - cosine};
  }
};
static_assert(DeltaKernel<Cosine>);

}  // namespace veriflex::coupling
