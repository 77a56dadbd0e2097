/// What forces do to markers on neighbouring nodes of a line along x, exactly as the lattice has it: D3Q15
/// BGK, 4-point kernel, forces of first order, in a periodic box without mean flow, wave by wave.
///
/// At tau = 1 it is Stokes' within 5 %, but for neighbours; at tau = 2 forces along and across the line
/// differ by a factor of two and more.
#pragma once

#include <Eigen/Core>

#include "base/grid.hpp"

namespace veriflex::analytic {

/// What is left of a wave along an axis, and of its slope over the wavenumber, at a marker on a node: 1 for
/// long waves. Of the 4-point kernel, whose first moment is exact: by others a marker that moves by a part of
/// a spacing sees a velocity change by another amount than it does.
double interpolated(double wavenumber);
double interpolated_slope(double wavenumber);

/// Velocity sum f c of steady rolls that vary along x and z with that wavenumber, per force that drives them,
/// as the lattice has it: (1 - nu k^2)/(2 nu k^2) for long waves  [T].
double roll_response(double wavenumber, double relaxation_time);

/// Velocity sum f c of markers per force on one of them, by the distance of the two in spacings.
template <class Vector>
struct MobilityOf {
  Vector along, across;  // x from x, z from z  [M^-1 T]
  Vector turned;  // d/dz of z from x: what the one that is displaced to z > 0 gets; of x from z, too  [L^-1
                  // M^-1 T]
};
using Mobility = MobilityOf<Eigen::VectorXd>;
Mobility line_mobility(const Grid& box, double relaxation_time, std::int64_t markers);

/// The same of forces and velocities that go as exp(i omega t).
using OscillatingMobility = MobilityOf<Eigen::VectorXcd>;
OscillatingMobility oscillating_line_mobility(const Grid& box, double relaxation_time, std::int64_t markers,
                                              double omega);

/// The matrix of what depends on the distance of two markers.
template <class Vector>
auto by_distance(const Vector& of) {
  using Matrix = Eigen::Matrix<typename Vector::Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  const auto at = [&of](Eigen::Index i, Eigen::Index j) { return of[i < j ? j - i : i - j]; };
  return Matrix(Matrix::NullaryExpr(of.size(), of.size(), at));
}

/// The same of what changes its sign with the side: as given where the row's marker is behind the column's.
template <class Vector>
auto by_signed_distance(const Vector& of) {
  using Matrix = Eigen::Matrix<typename Vector::Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  const auto at = [&of](Eigen::Index i, Eigen::Index j) { return i < j ? -of[j - i] : of[i - j]; };
  return Matrix(Matrix::NullaryExpr(of.size(), of.size(), at));
}

/// Radius of a sphere that a force moves in an unbounded fluid as far as one marker, which is faster than the
/// fluid around it by its slip per force  [L].
double marker_radius(double relaxation_time, double slip);

}  // namespace veriflex::analytic
