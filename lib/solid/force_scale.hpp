/// What out-of-balance forces are measured against.
#pragma once

#include <cmath>

#include "base/reduce.hpp"
#include "solid/elastic.hpp"

namespace veriflex::solid {

/// The largest tension, or what a strain of 1e-3 would give. (Below that strain the rounding of a bond's
/// length alone exceeds 1e-12 of its tension.)
template <bond::BondLaw Law>
double force_scale(const Law& law, const Workspace& work) {
  double scale = 0.0;
  for (Eigen::Index b = 0; b < work.d.rows(); ++b) {
    const double r = work.d.row(b).norm();
    scale = worse(scale, worse(std::abs(law.tension(r)), 1e-3 * law.stiffness(r) * r));
  }
  return scale;
}

}  // namespace veriflex::solid
