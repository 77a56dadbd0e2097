#include "solid/symmetric_eigenvalue.hpp"

#include <Spectra/SymEigsSolver.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>

#include "base/error.hpp"
#include "base/stop.hpp"

namespace veriflex::solid {

namespace {

using Vector = Eigen::VectorXd;

constexpr int restarts = 5000;

/// The product for Spectra, which a signal can stop between two applications.
class Stoppable {
 public:
  using Scalar = double;
  Stoppable(const SymmetricProduct& product, Eigen::Index size) : product_(product), size_(size) {}
  Eigen::Index rows() const { return size_; }
  Eigen::Index cols() const { return size_; }
  void perform_op(const double* x, double* y) const {
    stop_if_asked("Lanczos product", ++count_);
    Eigen::Map<Vector>(y, size_) = product_(Eigen::Map<const Vector>(x, size_));
  }

 private:
  const SymmetricProduct& product_;
  Eigen::Index size_;
  mutable std::int64_t count_ = 0;
};

/// |A x - lambda x| <= accuracy for a vector x of unit length: what the solver reports of itself is held
/// against a product of its own, for a Krylov space that has collapsed reports whatever it likes.
bool is_eigenpair(const SymmetricProduct& product, double eigenvalue, const Vector& x, double accuracy) {
  if (!(std::abs(x.norm() - 1.0) < 1e-6)) return false;
  return (product(x) - eigenvalue * x).norm() <= accuracy;
}

Vector eigenvalues_of(const SymmetricProduct& product, Eigen::Index size, int count, Eigen::Index krylov,
                      Spectra::SortRule wanted, double tolerance, const char* what) {
  Stoppable stoppable(product, size);
  Spectra::SymEigsSolver<Stoppable> solver(stoppable, count, std::min(size, krylov));
  try {
    solver.init();
    solver.compute(wanted, restarts, tolerance);
  } catch (const NumericalFailure&) {
    throw;
  } catch (const std::exception& failure) {  // Spectra's own, of numbers that are none
    throw NumericalFailure(fmt::format("{} not found: {}", what, failure.what()), FailureMode::NotConverged);
  }
  bool found = solver.info() == Spectra::CompInfo::Successful;
  for (int i = 0; found && i < count; ++i) {
    const double eigenvalue = solver.eigenvalues()[i];
    found = is_eigenpair(product, eigenvalue, solver.eigenvectors().col(i),
                         100.0 * tolerance * std::abs(eigenvalue));
  }
  if (!found) {
    throw NumericalFailure(fmt::format("{} not found after {} Lanczos restarts", what, restarts),
                           FailureMode::NotConverged);
  }
  return solver.eigenvalues();
}

}  // namespace

double largest_eigenvalue(const SymmetricProduct& product, Eigen::Index size, double tolerance,
                          const char* what) {
  return eigenvalues_of(product, size, 1, 30, Spectra::SortRule::LargestAlge, tolerance, what)[0];
}

Vector largest_eigenvalues(const SymmetricProduct& product, Eigen::Index size, int count, double tolerance,
                           const char* what) {
  return eigenvalues_of(product, size, count, std::max(40, 3 * count), Spectra::SortRule::LargestMagn,
                        tolerance, what);
}

}  // namespace veriflex::solid
