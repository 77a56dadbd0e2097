#include "analytic/straining_filament.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/error.hpp"

namespace veriflex::analytic {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index degrees = 19;  // of Legendre polynomials; monomials of more would lose digits

/// Coefficients of the Legendre polynomials, a column each.
MatrixXd legendre() {
  MatrixXd p = MatrixXd::Zero(degrees, degrees);
  p(0, 0) = p(1, 1) = 1.0;
  for (Index n = 1; n + 1 < degrees; ++n) {
    const auto order = static_cast<double>(n);
    p.col(n + 1) = -order * p.col(n - 1);
    p.col(n + 1).tail(degrees - 1) += (2.0 * order + 1.0) * p.col(n).head(degrees - 1);
    p.col(n + 1) /= order + 1.0;
  }
  return p;
}

VectorXd derivative(const VectorXd& p) {
  VectorXd d = VectorXd::Zero(p.size());
  for (Index i = 1; i < p.size(); ++i) d[i - 1] = static_cast<double>(i) * p[i];
  return d;
}

VectorXd times_t(const VectorXd& p) {
  VectorXd q = VectorXd::Zero(p.size());
  q.tail(p.size() - 1) = p.head(p.size() - 1);
  return q;
}

/// Integral of the product from -1 to 1.
double product(const VectorXd& p, const VectorXd& q) {
  double sum = 0.0;
  for (Index i = 0; i < p.size(); ++i)
    for (Index j = i % 2; j < q.size(); j += 2) sum += p[i] * q[j] * 2.0 / static_cast<double>(i + j + 1);
  return sum;
}

/// Of displacements w: the bending energy over their square, without the stiffness.
double curved(const VectorXd& w) {
  const Index inner = w.size() - 2;
  return (w.head(inner) - 2.0 * w.segment(1, inner) + w.tail(inner)).squaredNorm() / w.squaredNorm();
}

}  // namespace

VectorXd slender_growth(double eta) {
  // Galerkin's method in t = 2 s: w + t w' + 1/4 (t^2 - 1) w'' - 16 w''''/eta, twice integrated by parts, so
  // that the ends are free. Constants and t are the rigid modes; what is left of the others is found without
  // them, because the matrix maps them onto themselves.
  const MatrixXd p = legendre();
  MatrixXd a(degrees, degrees);
  for (Index j = 0; j < degrees; ++j) {
    const VectorXd first = derivative(p.col(j)), second = derivative(first);
    const VectorXd flow = p.col(j) + times_t(first) + 0.25 * (times_t(times_t(second)) - second);
    for (Index i = 0; i < degrees; ++i) {
      const VectorXd curvature = derivative(derivative(p.col(i)));
      a(i, j) = (product(p.col(i), flow) - 16.0 / eta * product(curvature, second)) *
                (static_cast<double>(i) + 0.5);
    }
  }
  VectorXd growth = a.bottomRightCorner(degrees - 2, degrees - 2).eigenvalues().real();
  std::sort(growth.begin(), growth.end(), std::greater<>());
  return growth;
}

double slender_drag(double radius_over_length) {
  return 8.0 * std::numbers::pi / -std::log(radius_over_length * radius_over_length * std::numbers::e);
}

MatrixXd rate_of(const StrainedChain& chain) {
  const Index n = chain.stream.size();
  const MatrixXd along = by_distance(chain.mobility.along), across = by_distance(chain.mobility.across);
  const MatrixXd turned = by_signed_distance(chain.mobility.turned);
  // At rest along the axis: each marker is held against the stream by the difference of its bonds' tensions.
  const VectorXd held = -along.partialPivLu().solve(chain.stream);
  MatrixXd elastic = MatrixXd::Zero(n, n);
  double tension = 0.0;
  for (Index i = 0; i + 1 < n; ++i) {
    tension += held[i];
    elastic(i, i) -= tension;
    elastic(i, i + 1) += tension;
    elastic(i + 1, i) += tension;
    elastic(i + 1, i + 1) -= tension;
  }
  const Eigen::Vector3d bent(1.0, -2.0, 1.0);
  for (Index i = 1; i + 1 < n; ++i) {
    elastic.block<3, 3>(i - 1, i - 1) -= chain.angle_stiffness * bent * bent.transpose();
  }
  MatrixXd rate = across * elastic;
  // What acts along the axis moves a marker across it as far as one stands beside the other.
  rate.diagonal() += chain.stretching + turned * held;
  rate -= turned * held.asDiagonal();
  return rate;
}

EvenModes even_modes(const MatrixXd& rate) {
  // Of markers that are displaced alike on both sides: a matrix of the middle one and those behind it.
  const Index n = rate.rows(), half = n / 2;
  MatrixXd fold = MatrixXd::Zero(half + 1, n), unfold = MatrixXd::Zero(n, half + 1);
  for (Index i = 0; i <= half; ++i) {
    fold(i, half + i) += 0.5;
    fold(i, half - i) += 0.5;
    unfold(half + i, i) = unfold(half - i, i) = 1.0;
  }
  const Eigen::EigenSolver<MatrixXd> solver(fold * rate * unfold);
  const MatrixXd inverse = solver.eigenvectors().inverse().real();
  std::vector<ChainMode> modes;
  for (Index m = 0; m <= half; ++m) {
    if (solver.eigenvalues()[m].imag() != 0.0) continue;
    const VectorXd shape = unfold * solver.eigenvectors().col(m).real();
    const VectorXd dual = fold.transpose() * inverse.row(m).transpose();
    const double size = shape.cwiseAbs().maxCoeff() * (shape[half] < 0.0 ? -1.0 : 1.0);
    modes.push_back({solver.eigenvalues()[m].real(), shape / size, dual * size});
  }
  std::sort(modes.begin(), modes.end(),
            [](const ChainMode& a, const ChainMode& b) { return curved(a.shape) < curved(b.shape); });
  if (modes.size() < 2 || curved(modes[1].shape) > 10.0 * std::pow(4.73 / static_cast<double>(n), 4)) {
    throw NumericalFailure(
        "the chain drifts off its axis as fast as it buckles: its modes are not told apart (both grow "
        "alike). Give "
        "another stiffness");
  }
  return {modes[0], modes[1]};
}

}  // namespace veriflex::analytic
