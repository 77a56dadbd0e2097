#include "solid/angle.hpp"

namespace veriflex::solid {

namespace {

// The matrix of x -> v x x.
Mat3 cross_matrix(const Vec3& v) {
  Mat3 m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

// d rho / d(s^2) at constant c: (c/(s^2 + c^2) - rho)/(2 s^2), whose terms cancel where s << |c|. There, with
// x = (s/c)^2, the series of atan gives -rho c = 1 - x/3 + x^2/5 - ... and its derivative below.
double slope_by_s2(const AngleState& t) {
  const double x = t.s2 / (t.c * t.c);
  if (t.c < 0.0 && x < 1e-4 && std::abs(t.rho * t.c) < 2.0) {
    return (-1.0 / 3.0 + x * (2.0 / 5.0 - x * (3.0 / 7.0 - x * (4.0 / 9.0)))) / (t.c * t.c * t.c);
  }
  return (t.c / (t.s2 + t.c * t.c) - t.rho) / (2.0 * t.s2);
}

}  // namespace

AngleHessian angle_hessian(const AngleState& t, const Vec3& a, const Vec3& b) {
  const double a2 = a.squaredNorm();
  const double b2 = b.squaredNorm();
  const Vec3 aw = a.cross(t.w);
  const Vec3 bw = b.cross(t.w);
  const double by_s2 = slope_by_s2(t);
  const double by_c = -1.0 / (t.s2 + t.c * t.c);
  const Vec3 rho_a = 2.0 * by_s2 * bw + by_c * b;
  const Vec3 rho_b = -2.0 * by_s2 * aw + by_c * a;
  const Mat3 ax = cross_matrix(a);
  const Mat3 bx = cross_matrix(b);
  const Mat3 wx = cross_matrix(t.w);
  return {.aa = aw * rho_a.transpose() / a2 - t.rho / a2 * (wx + ax * bx) -
                2.0 * t.rho / (a2 * a2) * aw * a.transpose(),
          .ab = aw * rho_b.transpose() / a2 + t.rho / a2 * (ax * ax),
          .bb = -bw * rho_b.transpose() / b2 - t.rho / b2 * (-wx + bx * ax) +
                2.0 * t.rho / (b2 * b2) * bw * b.transpose()};
}

}  // namespace veriflex::solid
