// A filament in a straining flow: the published thresholds, and the chain of markers in limits of its own.
#include "analytic/straining_filament.hpp"

#include <numbers>

#include "catch.hpp"

using namespace veriflex;
using namespace veriflex::analytic;
using Eigen::VectorXd;

namespace {

/// A chain of so many markers in a uniform strain of rate 1, length 1, whose markers do not feel each other:
/// a slender body whose drag is the same in all directions, per length 1.
StrainedChain chain_alone(Eigen::Index markers, double eta) {
  const double r0 = 1.0 / static_cast<double>(markers - 1);
  VectorXd own = VectorXd::Zero(markers);
  own[0] = 1.0 / r0;
  StrainedChain chain{
      {own, own, VectorXd::Zero(markers)}, r0, 1.0 / (eta * r0), VectorXd(markers), VectorXd::Ones(markers)};
  for (Eigen::Index i = 0; i < markers; ++i) chain.stream[i] = 0.5 - r0 * static_cast<double>(i);
  return chain;
}

}  // namespace

TEST_CASE("A slender filament in a straining flow buckles from where it is known to") {
  const double thresholds[] = {153.20243, 774.38853, 1930.71254, 3607.79257};
  for (Eigen::Index mode = 0; mode < 4; ++mode)
    CHECK(std::abs(slender_growth(thresholds[mode])[mode]) < 2e-5);
  CHECK(slender_growth(100.0)[0] == Approx(-1.73561).margin(1e-5));
  CHECK(slender_growth(150.0)[0] == Approx(-0.06959).margin(1e-5));
  CHECK(slender_growth(200.0)[0] == Approx(0.76208).margin(1e-5));
  CHECK(slender_growth(300.0)[0] == Approx(1.59094).margin(1e-5));
}

TEST_CASE("Markers that do not feel each other and do not bend buckle as Legendre polynomials") {
  // w_t = w + 1/2 ((s^2 - 1/4) w')' without bending: growth 1 + n (n + 1)/2, exactly so of markers too.
  const EvenModes limp = even_modes(rate_of(chain_alone(21, 1e12)));
  CHECK(limp.drift.growth == Approx(1.0).epsilon(1e-9));
  CHECK(limp.buckling.growth == Approx(4.0).epsilon(1e-6));
  CHECK(limp.drift.shape.isApproxToConstant(1.0, 1e-6));
  const double height = limp.buckling.shape[10], end = limp.buckling.shape[0];
  for (Eigen::Index i = 0; i < 21; ++i) {
    const double s = static_cast<double>(i - 10) / 10.0;
    CHECK(limp.buckling.shape[i] == Approx(height + (end - height) * s * s).margin(1e-6));
  }
  CHECK(limp.buckling.dual.dot(limp.buckling.shape) == Approx(1.0));
  CHECK(limp.buckling.dual.dot(limp.drift.shape) == Approx(0.0).margin(1e-9));
}

TEST_CASE("Markers on a line move each other as points do far away, and one as a sphere") {
  constexpr double mu = 0.3, pi = std::numbers::pi;
  const Mobility far = line_mobility({{72, 72, 72}}, mu, 11, 1.0);
  CHECK(far.turned[10] == Approx(1.0 / (8.0 * pi * mu * 100.0)).epsilon(0.06));
  CHECK(far.along[10] - far.across[10] == Approx(1.0 / (8.0 * pi * mu * 10.0)).epsilon(0.03));
  CHECK(far.along[0] == Approx(far.across[0]));  // a cube
  // A box twice as wide holds back half as much, by Hasimoto's constant.
  const Mobility near = line_mobility({{36, 36, 36}}, mu, 1, 1.0);
  CHECK(far.along[0] - near.along[0] == Approx(2.837297 / (6.0 * pi * mu * 72.0)).epsilon(0.02));
}

TEST_CASE("Long rolls need the force that their viscous decay takes") {
  for (const double tau : {0.7, 1.0, 2.0}) {
    const double k = 2.0 * std::numbers::pi / 200.0, decay = (tau - 0.5) / 3.0 * k * k;
    CHECK(roll_response(k, tau) * 2.0 * decay == Approx(1.0 - decay).epsilon(0.002));
  }
}

TEST_CASE("A strained chain that is turned with its forces moves as before, turned") {
  // Without stretching: what w = x becomes is the velocity that its forces give it along the axis. In a
  // periodic box directions are alike only as far as the chain is short.
  const Eigen::Index n = 7;
  StrainedChain chain{line_mobility({{48, 48, 48}}, 0.5, n, 1.0), 1.0, 0.3, VectorXd(n), VectorXd::Zero(n)};
  VectorXd x(n);
  for (Eigen::Index i = 0; i < n; ++i) x[i] = static_cast<double>(i) - 3.0;
  chain.stream = -1e-3 * x;
  const VectorXd turned = rate_of(chain) * x;
  CHECK((turned + chain.stream).norm() < 0.03 * chain.stream.norm());
}
