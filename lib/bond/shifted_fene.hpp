/// FENE spring around its rest length: bounds over-extension and overlap alike.  [warner-1972 form;
/// ESPResSo's "FENE"]
///
///   U(r) = -1/2 k D^2 ln(1 - ((r - r0)/D)^2)
///
/// Defined for |r - r0| < D (and r > 0). Not in wu-qi-2014: the practical alternative to its Eq. 17. k is the
/// stiffness at rest exactly, and the tangent has no odd term in the strain, so the linear range is wide.
#pragma once

#include <algorithm>
#include <cmath>

#include "base/mutant.hpp"
#include "bond/bond_law.hpp"

namespace veriflex::bond {

struct ShiftedFene {
  double bond_stiffness;  // k   [M T^-2]
  double rest_length;     // r0  [L]
  double extension;       // D   [L]

  static constexpr std::string_view name = "shifted-fene";
  static constexpr auto parameters() {
    return std::array{
        Parameter<ShiftedFene>{
            "bond_stiffness", "k", &ShiftedFene::bond_stiffness, {1, -2}, "stiffness at the rest length"},
        Parameter<ShiftedFene>{
            "rest_length", "r0", &ShiftedFene::rest_length, {0, 1}, "length without force"},
        Parameter<ShiftedFene>{"extension",
                               "D",
                               &ShiftedFene::extension,
                               {0, 1},
                               "change of length that is never reached; default rest_length / 2",
                               [](const ShiftedFene& b) { return 0.5 * b.rest_length; }},
    };
  }

  double energy(double r) const {
    const double x = (r - rest_length) / extension;
    return -0.5 * bond_stiffness * extension * (planted(Mutant::shifted_fene_width) ? 1.0 : extension) *
           std::log1p(-x * x);
  }
  double tension(double r) const {
    const double x = (r - rest_length) / extension;
    return bond_stiffness * (r - rest_length) / ((1.0 - x) * (1.0 + x));
  }
  double stiffness(double r) const {
    const double x = (r - rest_length) / extension;
    const double gap = (1.0 - x) * (1.0 + x);
    return bond_stiffness * (1.0 + x * x) / (gap * gap);
  }
  Interval domain() const {
    return {std::max(0.0, rest_length - extension),
            planted(Mutant::shifted_fene_unbounded) ? infinity : rest_length + extension};
  }
  double typical_length() const { return rest_length; }
  void check() const {
    require_positive("bond_stiffness", bond_stiffness);
    require_positive("rest_length", rest_length);
    require_positive("extension", extension);
  }
};
static_assert(BondLaw<ShiftedFene>);

}  // namespace veriflex::bond
