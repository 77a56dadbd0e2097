#include "scene/coupling_stability.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <optional>
#include <random>

#include "base/error.hpp"
#include "base/stop.hpp"
#include "scene/alternating_growth.hpp"
#include "scene/krylov.hpp"

namespace veriflex::scene {

namespace {

using Vector = Eigen::VectorXd;

constexpr Eigen::Index dense_state = 250;  // of the state; below, a dense solver is faster and cannot fail

}  // namespace

Growth dense_growth(const CoupledStep& step) {
  Eigen::MatrixXd map(step.size(), step.size());
  for (Eigen::Index i = 0; i < step.size(); ++i) map.col(i) = step.next(Vector::Unit(step.size(), i));
  if (!map.allFinite()) return {INFINITY, growth_resolution};
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(map, false);
  if (solver.info() != Eigen::Success)
    throw NumericalFailure("the growth of the exchange was not found", FailureMode::NotConverged);
  return {std::max(1.0, solver.eigenvalues().cwiseAbs().maxCoeff()), growth_resolution};
}

namespace {

/// A small motion of body and fluid without pattern, less what neither grows nor decays.
Vector start_of(const CoupledStep& step) {
  std::mt19937 random(1);  // its numbers are the same everywhere
  Vector state(step.size());
  for (double& x : state) x = 2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0;
  state.head(step.free_count()) = step.stiffness() * state.head(step.free_count()).eval();
  return (step.next(state) - state).eval();
}

/// The eigenvalue of largest magnitude in the Krylov space of a state, if its residual shows that it is one.
std::optional<double> eigenvalue_near(const CoupledStep& step, const Vector& state) {
  constexpr Eigen::Index dimensions = 20;
  constexpr double residual = 1e-8;
  const auto [basis, projected] = krylov([&](const Vector& x) { return step.next(x); }, state, dimensions);
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(projected);
  if (solver.info() != Eigen::Success) return std::nullopt;
  Eigen::Index most = 0;
  solver.eigenvalues().cwiseAbs().maxCoeff(&most);
  const std::complex<double> value = solver.eigenvalues()[most];
  const Eigen::VectorXcd vector = basis * solver.eigenvectors().col(most);
  Eigen::VectorXcd image(vector.size());
  image.real() = step.next(vector.real());
  image.imag() = step.next(vector.imag());
  if (!((image - value * vector).norm() <= residual * std::abs(value) * vector.norm())) return std::nullopt;
  return std::abs(value);
}

/// Many steps of the map. A motion that grows comes to stand alone, and its factor is then an eigenvalue's;
/// where several grow about alike it is the mean over the last half of the steps. What has not shown by the
/// end grows by less than the resolution, from a share of 1e-6 of the start.
Growth growth_in_time(const CoupledStep& step, int steps) {
  constexpr int between_looks = 250;
  constexpr int first_look = 25;  // what grows fast stands alone by then
  constexpr double least_share = 1e-6;
  Vector state = start_of(step);
  double grown = -std::log(state.norm()), middle = 0.0, end = 0.0;  // logarithms
  for (int i = 1; i <= steps; ++i) {
    const double size = state.norm();
    if (size == 0.0) return {1.0, growth_resolution};
    if (!std::isfinite(size)) return {INFINITY, growth_resolution};
    grown += std::log(size);
    state = step.next(state / size);
    end = grown + std::log(state.norm());
    if (i == steps / 2) middle = end;
    if ((i % between_looks != 0 && i != first_look) || !state.allFinite()) continue;
    stop_if_asked("the growth of the exchange, step", i);
    if (const auto found = eigenvalue_near(step, state); found && *found > 1.0 + growth_resolution) {
      return {*found, growth_resolution};
    }
  }
  constexpr double least_growth = 4.0;  // in the last half of the steps; what swings does not grow that much
  if (end - middle > std::log(least_growth)) {
    return {std::exp((end - middle) / (steps - steps / 2)), growth_resolution};
  }
  return {1.0, std::exp((std::max(end, 0.0) - std::log(least_share)) / steps) - 1.0};
}

constexpr int steps_for_growth = 4000;
constexpr int steps_for_mass = 1500;

Growth growth_of_large(const CoupledStep& step, const Scales& scales, int steps) {
  if (const auto alternating = AlternatingGrowth::of(step, scales)) {
    return {alternating->factor(), alternating->own_growth()};
  }
  return growth_in_time(step, steps);
}

bool grows(const CoupledStep& step, const Scales& scales) {
  if (step.size() <= dense_state) return dense_growth(step).grows();
  if (const auto alternating = AlternatingGrowth::of(step, scales)) {
    return alternating->exceeds(1.0 + growth_resolution);
  }
  return growth_in_time(step, steps_for_mass).grows();
}

}  // namespace

Growth large_growth(const CoupledStep& step) {
  return growth_of_large(step, scales_of(step), steps_for_growth);
}

Growth coupling_growth(const fluid::Spec& fluid, std::span<const Body> bodies, FluidMemory memory) {
  const CoupledStep step(fluid, bodies, memory);
  return step.size() <= dense_state ? dense_growth(step) : large_growth(step);
}

double answered_slip(const fluid::Spec& fluid, std::span<const Body> bodies) {
  return scales_of(CoupledStep(fluid, bodies, FluidMemory::Keeps)).answered;
}

double critical_node_mass(const fluid::Spec& fluid, const Body& body, double accuracy, FluidMemory memory) {
  constexpr double stride = 1.5;
  constexpr int most_strides = 40;
  CoupledStep step(fluid, body, memory);
  const Scales scales = scales_of(step);
  if (memory == FluidMemory::Keeps && step.couples_free_coordinates() && scales.answered >= 2.0) {
    throw NumericalFailure(
        fmt::format(
            "no node mass is stable: marker volume times the largest eigenvalue of interpolate and spread "
            "is {:.4g}, and from 2 on each step turns a slip into a larger one",
            scales.answered),
        FailureMode::Coupling);
  }
  const auto grows_at = [&](double mass) {
    step.set_node_mass(mass);
    return grows(step, scales);
  };
  // The masses that stiffness and force alone would ask for.
  const double n = step.substeps();
  double stable = 0.25 * scales.stiffness / (n * n);
  if (step.couples_free_coordinates()) stable += step.marker_volume();
  if (!(stable > 0.0)) return 0.0;
  double unstable = stable;
  int strides = 0;
  if (grows_at(stable)) {
    while (grows_at(stable)) {
      unstable = stable;
      stable *= stride;
      if (++strides > most_strides) {
        throw NumericalFailure(fmt::format("no node mass up to {:.3g} is stable", stable),
                               FailureMode::Coupling);
      }
    }
  } else {
    while (!grows_at(unstable)) {
      stable = unstable;
      unstable /= stride;
      if (++strides > most_strides) return 0.0;
    }
  }
  while (stable - unstable > accuracy * unstable) {
    const double middle = 0.5 * (stable + unstable);
    if (!(middle > unstable && middle < stable)) break;  // no number between them
    (grows_at(middle) ? unstable : stable) = middle;
  }
  return stable;
}

}  // namespace veriflex::scene
