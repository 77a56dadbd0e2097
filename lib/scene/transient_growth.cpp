#include "scene/transient_growth.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "scene/simulated_step.hpp"

namespace veriflex::scene {

namespace {

using Vector = SimulatedStep::Vector;

/// The largest eigenvalue of a symmetric operator in a Krylov space: from below, and soon where many are
/// alike, which have no vectors of their own to converge to.
template <class Product>
double largest_ritz_value(const Product& product, Vector start) {
  constexpr Eigen::Index dimensions = 40;
  Eigen::MatrixXd basis(start.size(), dimensions);
  Eigen::MatrixXd projected = Eigen::MatrixXd::Zero(dimensions, dimensions);
  Eigen::Index size = 0;
  basis.col(0) = start.normalized();
  while (size < dimensions) {
    Vector image = product(basis.col(size));
    const double length = image.norm();
    for (int twice = 0; twice < 2; ++twice) {
      const Vector along = basis.leftCols(size + 1).transpose() * image;
      projected.col(size).head(size + 1) += along;
      image -= basis.leftCols(size + 1) * along;
    }
    ++size;
    if (size == dimensions || !(image.norm() > 1e-12 * length)) break;
    basis.col(size) = image.normalized();
  }
  const Eigen::MatrixXd symmetric = projected.topLeftCorner(size, size).selfadjointView<Eigen::Upper>();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(symmetric, Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[size - 1];
}

}  // namespace

std::vector<double> transient_growth(const Scene& scene, std::span<const std::int64_t> steps) {
  const SimulatedStep step(scene);
  const SimulatedStep::Sparse G = step.matrix(), B = step.weights(), transposed = G.transpose();
  // |x|^2 = x B x, B = L L^T: of all y = L^T x of length 1.
  const Eigen::SimplicialLLT<SimulatedStep::Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>> root(B);
  const Vector start = root.matrixU() * step.noise();
  std::vector<double> grown;
  for (const std::int64_t n : steps) {
    const auto amplified = [&](const Vector& y) {
      Vector x = step.without_neutral(root.matrixU().solve(y));
      for (std::int64_t i = 0; i < n; ++i) x = G * x;
      x = step.without_neutral_transposed(B * step.without_neutral(x));
      for (std::int64_t i = 0; i < n; ++i) x = transposed * x;
      return Vector(root.matrixL().solve(step.without_neutral_transposed(x)));
    };
    grown.push_back(std::sqrt(largest_ritz_value(amplified, start)));
  }
  return grown;
}

}  // namespace veriflex::scene
