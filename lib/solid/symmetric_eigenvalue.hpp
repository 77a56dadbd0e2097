/// The largest eigenvalue of a symmetric operator by Lanczos' method (Spectra), believed only with its
/// residual.
#pragma once

#include <Spectra/SymEigsSolver.h>
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <exception>

#include "base/error.hpp"
#include "base/stop.hpp"

namespace veriflex::solid {

constexpr int lanczos_restarts = 5000;

/// |A x - lambda x| <= accuracy for a vector x of unit length: what the solver reports of itself is held
/// against a product of its own, for a Krylov space that has collapsed reports whatever it likes.
template <class Product>
bool is_eigenpair(const Product& product, double eigenvalue, const Eigen::VectorXd& x, double accuracy) {
  if (!(std::abs(x.norm() - 1.0) < 1e-6)) return false;
  Eigen::VectorXd image(x.size());
  product.perform_op(x.data(), image.data());
  return (image - eigenvalue * x).norm() <= accuracy;
}

/// A product that a signal can stop between two applications.
template <class Product>
class Stoppable {
 public:
  using Scalar = double;
  explicit Stoppable(const Product& product) : product_(product) {}
  Eigen::Index rows() const { return product_.rows(); }
  Eigen::Index cols() const { return product_.cols(); }
  void perform_op(const double* x, double* y) const {
    stop_if_asked("Lanczos product", ++count_);
    product_.perform_op(x, y);
  }

 private:
  const Product& product_;
  mutable std::int64_t count_ = 0;
};

/// `product` has rows(), cols() and perform_op(x, y) with y = A x, and is not zero. Throws NumericalFailure,
/// which names `what`, when the iteration does not converge or its answer is no eigenvalue.
template <class Product>
double largest_eigenvalue(Product& product, double tolerance, const char* what) {
  const Eigen::Index krylov = std::min<Eigen::Index>(product.rows(), 30);
  Stoppable<Product> stoppable(product);
  Spectra::SymEigsSolver<Stoppable<Product>> solver(stoppable, 1, krylov);
  try {
    solver.init();
    solver.compute(Spectra::SortRule::LargestAlge, lanczos_restarts, tolerance);
  } catch (const NumericalFailure&) {
    throw;
  } catch (const std::exception& failure) {  // Spectra's own, of numbers that are none
    throw NumericalFailure(fmt::format("{} not found: {}", what, failure.what()), FailureMode::NotConverged);
  }
  if (solver.info() != Spectra::CompInfo::Successful ||
      !is_eigenpair(product, solver.eigenvalues()[0], solver.eigenvectors().col(0),
                    100.0 * tolerance * std::abs(solver.eigenvalues()[0]))) {
    throw NumericalFailure(fmt::format("{} not found after {} Lanczos restarts", what, lanczos_restarts),
                           FailureMode::NotConverged);
  }
  return solver.eigenvalues()[0];
}

}  // namespace veriflex::solid
