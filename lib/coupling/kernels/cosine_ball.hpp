/// The cosine cut to the ball of radius two that the paper's words and its Eq. 8 name; it loses up to 6.6 %
/// of what is exchanged.
/// [wu-qi-2014, Eq. 8]
#pragma once

#include "coupling/kernels/cosine.hpp"

namespace veriflex::coupling {

struct CosineBall {
  static constexpr std::string_view name = "cosine-ball";
  static constexpr std::string_view text = "cosine, cut to the ball of radius 2";
  static constexpr int width = 4;
  static constexpr bool in_ball = true;
  static double phi(double d) { return Cosine::phi(d); }
  static void weigh(double inside, std::array<double, 4>& weights) { Cosine::weigh(inside, weights); }
};
static_assert(DeltaKernel<CosineBall>);

}  // namespace veriflex::coupling
