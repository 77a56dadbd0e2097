/// Adds 3 w g.c after the collision; the velocity is sum f c / rho.
/// [wu-qi-2014, Eq. 12]
#pragma once

#include "fluid/force_scheme.hpp"

namespace veriflex::fluid {

struct FirstOrder {
  static constexpr std::string_view name = "first-order";
  static constexpr std::string_view text = "first order";
  static constexpr bool shifts_velocity = false;
  static constexpr bool changes_N = false;
  template <class Real>
  static Real of_N(Real) {
    return Real(0);
  }
  template <class Real>
  static Real beyond_N(Real) {
    return Real(1);
  }
};
static_assert(ForceScheme<FirstOrder>);

}  // namespace veriflex::fluid
