/// The velocity is (sum f c + g/2) / rho, the source (1 - omega/2) w [3 (c - u) + 9 (c.u) c].g
/// [guo-2002]
#pragma once

#include "base/mutant.hpp"
#include "fluid/force_scheme.hpp"

namespace veriflex::fluid {

struct Guo {
  static constexpr std::string_view name = "guo";
  static constexpr std::string_view text = "second order (Guo)";
  static constexpr bool shifts_velocity = true;
  static constexpr bool changes_N = true;
  template <class Real>
  static Real of_N(Real omega) {
    return Real(2) * (Real(1) - Real(planted(Mutant::guo_source_not_reduced) ? 0.0 : 0.5) * omega);
  }
  template <class Real>
  static Real beyond_N(Real omega) {
    return -(Real(1) - Real(0.5) * omega);
  }
};
static_assert(ForceScheme<Guo>);

}  // namespace veriflex::fluid
