// A filament in a straining flow: the published thresholds, and the chain of markers in limits of its own.
#include "analytic/straining_filament.hpp"

#include <memory>
#include <numbers>

#include "catch.hpp"
#include "coupling/transfer.hpp"
#include "fluid/fluid.hpp"

using namespace veriflex;
using namespace veriflex::analytic;
using Eigen::VectorXd;

namespace {

/// A chain of so many markers that do not feel each other and hardly bend, in a uniform strain of rate 1.
StrainedChain limp_chain(Eigen::Index markers) {
  VectorXd own = VectorXd::Zero(markers);
  own[0] = 1.0;
  StrainedChain chain{{own, own, VectorXd::Zero(markers)}, 1e-9, VectorXd(markers), VectorXd::Ones(markers)};
  for (Eigen::Index i = 0; i < markers; ++i)
    chain.stream[i] = 0.5 * static_cast<double>(markers - 1) - static_cast<double>(i);
  return chain;
}

/// Velocities of markers on a line along x, a spacing apart and displaced by `aside` along z but for the
/// first, against the fluid's mean, once it is steady under that force on the first one.
Positions moved_by(const fluid::Spec& spec, const Vec3& force, Eigen::Index markers, double aside) {
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(spec);
  coupling::Transfer first(spec.grid, {false, false, false}, coupling::Delta::FourPoint), all = first;
  Positions X(markers, 3), F(1, 3), at_nodes, u(markers, 3);
  for (Eigen::Index i = 0; i < markers; ++i) X.row(i) << 6.0 + static_cast<double>(i), 5.0, 6.0 + aside;
  F.row(0) = force;
  first.locate(Positions(Eigen::RowVector3d(6.0, 5.0, 6.0)));
  first.spread(F, at_nodes);
  for (int step = 0; step < 800; ++step) fluid->collide_and_stream({first.nodes(), &at_nodes});
  all.locate(X);
  fluid->velocities(all.nodes(), at_nodes);
  all.interpolate(at_nodes, u);
  return u.rowwise() - (fluid->totals().momentum / static_cast<double>(spec.grid.count())).transpose();
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
  const EvenModes limp = even_modes(rate_of(limp_chain(21)));
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

TEST_CASE("Markers on a line move each other as the lattice's waves say") {
  constexpr double force = 1e-7, aside = 0.01;
  constexpr Eigen::Index markers = 5;
  for (const double tau : {0.8, 2.0}) {
    const fluid::Spec spec{.grid = {{16, 10, 12}}, .relaxation_time = tau};
    const Mobility exact = line_mobility(spec.grid, tau, markers);
    const Positions along = moved_by(spec, {force, 0.0, 0.0}, markers, 0.0);
    const Positions across = moved_by(spec, {0.0, 0.0, force}, markers, 0.0);
    const Positions turned = moved_by(spec, {force, 0.0, 0.0}, markers, aside);
    for (Eigen::Index d = 0; d < markers; ++d) {
      CHECK(along(d, 0) / force == Approx(exact.along[d]).epsilon(1e-5));
      CHECK(across(d, 2) / force == Approx(exact.across[d]).epsilon(1e-5));
      CHECK(turned(d, 2) / (force * aside) == Approx(exact.turned[d]).epsilon(0.01).margin(1e-6));
    }
  }
}

TEST_CASE("Long rolls need the force that their viscous decay takes") {
  for (const double tau : {0.7, 1.0, 2.0}) {
    const double k = 2.0 * std::numbers::pi / 200.0, decay = (tau - 0.5) / 3.0 * k * k;
    CHECK(roll_response(k, tau) * 2.0 * decay == Approx(1.0 - decay).epsilon(0.002));
  }
}

TEST_CASE("A strained chain that is turned with its forces moves as before, turned") {
  // Without stretching: what w = x becomes is the velocity that its forces give it along the axis. Of
  // neighbours on a lattice in a periodic box directions are alike within a tenth.
  const Eigen::Index n = 7;
  StrainedChain chain{line_mobility({{40, 40, 40}}, 1.0, n), 0.3, VectorXd(n), VectorXd::Zero(n)};
  VectorXd x(n);
  for (Eigen::Index i = 0; i < n; ++i) x[i] = static_cast<double>(i) - 3.0;
  chain.stream = -1e-3 * x;
  const VectorXd turned = rate_of(chain) * x;
  CHECK((turned + chain.stream).norm() < 0.1 * chain.stream.norm());
}
