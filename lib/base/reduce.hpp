/// Reductions of measured numbers. They keep a NaN, which std::max, std::min and Eigen's maxCoeff() may lose:
/// a run that is no number anywhere must not look like a good one.
#pragma once

#include <cmath>

#include "base/mutant.hpp"
#include "base/vec.hpp"

namespace veriflex {

/// The larger of two; not a number when one of them is not.
inline double worse(double a, double b) {
  if (planted(Mutant::nan_lost_by_maximum)) return std::fmax(a, b);
  return std::isnan(a) || a >= b ? a : b;
}

/// The smaller of two; not a number when one of them is not.
inline double lesser(double a, double b) { return std::isnan(a) || a <= b ? a : b; }

/// The largest and the smallest of an array, and the largest magnitude; not a number when one of them is not,
/// 0 for no numbers at all.
template <class Derived>
double largest(const Eigen::DenseBase<Derived>& x) {
  return x.size() == 0 ? 0.0 : x.derived().template maxCoeff<Eigen::PropagateNaN>();
}
template <class Derived>
double smallest(const Eigen::DenseBase<Derived>& x) {
  return x.size() == 0 ? 0.0 : x.derived().template minCoeff<Eigen::PropagateNaN>();
}
template <class Derived>
double largest_magnitude(const Eigen::DenseBase<Derived>& x) {
  if (planted(Mutant::nan_lost_in_arrays))
    return x.size() == 0 ? 0.0 : x.derived().array().abs().template maxCoeff<Eigen::PropagateNumbers>();
  return x.size() == 0 ? 0.0 : x.derived().array().abs().template maxCoeff<Eigen::PropagateNaN>();
}

/// |error|/|scale|; nothing over nothing is 0: what is at rest and should be is right.
inline double relative_to(double error, double scale) {
  return error == 0.0 ? 0.0 : std::abs(error) / std::abs(scale);
}

}  // namespace veriflex
