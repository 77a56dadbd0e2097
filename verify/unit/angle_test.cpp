#include "solid/angle.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "catch.hpp"
#include "solid/network.hpp"

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

TEST_CASE("The vectorised loop over angles gives what the plain formulas give, angle by angle") {
  // 200 angles of every kind: more than three blocks, and a last one that is not full.
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const std::size_t count = 200;
  const auto bonds = static_cast<Eigen::Index>(2 * count);
  Positions d(bonds, 3);
  std::vector<Angle> angles;
  for (std::size_t i = 0; i < count; ++i) {
    const auto p = static_cast<Eigen::Index>(2 * i);
    const Vec3 a(uniform(random), uniform(random), uniform(random));
    const bool straight = i % 2 == 0;
    const double off = std::pow(10.0, -static_cast<double>(i % 12));  // from anywhere to 1e-11 from flat
    d.row(p) = a;
    d.row(p + 1) = straight ? Vec3(-1.1 * a + off * Vec3(uniform(random), uniform(random), uniform(random)))
                            : Vec3(uniform(random), uniform(random), uniform(random));
    const auto first = static_cast<std::int32_t>(p);
    const std::int8_t sign = i % 3 == 0 ? -1 : 1;
    if (sign < 0) d.row(p) *= -1.0;
    angles.push_back({first, first + 1, sign, 1, straight});
  }
  Positions fast = Positions::Zero(bonds, 3);
  REQUIRE(add_angle_gradients(arrange(angles, 2 * count), d.data(), 2 * count, 0.7, fast.data()));
  for (const Angle& t : angles) {
    const Vec3 a = t.sign_a * d.row(t.bond_a).transpose();
    const Vec3 b = t.sign_b * d.row(t.bond_b).transpose();
    const AngleGradient plain = angle_gradient(angle_state(a, b, t.straight), a, b);
    CHECK((Vec3(fast.row(t.bond_a)) - 0.7 * t.sign_a * plain.a).norm() <= 3e-15 * 0.7 * plain.a.norm());
    CHECK((Vec3(fast.row(t.bond_b)) - 0.7 * t.sign_b * plain.b).norm() <= 3e-15 * 0.7 * plain.b.norm());
  }
}

TEST_CASE("The vectorised loop reports an angle without a gradient wherever it stands") {
  for (const std::size_t bad : {0U, 63U, 64U, 99U}) {
    Positions d = Positions::Zero(200, 3);
    std::vector<Angle> angles;
    for (std::int32_t i = 0; i < 100; ++i) {
      d(2 * i, 0) = 1.0;
      d(2 * i + 1, 1) = 1.0;
      angles.push_back({2 * i, 2 * i + 1, 1, 1, false});
    }
    Positions g = Positions::Zero(200, 3);
    CHECK(add_angle_gradients(arrange(angles, 200), d.data(), 200, 1.0, g.data()));
    CHECK(g.norm() == 0.0);
    d.row(static_cast<Eigen::Index>(2 * bad + 1)) = d.row(static_cast<Eigen::Index>(2 * bad));
    CHECK_FALSE(add_angle_gradients(arrange(angles, 200), d.data(), 200, 1.0, g.data()));
    d(static_cast<Eigen::Index>(2 * bad + 1), 1) = std::nan("");
    CHECK_FALSE(add_angle_gradients(arrange(angles, 200), d.data(), 200, 1.0, g.data()));
  }
}

TEST_CASE("A body of several pieces has the gradient of all its angles") {
  Network block = cubic_lattice({{14, 14, 22}, 1.0});
  add_angles(block);
  REQUIRE(block.node_count() > 2 * static_cast<Eigen::Index>(AngleStars::max_stars));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-0.1, 0.1);
  Positions d(static_cast<Eigen::Index>(block.bonds.size()), 3);
  for (double& component : d.reshaped()) component = uniform(random);
  for (Eigen::Index b = 0; b < d.rows(); ++b) {
    const Bond& bond = block.bonds[static_cast<std::size_t>(b)];
    d.row(b) += block.rest.row(bond.second) - block.rest.row(bond.first);
  }
  Positions plain = Positions::Zero(d.rows(), 3), fast = plain;
  for (const Angle& t : block.angles) {
    const Vec3 a = t.sign_a * d.row(t.bond_a).transpose();
    const Vec3 b = t.sign_b * d.row(t.bond_b).transpose();
    const AngleGradient one = angle_gradient(angle_state(a, b, t.straight), a, b);
    plain.row(t.bond_a) += t.sign_a * one.a;
    plain.row(t.bond_b) += t.sign_b * one.b;
  }
  const auto bonds = static_cast<std::size_t>(d.rows());
  const AngleStars stars = arrange(block.angles, bonds);
  CHECK(stars.angle_count == block.angles.size());
  REQUIRE(add_angle_gradients(stars, d.data(), bonds, 1.0, fast.data()));
  CHECK((fast - plain).cwiseAbs().maxCoeff() <= 1e-14 * plain.cwiseAbs().maxCoeff());
}

TEST_CASE("Every angle is arranged once: the stars of a lattice are its nodes, as few shapes as it has") {
  Network rod = rod_lattice({2.5, 51, 1.0});
  add_angles(rod);
  const AngleStars stars = arrange(rod.angles, rod.bonds.size());
  CHECK(stars.angle_count == rod.angles.size());
  CHECK(stars.groups.size() == 4);  // three, four, five and six arms
  std::size_t nodes = 0;
  for (const AngleStars::Group& group : stars.groups) nodes += group.stars;
  CHECK(nodes == 1071);
}

TEST_CASE("Forces do not depend on the order of the angles, however many meet at a node") {
  // A star of twelve bonds with all its 66 angles, every third of them straight: more arms than a star has.
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Positions d(12, 3);
  for (double& component : d.reshaped()) component = uniform(random);
  std::vector<Angle> angles;
  for (std::int32_t p = 0; p < 12; ++p) {
    for (std::int32_t q = p + 1; q < 12; ++q) {
      const std::int8_t sign = p % 2 == 0 ? 1 : -1;
      angles.push_back({p, q, sign, 1, angles.size() % 3 == 0});
    }
  }
  Positions plain = Positions::Zero(12, 3);
  for (const Angle& t : angles) {
    const Vec3 a = t.sign_a * d.row(t.bond_a).transpose();
    const Vec3 b = t.sign_b * d.row(t.bond_b).transpose();
    const AngleGradient g = angle_gradient(angle_state(a, b, t.straight), a, b);
    plain.row(t.bond_a) += t.sign_a * g.a;
    plain.row(t.bond_b) += t.sign_b * g.b;
  }
  for (int order = 0; order < 5; ++order) {
    std::shuffle(angles.begin(), angles.end(), random);
    const AngleStars stars = arrange(angles, 12);
    CHECK(stars.angle_count == angles.size());
    Positions fast = Positions::Zero(12, 3);
    REQUIRE(add_angle_gradients(stars, d.data(), 12, 1.0, fast.data()));
    CHECK((fast - plain).cwiseAbs().maxCoeff() < 1e-14 * plain.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("The formula for small deviations and the one for any meet without a step") {
  // Deviations around 30 degrees, where the vectorised loop hands over.
  for (const bool straight : {true, false}) {
    for (const double off : {-1e-9, 1e-9, -0.1, 0.1}) {
      const double theta =
          (straight ? std::numbers::pi : 0.5 * std::numbers::pi) - std::numbers::pi / 6.0 + off;
      Positions d = Positions::Zero(2, 3);
      d.row(0) = Vec3(0.9, 0.0, 0.0);
      d.row(1) = 1.2 * Vec3(std::cos(theta), std::sin(theta), 0.0);
      Positions fast = Positions::Zero(2, 3);
      REQUIRE(add_angle_gradients(arrange({{0, 1, 1, 1, straight}}, 2), d.data(), 2, 1.0, fast.data()));
      const double deviation = -std::numbers::pi / 6.0 + off;
      CHECK(fast(0, 1) == Approx(-deviation / 0.9).epsilon(1e-14));
      CHECK(std::abs(fast(0, 0)) < 1e-14);
      CHECK(fast.row(1).norm() == Approx(std::abs(deviation) / 1.2).epsilon(1e-14));
    }
  }
}
