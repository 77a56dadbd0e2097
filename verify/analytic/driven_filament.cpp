#include "analytic/driven_filament.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace veriflex::analytic {

namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;
using std::numbers::pi;

/// 1, -2, 1 at each inner marker.
MatrixXd bends(Index markers) {
  MatrixXd bend = MatrixXd::Zero(markers - 2, markers);
  for (Index i = 0; i + 2 < markers; ++i) bend.row(i).segment<3>(i) << 1.0, -2.0, 1.0;
  return bend;
}

}  // namespace

double endless_thrust(FilamentDrive drive, double bending_length) {
  const double root = std::numbers::sqrt2;
  if (drive == FilamentDrive::Hinged) return 1.0 / (4.0 * root);
  if (drive == FilamentDrive::Clamped) return 0.25;
  return 0.25 * (2.0 - root) * bending_length * bending_length;
}

double slender_thrust(FilamentDrive drive, double sperm_number) {
  // In units of l: w = sum a exp(k s), k^4 = - i. Each exponential is taken over its largest value.
  Eigen::Vector4cd k, last;
  for (int n = 0; n < 4; ++n) k[n] = std::polar(1.0, pi * (4.0 * n - 1.0) / 8.0);
  const Eigen::Vector4d largest = sperm_number * k.real().cwiseMax(0.0);
  const auto scaled = [&](double s) { return Eigen::Vector4cd((s * k - largest).array().exp()); };
  const Eigen::Vector4cd at_drive = scaled(0.0), at_end = scaled(sperm_number);
  const auto derivative = [&](const Eigen::Vector4cd& at, int order) {
    return Eigen::RowVector4cd((at.array() * k.array().pow(order)).transpose());
  };
  Eigen::Matrix4cd conditions;
  conditions << derivative(at_drive, 0), derivative(at_drive, drive == FilamentDrive::Hinged ? 2 : 1),
      derivative(at_end, 2), derivative(at_end, 3);
  const bool turns = drive == FilamentDrive::Angle;
  const Eigen::Vector4cd driven = Eigen::Vector4cd::Unit(turns ? 1 : 0);
  const Eigen::Vector4cd a = conditions.partialPivLu().solve(driven);
  Complex sum = 0.0;  // int i w conj(w') ds
  for (int m = 0; m < 4; ++m) {
    for (int n = 0; n < 4; ++n) {
      const Complex ends = at_end[m] * std::conj(at_end[n]) - at_drive[m] * std::conj(at_drive[n]);
      sum += Complex(0.0, 1.0) * a[m] * std::conj(a[n] * k[n]) * ends / (k[m] + std::conj(k[n]));
    }
  }
  return -0.5 * sum.real() / endless_thrust(drive, 1.0);
}

RodDrag slender_drags(double radius_over_length) {
  const double slenderness = -std::log(radius_over_length);
  return {4.0 * pi / (slenderness + 0.5), 2.0 * pi / (slenderness - 0.5)};
}

RodDrag towed_drags(const Mobility& mobility) {
  const auto mean_force = [](const VectorXd& of) {
    const VectorXd force = by_distance(of).partialPivLu().solve(VectorXd::Ones(of.size()));
    return force.mean();
  };
  return {mean_force(mobility.across), mean_force(mobility.along)};
}

std::vector<std::int32_t> driven_markers(FilamentDrive drive) {
  if (drive == FilamentDrive::Hinged) return {0};
  if (drive == FilamentDrive::Clamped) return {0, 1};
  return {1};
}

ChainStroke stroke_of(const DrivenChain& chain) {
  const Index n = chain.steady.across.size();
  const Complex i_omega(0.0, chain.omega);
  const MatrixXcd drag = by_distance(chain.mobility.across).partialPivLu().inverse();
  const MatrixXd bend = bends(n);
  MatrixXcd balance = i_omega * drag;
  balance += chain.angle_stiffness * bend.transpose() * bend;
  balance.diagonal().array() -= chain.omega * chain.omega * chain.node_mass;
  // The rows of what is held or driven are known.
  VectorXcd given = VectorXcd::Zero(n);
  const std::vector<std::int32_t> driven = driven_markers(chain.drive);
  for (Index i = 0; i <= driven.back(); ++i) {
    balance.row(i) = VectorXcd::Unit(n, i).transpose();
    given[i] = std::find(driven.begin(), driven.end(), i) == driven.end() ? 0.0 : 1.0;
  }
  VectorXcd shape = balance.partialPivLu().solve(given);

  // Of second order in the amplitude: forces on the fluid across the line move markers along it that stand
  // beside those on which they act. Nothing moves along the line in the mean, so that these are held there.
  const VectorXcd across = drag * (i_omega * shape);
  const MatrixXcd turned = by_signed_distance(chain.mobility.turned);
  VectorXd moved(n);
  for (Index i = 0; i < n; ++i) {
    const VectorXcd beside = VectorXcd::Constant(n, shape[i]) - shape;
    moved[i] = 0.5 * beside.dot(turned.row(i).transpose().cwiseProduct(across)).real();
  }
  const VectorXd along = by_distance(chain.steady.along).partialPivLu().solve(moved);
  return {std::move(shape), -along.sum()};
}

}  // namespace veriflex::analytic
