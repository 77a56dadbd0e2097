#include "scene/alternating_growth.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/mutant.hpp"
#include "solid/dof_map.hpp"
#include "solid/symmetric_eigenvalue.hpp"

namespace veriflex::scene {

namespace {

using Vector = Eigen::VectorXd;
using Sparse = Eigen::SparseMatrix<double>;

constexpr double scale_tolerance = 1e-11;  // of the largest eigenvalues of K and A
// Of K or A; below, a dense solver is faster, and cannot fail as Lanczos' method does where a matrix has so
// few different eigenvalues (a single bond: two) that the Krylov space ends at once.
constexpr Eigen::Index dense_matrix = 200;
constexpr double room_below = 0.02;    // of 1 + cos(n theta), which the polynomials divide by
constexpr int most_terms = 200;        // of a polynomial; `room_below` needs 60
constexpr double series_ends = 1e-14;  // last coefficient over the largest
constexpr double overflow =
    1e100;  // of a matrix: beyond, its norm is all that is known, and all that is asked
constexpr double farthest_growth = 1e6;  // per step; beyond, the factor is not looked for more closely

double largest_of(const Sparse& matrix, const char* what) {
  if (matrix.rows() == 0) return 0.0;
  const double norm = solid::infinity_norm(matrix);
  if (norm == 0.0 || !(norm < overflow)) return norm;
  if (matrix.rows() <= dense_matrix) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(Eigen::MatrixXd(matrix), Eigen::EigenvaluesOnly)
        .eigenvalues()
        .maxCoeff();
  }
  const auto product = [&](const Vector& x) -> Vector { return matrix * x; };
  return solid::largest_eigenvalue(product, matrix.rows(), scale_tolerance, what);
}

/// g(K) for a function g that is smooth over [0, stiffest], as a series of Chebyshev polynomials.
class FunctionOfStiffness {
 public:
  template <class G>
  FunctionOfStiffness(const Sparse& K, double stiffest, G g) : K_(K), stiffest_(stiffest) {
    Vector values(most_terms);
    const double half = std::numbers::pi / most_terms;
    for (int i = 0; i < most_terms; ++i) values[i] = g(0.5 * stiffest * (1.0 - std::cos((i + 0.5) * half)));
    for (int j = 0; j < most_terms; ++j) {
      double sum = 0.0;
      for (int i = 0; i < most_terms; ++i) sum += values[i] * std::cos(j * (i + 0.5) * half);
      terms_.push_back((j == 0 ? 1.0 : 2.0) / most_terms * sum);
    }
    const double largest = values.cwiseAbs().maxCoeff();
    while (terms_.size() > 1 && std::abs(terms_.back()) < series_ends * largest) terms_.pop_back();
  }

  Vector operator()(const Vector& x) const {  // Clenshaw's recurrence
    Vector b = Vector::Zero(x.size()), after = b;
    for (std::size_t j = terms_.size() - 1; j > 0; --j) {
      Vector now = terms_[j] * x + 2.0 * mapped(b) - after;
      after = std::move(b);
      b = std::move(now);
    }
    return terms_[0] * x + mapped(b) - after;
  }

 private:
  Vector mapped(const Vector& x) const { return x - 2.0 / stiffest_ * (K_ * x); }  // to [-1, 1]

  const Sparse& K_;
  double stiffest_;
  std::vector<double> terms_;
};

/// Q of one axis, as the rounds of forcing build it.
Eigen::MatrixXd rounds_of(const CoupledStep& step) {
  const Eigen::Index n = step.exchange().rows();
  const double V = step.marker_volume();
  Eigen::MatrixXd missing = Eigen::MatrixXd::Identity(n, n), sum = missing;
  for (int round = 1; round < step.forcing_iterations(); ++round) {
    missing -= V * (step.exchange() * missing);
    sum += missing;
  }
  return V * sum;
}

}  // namespace

Scales scales_of(const CoupledStep& step) {
  return {largest_of(step.stiffness(), "largest eigenvalue of the stiffness"),
          largest_of(step.answering(), "largest eigenvalue of the exchange")};
}

std::optional<AlternatingGrowth> AlternatingGrowth::of(const CoupledStep& step, const Scales& scales) {
  constexpr double most_rounds_markers = 2000;  // a dense matrix of them is factorised
  if (!step.is_uniform()) return std::nullopt;
  const int n = step.substeps();
  const double stiffest = scales.stiffness * (1.0 + 1e-9);
  const double cosine = 1.0 - stiffest / (2.0 * step.node_mass() * n * n);
  const bool slow =
      cosine > std::cos(std::numbers::pi / n) && 1.0 + std::cos(n * std::acos(cosine)) > room_below;
  if (step.is_implicit() || step.is_subcycled() || step.is_damped() || !slow ||
      !(scales.answered < 2.0 - 1e-9))
    return std::nullopt;
  if (step.forcing_iterations() > 1 && static_cast<double>(step.exchange().rows()) > most_rounds_markers)
    return std::nullopt;
  // A mode of negative stiffness -k grows by at most 1 + sqrt(k/m), whatever the fluid does.
  constexpr double fastest = 1e-2;
  double own_growth = growth_resolution;
  while (solid::eigenvalues_below(step.stiffness(), -step.node_mass() * own_growth * own_growth) > 0) {
    own_growth *= 2.0;
    if (own_growth > fastest) return std::nullopt;
  }
  AlternatingGrowth growth(step, stiffest, own_growth);
  if (step.forcing_iterations() > 1) growth.root_of_Q_ = rounds_of(step).llt().matrixL();
  return growth;
}

double AlternatingGrowth::excess(double rho, double tolerance) const {
  const int n = step_.substeps();
  const double m = step_.node_mass();
  const FunctionOfStiffness mobility(step_.stiffness(), stiffest_, [&](double stiffness) {
    const double theta = std::acos(1.0 - stiffness / (2.0 * m * n * n));
    const double b = theta > 0.0 ? std::sin(n * theta) / (n * std::sin(theta)) : 1.0;
    return (rho + 1.0) / m * b /
           (rho * rho + 2.0 * rho * std::cos((planted(Mutant::growth_of_one_substep) ? 1 : n) * theta) + 1.0);
  });
  const Eigen::Index markers = step_.exchange().rows();
  const auto each_axis = [&](const auto& matrix, const Vector& x) {
    Vector y(x.size());
    for (Eigen::Index a = 0; a < 3; ++a)
      y.segment(a * markers, markers) = matrix * x.segment(a * markers, markers);
    return y;
  };
  const bool plain = root_of_Q_.size() == 0;
  // Q^(1/2) [...] Q^(1/2) of the head of the file, L^T [...] L in truth.
  const auto product = [&](const Vector& x) -> Vector {
    const Vector force = plain ? Vector(std::sqrt(step_.marker_volume()) * x) : each_axis(root_of_Q_, x);
    Vector velocity = step_.at_markers(mobility(step_.at_coordinates(force)));
    if (step_.memory() == FluidMemory::Keeps) velocity += step_.exchanged(force) / (rho + 1.0);
    return plain ? Vector(std::sqrt(step_.marker_volume()) * velocity)
                 : each_axis(root_of_Q_.transpose(), velocity);
  };
  return solid::largest_eigenvalue(product, 3 * markers, tolerance, "growth of the exchange") - 1.0;
}

// Not more closely than that: near the critical mass many modes are about as strong as the strongest, and
// telling them apart takes a hundred times the products.
bool AlternatingGrowth::exceeds(double factor) const { return excess(factor, 0.1 * growth_resolution) > 0.0; }

double AlternatingGrowth::factor() const {
  constexpr double accuracy = 1e-9, tolerance = 1e-9;
  double below = 1.0 + growth_resolution, above = 1.0 + 2.0 * growth_resolution;
  if (!exceeds(below)) return 1.0;
  double most = excess(below, tolerance);
  double least = excess(above, tolerance);
  while (least > 0.0) {
    below = above;
    most = least;
    above = 1.0 + 4.0 * (above - 1.0);
    if (above > farthest_growth) return below;
    least = excess(above, tolerance);
  }
  // False position; the end that stays is given half its weight (Illinois), for each value is a Lanczos run.
  while (above - below > accuracy * below) {
    const double between = std::clamp(below + (above - below) * most / (most - least), below + 0.1 * accuracy,
                                      above - 0.1 * accuracy);
    const double found = excess(between, tolerance);
    if (found > 0.0) {
      below = between;
      most = found;
      least *= 0.5;
    } else {
      above = between;
      least = found;
      most *= 0.5;
    }
    if (std::abs(found) < tolerance) return between;
  }
  return 0.5 * (below + above);
}

}  // namespace veriflex::scene
