#include "solid/dof_map.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "base/reduce.hpp"

namespace veriflex::solid {

namespace {

using Sparse = Eigen::SparseMatrix<double>;

// Eigenvalues of the Hessian below this part of its norm are zero: rounding leaves up to about 1e-15 of it.
constexpr double zero_mode = 1e-12;

[[noreturn]] void fail_as_singular(const Sparse& h, int newton_step) {
  const double small = zero_mode * infinity_norm(h);
  // For a matrix of zeros (all bonds slack) every mode is a zero mode.
  const Eigen::Index negative = small > 0.0 ? eigenvalues_below(h, -small) : 0;
  const Eigen::Index zero = small > 0.0 ? eigenvalues_below(h, small) - negative : h.rows();
  const std::string where = fmt::format("at Newton step {} over {} free coordinates", newton_step, h.rows());
  if (negative > 0) {
    throw NumericalFailure(fmt::format("unstable: {} negative, {} zero modes ({})", negative, zero, where),
                           FailureMode::Equilibrium);
  }
  throw NumericalFailure(fmt::format("mechanism: {} zero modes ({})", zero, where), FailureMode::Equilibrium);
}

}  // namespace

Eigen::Index eigenvalues_below(const Sparse& h, double shift) {
  Sparse shifted = h;
  for (Eigen::Index i = 0; i < h.rows(); ++i) shifted.coeffRef(i, i) -= shift;
  const Cholesky factor(shifted);
  if (factor.info() != Eigen::Success)
    throw NumericalFailure("singular: its zero modes cannot be counted", FailureMode::Equilibrium);
  return (factor.vectorD().array() < 0.0).count();
}

DofMap::DofMap(const FixedDofs& held) : number(held.size()) {
  for (Eigen::Index i = 0; i < held.size(); ++i) number[i] = held.data()[i] ? -1 : count++;
}

Eigen::VectorXd DofMap::gather(const Positions& all) const {
  Eigen::VectorXd free(count);
  for (Eigen::Index i = 0; i < number.size(); ++i) {
    if (number[i] >= 0) free[number[i]] = all.data()[i];
  }
  return free;
}

Positions DofMap::scatter(const Eigen::VectorXd& free, double scale) const {
  Positions all = Positions::Zero(number.size() / 3, 3);
  for (Eigen::Index i = 0; i < number.size(); ++i) {
    if (number[i] >= 0) all.data()[i] = scale * free[number[i]];
  }
  return all;
}

Sparse DofMap::restrict(const std::vector<Eigen::Triplet<double>>& entries) const {
  std::vector<Eigen::Triplet<double>> kept;
  kept.reserve(entries.size());
  for (const auto& t : entries) {
    if (number[t.row()] >= 0 && number[t.col()] >= 0)
      kept.emplace_back(number[t.row()], number[t.col()], t.value());
  }
  Sparse h(count, count);
  h.setFromTriplets(kept.begin(), kept.end());
  // This is when a static solution takes the most memory.
  const parts::Built assembly(parts::Kind::Hessian, parts::array_bytes(entries, kept) + bytes_of(h));
  return h;
}

double bytes_of(const Sparse& h) {
  return static_cast<double>(h.data().allocatedSize()) * (sizeof(double) + sizeof(int)) +
         static_cast<double>(h.outerSize() + 1) * sizeof(int);
}

double bytes_of(const Cholesky& factor) {
  if (factor.rows() == 0) return 0.0;
  return bytes_of(factor.matrixL().nestedExpression()) +
         static_cast<double>(factor.rows()) * (sizeof(double) + 4 * sizeof(int));
}

void factorize_stable(Cholesky& factor, const Sparse& h, int newton_step) {
  factor.factorize(h);
  const double norm = infinity_norm(h);
  if (!std::isfinite(norm)) {
    throw NumericalFailure(fmt::format("stiffnesses leave double precision at Newton step {}", newton_step),
                           FailureMode::NotFinite);
  }
  // A small pivot by itself is no proof of a zero mode (long chains have them), so the count decides.
  const bool suspicious =
      factor.info() != Eigen::Success || !(smallest(factor.vectorD()) > 100.0 * zero_mode * norm);
  if (suspicious && !planted(Mutant::mechanisms_accepted) &&
      (!(norm > 0.0) || eigenvalues_below(h, zero_mode * norm) > 0))
    fail_as_singular(h, newton_step);
}

double infinity_norm(const Sparse& h) {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(h.rows());
  for (Eigen::Index k = 0; k < h.outerSize(); ++k) {
    for (Sparse::InnerIterator it(h, k); it; ++it) sums[it.row()] += std::abs(it.value());
  }
  return largest(sums);
}

}  // namespace veriflex::solid
