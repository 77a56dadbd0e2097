#include "scene/transient_growth.hpp"

#include <cmath>

#include "scene/simulated_step.hpp"
#include "solid/symmetric_eigenvalue.hpp"

namespace veriflex::scene {

namespace {

using Vector = SimulatedStep::Vector;

constexpr double accurate = 1e-5;  // of the square of the amplification

}  // namespace

std::vector<double> transient_growth(const Scene& scene, std::span<const std::int64_t> steps) {
  const SimulatedStep step(scene);
  const SimulatedStep::Sparse G = step.matrix(), B = step.weights();
  // |x|^2 = x B x, B = L L^T: of all y = L^T x of length 1.
  const Eigen::SimplicialLLT<SimulatedStep::Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>> root(B);
  std::vector<double> grown;
  for (const std::int64_t n : steps) {
    const auto amplified = [&](const Vector& y) {
      Vector x = step.without_neutral(root.matrixU().solve(y));
      for (std::int64_t i = 0; i < n; ++i) x = G * x;
      x = step.without_neutral_transposed(B * step.without_neutral(x));
      for (std::int64_t i = 0; i < n; ++i) x = G.transpose() * x;
      return Vector(root.matrixL().solve(step.without_neutral_transposed(x)));
    };
    grown.push_back(
        std::sqrt(solid::largest_eigenvalue(amplified, step.size(), accurate, "transient growth")));
  }
  return grown;
}

}  // namespace veriflex::scene
