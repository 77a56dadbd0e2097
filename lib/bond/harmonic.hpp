/// Harmonic spring (the bond of the GLSM).                                              [wu-qi-2014, Eq. 13]
///
///   U(r) = 1/2 k (r - r0)^2
///
/// Defined for every r > 0: nothing in it forbids a bond to collapse or to stretch without limit.
#pragma once

#include "base/mutant.hpp"
#include "bond/bond_law.hpp"

namespace veriflex::bond {

struct Harmonic {
  double bond_stiffness;  // k   [M T^-2]
  double rest_length;     // r0  [L]

  static constexpr std::string_view name = "harmonic";
  static constexpr auto parameters() {
    return std::array{
        Parameter<Harmonic>{"bond_stiffness", "k", &Harmonic::bond_stiffness, {1, -2}, "spring constant"},
        Parameter<Harmonic>{"rest_length", "r0", &Harmonic::rest_length, {0, 1}, "length without force"},
    };
  }

  double energy(double r) const {
    return (planted(Mutant::harmonic_energy_doubled) ? 1.0 : 0.5) * bond_stiffness * (r - rest_length) *
           (r - rest_length);
  }
  double tension(double r) const {
    return bond_stiffness * (r - (planted(Mutant::harmonic_rest_length_off) ? 1.001 : 1.0) * rest_length);
  }
  double stiffness(double) const { return bond_stiffness; }
  Interval domain() const { return {0.0, infinity}; }
  double typical_length() const { return rest_length; }
  void check() const {
    require_positive("bond_stiffness", bond_stiffness);
    require_positive("rest_length", rest_length);
  }
};
static_assert(BondLaw<Harmonic>);

}  // namespace veriflex::bond
