#include "scene/transient_growth.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "scene/krylov.hpp"
#include "scene/simulated_step.hpp"

namespace veriflex::scene {

namespace {

using Vector = SimulatedStep::Vector;

constexpr Eigen::Index dimensions = 40;

/// The largest eigenvalue of a symmetric operator in a Krylov space: from below, and soon where many are
/// alike, which have no vectors of their own to converge to.
template <class Product>
double largest_ritz_value(const Product& product, const Vector& start) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(krylov(product, start, dimensions).projected,
                                                              Eigen::EigenvaluesOnly);
  return solver.eigenvalues().tail(1)[0];
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
