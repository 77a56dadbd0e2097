/// Harmonic angle between two bonds of a node, resting at 90 or 180 degrees. [wu-qi-2014, Eq. 14]
///
///   U = 1/2 k_a (theta - theta0)^2,  theta between a and b, both pointing away from the node
///
/// The deviation is computed directly, never as a difference of angles: with s = |a x b| and c = a.b it is
/// -atan2(s, -c) for 180 degrees and -atan2(c, s) for 90. Where acos and its gradient are singular (180
/// degrees), energy, gradient and Hessian here are exact: they contain only rho = deviation/s, which is
/// smooth there. Defined unless a or b is zero, a straight angle is folded back (theta = 0), or a right one
/// is flat (theta = 0 or 180).
#pragma once

#include <cmath>
#include <numbers>

#include "base/mutant.hpp"
#include "base/vec.hpp"

namespace veriflex::solid {

/// a d - b c with a relative error of a rounding or two, however much cancels (Kahan).
inline double difference_of_products(double a, double d, double b, double c) {
  const double bc = b * c;
  return std::fma(a, d, -bc) + std::fma(-b, c, bc);
}

/// a x b with the relative precision of difference_of_products: near 180 degrees a plain cross product would
/// keep no digits.
inline Vec3 precise_cross(const Vec3& a, const Vec3& b) {
  return {difference_of_products(a.y(), b.z(), a.z(), b.y()),
          difference_of_products(a.z(), b.x(), a.x(), b.z()),
          difference_of_products(a.x(), b.y(), a.y(), b.x())};
}

struct AngleState {
  Vec3 w;     // a x b
  double s2;  // |w|^2
  double c;   // a.b
  double deviation;
  double rho;  // deviation / |w|
};

inline AngleState angle_state(const Vec3& a, const Vec3& b, bool straight) {
  AngleState t;
  t.w = precise_cross(a, b);
  t.s2 = t.w.squaredNorm();
  t.c = a.dot(b);
  const double s = std::sqrt(t.s2);
  t.deviation = straight ? (planted(Mutant::straight_angle_by_acos)
                                ? std::acos(t.c / (a.norm() * b.norm())) - std::numbers::pi
                                : -std::atan2(s, -t.c))
                         : -std::atan2(t.c, s);
  // atan(x)/x = 1 - x^2/3 + ... with x = s/-c below 1e-8 is 1 to the last bit.
  t.rho = straight && s <= -1e-8 * t.c ? 1.0 / t.c : t.deviation / s;
  return t;
}

/// Whether the gradient exists, with a margin of about 1e-6 of an angle: see the head of this file. False for
/// NaN.
inline bool is_defined(const Vec3& a, const Vec3& b, bool straight) {
  const double c = a.dot(b);
  return (straight && c < 0.0) || c * c < (1.0 - 1e-12) * a.squaredNorm() * b.squaredNorm();
}

/// Gradient of U/k_a by a and by b; that by the node is minus their sum  [L^-1].
struct AngleGradient {
  Vec3 a, b;
};

inline AngleGradient angle_gradient(const AngleState& t, const Vec3& a, const Vec3& b) {
  return {t.rho / a.squaredNorm() * a.cross(t.w), -t.rho / b.squaredNorm() * b.cross(t.w)};
}

/// Second derivatives of U/k_a by (a, b); the one by (b, a) is the transpose of ab  [L^-2].
struct AngleHessian {
  Mat3 aa, ab, bb;
};

AngleHessian angle_hessian(const AngleState& t, const Vec3& a, const Vec3& b);

}  // namespace veriflex::solid
