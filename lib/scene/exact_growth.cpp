#include "scene/exact_growth.hpp"

#include <Spectra/GenEigsBase.h>
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "scene/simulated_step.hpp"

namespace veriflex::scene {

namespace {

using Vector = SimulatedStep::Vector;
using Matrix = Eigen::MatrixXd;

constexpr double accurate = 1e-5;     // of an eigenvalue: what is not linear and what is rounded leave 1e-6
constexpr double least_share = 1e-6;  // of a state without pattern that a growing one has
constexpr int restarts = 6;
constexpr Eigen::Index most_dimensions = 80;  // of the Krylov space, unless more eigenvalues are asked for

/// Some steps at a time, for Spectra.
struct Product {
  using Scalar = double;
  const SimulatedStep& step;
  int steps;
  Eigen::Index rows() const { return step.size(); }
  Eigen::Index cols() const { return step.size(); }
  void perform_op(const double* x, double* y) const {
    Eigen::Map<Vector>(y, rows()) = step.after(Eigen::Map<const Vector>(x, rows()), steps);
  }
};

/// Says that lengths are those of the step's states.
struct Weight {
  const SimulatedStep& step;
};

}  // namespace

}  // namespace veriflex::scene

/// The inner products of the factorisation. Spectra's own takes the length of a column of coefficients too,
/// to judge whether to orthogonalise once more, by the weight of states, and reads far beyond the column's
/// end; in an orthonormal basis the length of coefficients is the plain one.
template <>
class Spectra::ArnoldiOp<double, veriflex::scene::Product, veriflex::scene::Weight> {
 public:
  using Vector = Eigen::VectorXd;

  ArnoldiOp(const veriflex::scene::Product& product, const veriflex::scene::Weight& weight)
      : product_(product), weight_(weight) {}

  Eigen::Index rows() const { return product_.rows(); }

  template <class X, class Y>
  double inner_product(const X& x, const Y& y) const {
    return x.dot(weight_.step.weighted(y));
  }

  template <class X, class Y>
  void trans_product(const X& x, const Y& y, Eigen::Ref<Vector> result) const {
    result.noalias() = x.transpose() * weight_.step.weighted(y);
  }

  template <class X>
  double norm(const X& x) const {
    return x.size() == rows() ? std::sqrt(inner_product(x, x)) : x.norm();
  }

  void perform_op(const double* x, double* y) const { product_.perform_op(x, y); }

 private:
  const veriflex::scene::Product& product_;
  const veriflex::scene::Weight& weight_;
};

namespace veriflex::scene {

namespace {

using Arnoldi = Spectra::GenEigsBase<Product, Weight>;

/// An orthonormal basis of what the columns span, in the length of states.
Matrix orthonormal(const SimulatedStep& step, const Matrix& columns) {
  Matrix basis(columns.rows(), columns.cols());
  Eigen::Index size = 0;
  for (Eigen::Index i = 0; i < columns.cols(); ++i) {
    Vector x = columns.col(i);
    const double before = step.length(x);
    for (int twice = 0; twice < 2; ++twice) {
      x -= basis.leftCols(size) * (basis.leftCols(size).transpose() * step.weighted(x));
    }
    const double left = step.length(x);
    if (left <= 1e-8 * before) continue;
    basis.col(size++) = x / left;
  }
  return basis.leftCols(size);
}

/// Eigenvalues of one step in a space that many steps leave as it is.
std::vector<Eigenvalue> in_space(const SimulatedStep& step, const Matrix& basis) {
  Matrix images(basis.rows(), basis.cols());
  for (Eigen::Index i = 0; i < basis.cols(); ++i) images.col(i) = step.after(basis.col(i), 1);
  Matrix projected(basis.cols(), basis.cols());
  for (Eigen::Index i = 0; i < basis.cols(); ++i) {
    projected.col(i) = basis.transpose() * step.weighted(images.col(i));
  }
  const Eigen::EigenSolver<Matrix> solver(projected);
  if (solver.info() != Eigen::Success) return {};
  std::vector<Eigenvalue> found;
  for (Eigen::Index i = 0; i < basis.cols(); ++i) {
    const std::complex<double> value = solver.eigenvalues()[i];
    const Eigen::VectorXcd in_basis = solver.eigenvectors().col(i).normalized();
    const Eigen::VectorXcd x = basis * in_basis;
    const Eigen::VectorXcd left = images * in_basis - value * x;
    const double residual = std::hypot(step.length(left.real()), step.length(left.imag()));
    const double re = step.length(x.real()), im = step.length(x.imag());
    const double bodies = re * re * (re > 0.0 ? step.share_of_bodies(x.real()) : 0.0) +
                          im * im * (im > 0.0 ? step.share_of_bodies(x.imag()) : 0.0);
    found.push_back({value, residual, bodies / (re * re + im * im)});
  }
  std::sort(found.begin(), found.end(), [](const Eigenvalue& a, const Eigenvalue& b) {
    if (std::abs(a.value) != std::abs(b.value)) return std::abs(a.value) > std::abs(b.value);
    return a.value.imag() > b.value.imag();
  });
  return found;
}

/// Nothing unless all that were asked for converged, and are eigenvalues.
std::vector<Eigenvalue> leading(const SimulatedStep& step, const Vector& start, int count, int steps,
                                Eigen::Index dimensions) {
  Product product{step, steps};
  const Weight weight{step};
  const Eigen::Index wanted = std::min<Eigen::Index>(count, step.size() - 2);
  const Eigen::Index krylov =
      std::min<Eigen::Index>(step.size(), std::max<Eigen::Index>(dimensions, 3 * wanted));
  Arnoldi arnoldi(product, weight, wanted, krylov);
  arnoldi.init(start.data());
  arnoldi.compute(Spectra::SortRule::LargestMagn, restarts, accurate * 0.1);
  if (arnoldi.info() != Spectra::CompInfo::Successful) return {};
  const Eigen::MatrixXcd vectors = arnoldi.eigenvectors();
  Matrix parts(step.size(), 2 * vectors.cols());
  for (Eigen::Index i = 0; i < vectors.cols(); ++i) {
    parts.col(2 * i) = vectors.col(i).real();
    parts.col(2 * i + 1) = vectors.col(i).imag();
  }
  std::vector<Eigenvalue> found = in_space(step, orthonormal(step, parts));
  if (found.empty() || !(found.front().residual <= accurate)) return {};
  const auto bad =
      std::find_if(found.begin(), found.end(), [](const Eigenvalue& e) { return !(e.residual <= accurate); });
  found.erase(bad, found.end());
  return found;
}

}  // namespace

ExactGrowth exact_growth(const Scene& scene, const GrowthSearch& search) {
  const SimulatedStep step(scene);
  Vector state = step.noise();
  std::int64_t run = 0, wanted = 250;
  int at_once = 1, together = 33;
  Eigen::Index dimensions = 20;
  double last = 1.0;  // growth of the last steps that were made together
  while (true) {
    while (run < wanted) {
      Vector next = step.after(state, at_once);
      const double grown = step.length(next);
      last = std::pow(grown, 1.0 / at_once);
      run += at_once;
      state = next / grown;
      // As many as let a state grow or decay by some orders of magnitude only.
      at_once = std::abs(std::log(grown)) > 4.0 ? std::max(1, at_once / 2) : std::min(64, 2 * at_once);
    }
    // Not so many that a state leaves what is linear, or sinks into the rounding of a step.
    int steps = together;
    while (steps > 1 && std::abs(std::log(last)) * steps > std::log(100.0)) steps = (steps - 1) / 2;
    const std::vector<Eigenvalue> found =
        leading(step, state, search.eigenvalues, std::max(1, steps), dimensions);
    if (!found.empty()) {
      const double factor = planted(Mutant::growth_seen_too_small) ? std::sqrt(std::abs(found.front().value))
                                                                   : std::abs(found.front().value);
      // A state of the least share, had it grown by more, would have come to be the larger.
      const double unseen = factor * std::pow(least_share, -1.0 / static_cast<double>(run));
      const double resolution = std::max(accurate, factor > 1.0 + accurate ? 0.0 : unseen - 1.0);
      if (resolution <= search.resolution) {
        return {factor, found.front().residual, resolution, found, step.steps_made()};
      }
    } else {
      together = 2 * together + 1;  // odd: 1 and -1 are told apart
      // Nodes that are not coupled swing undamped: more pairs of the same magnitude than fit in.
      dimensions = std::min<Eigen::Index>(2 * dimensions, most_dimensions);
    }
    wanted *= 2;
    if (step.steps_made() > search.most_steps) {
      throw NumericalFailure(fmt::format("the growth of the scene was not found to {:.2g} in {} steps: {}",
                                         search.resolution, step.steps_made(),
                                         found.empty() ? "its leading eigenvalues lie too close to each other"
                                                       : "something decays too slowly to tell what does not"),
                             FailureMode::NotConverged);
    }
  }
}

namespace {

Scene with_masses(Scene scene, double factor) {
  for (Body& body : scene.bodies) body.conditions.node_mass *= factor;
  return scene;
}

}  // namespace

double critical_mass_factor(const Scene& scene, double guess, double accuracy, const GrowthSearch& search) {
  constexpr double below = 0.97;  // of the guess: growth is found sooner than that there is none
  constexpr double stride = 1.05;
  constexpr double farthest = 1000.0;
  GrowthSearch leading = search;
  leading.eigenvalues = 1;
  double unstable = 0.0, stable = INFINITY;  // logarithms of factors, where known
  double log_growth = 0.0, slope = 0.0;      // of the growth at `unstable`, and how it falls there
  bool is_unstable_known = false, is_slope_known = false;
  double next = std::log(below * guess), step = std::log(stride);
  while (true) {
    const ExactGrowth found = exact_growth(with_masses(scene, std::exp(next)), leading);
    if (found.grows()) {
      const double grown = std::log(found.factor);
      is_slope_known = is_unstable_known && grown < log_growth;
      if (is_slope_known) slope = (log_growth - grown) / (next - unstable);
      unstable = next;
      log_growth = grown;
      is_unstable_known = true;
    } else {
      stable = next;
    }
    if (!is_unstable_known) {
      next -= step;
      step *= 2.0;
      if (next < -std::log(farthest)) return 0.0;
      continue;
    }
    if (stable - unstable <= accuracy) return std::exp(0.5 * (stable + unstable));
    const double end = is_slope_known ? unstable + log_growth / slope : INFINITY;
    if (end - unstable <= accuracy && end < stable) return std::exp(end);
    if (is_slope_known && end < stable) {
      // Just below, where it grows still, slowly.
      next = std::max(end - 0.5 * accuracy, unstable + 0.25 * accuracy);
    } else if (std::isfinite(stable)) {
      next = 0.5 * (unstable + stable);
    } else {
      next = unstable + step;
      step *= 2.0;
    }
    if (next > std::log(farthest)) {
      throw NumericalFailure(
          fmt::format("no node mass up to {:.3g} times as large is stable", std::exp(unstable)),
          FailureMode::Coupling);
    }
  }
}

}  // namespace veriflex::scene
