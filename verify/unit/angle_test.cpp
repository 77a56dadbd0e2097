#include "solid/angle.hpp"

#include <cmath>
#include <numbers>

#include "catch.hpp"

using namespace veriflex;
using namespace veriflex::solid;

namespace {

// The energy in long double from the same vectors, by another route: the angle between unit vectors as
// 2 atan2(|p - q|, |p + q|), which is well conditioned at every angle.
long double independent_energy(const Vec3& a, const Vec3& b, bool straight) {
  using Wide = Eigen::Matrix<long double, 3, 1>;
  const Wide p = a.cast<long double>().normalized();
  const Wide q = b.cast<long double>().normalized();
  const long double pi = std::numbers::pi_v<long double>;
  const long double bend = 2.0L * std::atan2((p + q).norm(), (p - q).norm());  // pi - theta
  const long double deviation = straight ? bend : pi / 2.0L - bend;
  return 0.5L * deviation * deviation;
}

// Its derivative along `direction` by Richardson-extrapolated central differences.
double independent_slope(const Vec3& a, const Vec3& b, bool straight, const Vec3& da, const Vec3& db,
                         long double h) {
  const auto at = [&](long double t) {
    using Wide = Eigen::Matrix<long double, 3, 1>;
    const Wide p = (a.cast<long double>() + t * da.cast<long double>()).normalized();
    const Wide q = (b.cast<long double>() + t * db.cast<long double>()).normalized();
    const long double pi = std::numbers::pi_v<long double>;
    const long double bend = 2.0L * std::atan2((p + q).norm(), (p - q).norm());
    const long double deviation = straight ? bend : pi / 2.0L - bend;
    return 0.5L * deviation * deviation;
  };
  const long double coarse = (at(h) - at(-h)) / (2.0L * h);
  const long double fine = (at(h / 2.0L) - at(-h / 2.0L)) / h;
  return static_cast<double>((4.0L * fine - coarse) / 3.0L);
}

Vec3 at_angle(double degrees_from_180, double length) {
  const double bend = degrees_from_180 * std::numbers::pi / 180.0;
  return {-length * std::cos(bend), length * std::sin(bend), 0.0};
}

}  // namespace

TEST_CASE("The deviation of an angle is theta - theta0") {
  const Vec3 a(1.0, 0.0, 0.0);
  for (const double degrees : {0.1, 1.0, 30.0, 89.0, 120.0, 179.0}) {
    const Vec3 b = at_angle(180.0 - degrees, 1.1);
    const double theta = degrees * std::numbers::pi / 180.0;
    CHECK(angle_state(a, b, true).deviation == Approx(theta - std::numbers::pi).epsilon(1e-14).margin(1e-15));
    CHECK(angle_state(a, b, false).deviation ==
          Approx(theta - std::numbers::pi / 2.0).epsilon(1e-12).margin(1e-15));
  }
}

TEST_CASE("The gradient is that of an independent energy, at any angle") {
  const Vec3 a = Vec3(0.9, -0.2, 0.3);
  const Vec3 b = Vec3(-0.4, 1.0, 0.25);
  for (const bool straight : {true, false}) {
    const AngleGradient g = angle_gradient(angle_state(a, b, straight), a, b);
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 e = Vec3::Unit(axis);
      CHECK(g.a[axis] == Approx(independent_slope(a, b, straight, e, Vec3::Zero(), 1e-4L)).epsilon(1e-9));
      CHECK(g.b[axis] == Approx(independent_slope(a, b, straight, Vec3::Zero(), e, 1e-4L)).epsilon(1e-9));
    }
    CHECK(0.5 * std::pow(angle_state(a, b, straight).deviation, 2) ==
          Approx(static_cast<double>(independent_energy(a, b, straight))).epsilon(1e-14));
  }
}

TEST_CASE("Near 180 degrees the gradient keeps nine digits, however near") {
  // Turned out of the axes, so that every component of the cross product cancels.
  const Mat3 turn = Eigen::AngleAxisd(0.83, Vec3(1.0, -2.0, 0.7).normalized()).toRotationMatrix();
  for (const double bend : {1e-9, 1e-7, 1e-5, 1e-3, 0.01}) {
    const Vec3 a = turn * Vec3(1.0, 0.0, 0.0);
    const Vec3 b = turn * Vec3(-1.1 * std::cos(bend), 1.1 * std::sin(bend), 0.0);
    const AngleGradient g = angle_gradient(angle_state(a, b, true), a, b);
    const Vec3 across = turn * Vec3(0.0, 1.0, 0.0);
    // The energy is as good as quadratic over a part of the bend itself.
    const auto h = static_cast<long double>(0.2 * bend);
    const double by_a = independent_slope(a, b, true, across, Vec3::Zero(), h);
    const double by_b = independent_slope(a, b, true, Vec3::Zero(), across, h);
    INFO("bend " << bend);
    CHECK(g.a.dot(across) == Approx(by_a).epsilon(1e-9));
    CHECK(g.b.dot(across) == Approx(by_b).epsilon(1e-9));
  }
}

TEST_CASE("At exactly 180 degrees there is no force, and the Hessian is that of a beam") {
  const Vec3 a(0.0, 0.0, 1.0);
  const Vec3 b(0.0, 0.0, -1.0);
  const AngleState t = angle_state(a, b, true);
  CHECK(is_defined(a, b, true));
  CHECK(t.deviation == 0.0);
  const AngleGradient g = angle_gradient(t, a, b);
  CHECK(g.a.norm() == 0.0);
  CHECK(g.b.norm() == 0.0);
  // U = 1/2 (a_x + b_x)^2 + 1/2 (a_y + b_y)^2 to second order.
  const Mat3 plane = Vec3(1.0, 1.0, 0.0).asDiagonal();
  const AngleHessian h = angle_hessian(t, a, b);
  CHECK((h.aa - plane).norm() < 1e-15);
  CHECK((h.bb - plane).norm() < 1e-15);
  CHECK((h.ab - plane).norm() < 1e-15);
}

TEST_CASE("The Hessian is the derivative of the gradient from 90 to 180 degrees") {
  const Mat3 turn = Eigen::AngleAxisd(0.4, Vec3(0.3, 1.0, 0.7).normalized()).toRotationMatrix();
  for (const bool straight : {true, false}) {
    for (const double bend : {1e-3, 0.02, 0.5, 1.2, 1.6, 2.5}) {
      const Vec3 a = turn * Vec3(0.9, 0.0, 0.0);
      const Vec3 b = turn * Vec3(-1.1 * std::cos(bend), 1.1 * std::sin(bend), 0.0);
      const AngleHessian h = angle_hessian(angle_state(a, b, straight), a, b);
      const double step = 1e-6 * std::min(1.0, 100.0 * bend);
      const double scale = std::max(h.aa.norm(), h.bb.norm());
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 e = step * Vec3::Unit(axis);
        const auto gradient = [&](const Vec3& p, const Vec3& q) {
          return angle_gradient(angle_state(p, q, straight), p, q);
        };
        const AngleGradient by_a_up = gradient(a + e, b);
        const AngleGradient by_a_down = gradient(a - e, b);
        const AngleGradient by_b_up = gradient(a, b + e);
        const AngleGradient by_b_down = gradient(a, b - e);
        INFO("straight " << straight << ", bend " << bend);
        CHECK(((by_a_up.a - by_a_down.a) / (2.0 * step) - h.aa.col(axis)).norm() < 2e-6 * scale);
        CHECK(((by_b_up.a - by_b_down.a) / (2.0 * step) - h.ab.col(axis)).norm() < 2e-6 * scale);
        CHECK(((by_a_up.b - by_a_down.b) / (2.0 * step) - h.ab.row(axis).transpose()).norm() < 2e-6 * scale);
        CHECK(((by_b_up.b - by_b_down.b) / (2.0 * step) - h.bb.col(axis)).norm() < 2e-6 * scale);
      }
    }
  }
}

TEST_CASE("Where an angle has no gradient it says so") {
  const Vec3 a(1.0, 0.0, 0.0);
  CHECK_FALSE(is_defined(a, Vec3(2.0, 0.0, 0.0), true));    // folded back
  CHECK_FALSE(is_defined(a, Vec3(-2.0, 0.0, 0.0), false));  // a right angle, flat
  CHECK_FALSE(is_defined(a, Vec3::Zero(), true));           // coincident nodes
  CHECK(is_defined(a, Vec3(-2.0, 0.0, 0.0), true));
}

TEST_CASE("A difference of products keeps its digits under cancellation") {
  const double x = 1.0 + 0x1p-30;
  CHECK(difference_of_products(x, x, 1.0, 1.0 + 0x1p-29) == 0x1p-60);
}
