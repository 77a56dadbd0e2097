// The ends of arithmetic: near the limits of the laws, far from the origin, among the smallest numbers, in
// the thinnest boxes and the smallest bodies. Each gives the right answer to a stated accuracy, or an error
// by name.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.hpp"
#include "bond/fene_lj.hpp"
#include "bond/harmonic.hpp"
#include "catch.hpp"
#include "plain_fluid.hpp"
#include "scene/simulation.hpp"
#include "solid/angle.hpp"
#include "solid/leapfrog.hpp"
#include "solid/modes.hpp"

using namespace veriflex;

namespace {

const bond::FeneLj unit_fene{1.0, 1.0, 30.0, 1.5, 1.122462048309373};

double relative(double found, long double exact) {
  return static_cast<double>(std::abs(static_cast<long double>(found) / exact - 1.0L));
}

/// The state of every node after eight steps.
std::vector<fluid::Populations> after_eight_steps(const fluid::Spec& spec, double amplitude) {
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(spec);
  fluid->start(fluid::disorder(amplitude));
  const Positions nothing(0, 3);
  for (int step = 0; step < 8; ++step) fluid->collide_and_stream({{}, &nothing});
  std::vector<std::int64_t> nodes(static_cast<std::size_t>(spec.grid.count()));
  std::iota(nodes.begin(), nodes.end(), 0);
  std::vector<fluid::Populations> h(nodes.size());
  fluid->populations(nodes, h);
  return h;
}

scene::Body one_node() {
  return {.material = {bond::Harmonic{0.26, 1.0}, 0.025}, .network = solid::cubic_lattice({{1, 1, 1}, 1.0})};
}

}  // namespace

TEST_CASE("A bond near R0 has its tension but for what rounding its length costs, and none at R0") {
  for (const double gap : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15}) {
    const double r = 1.5 * (1.0 - gap);
    const auto exact = static_cast<long double>(r);
    const long double open = (1.5L - exact) * (1.5L + exact) / 2.25L;
    const double rounding = 1e-14 + 4e-16 / gap;  // r/R0 is rounded in its last place, twice
    INFO("1 - r/R0 = " << gap);
    CHECK(relative(unit_fene.tension(r), 30.0L * exact / open) < rounding);
    CHECK(relative(unit_fene.stiffness(r), 30.0L * (2.0L - open) / (open * open)) < 2.0 * rounding);
    CHECK(relative(unit_fene.energy(r), -33.75L * std::log(open)) < rounding);
  }
  CHECK_FALSE(unit_fene.domain().contains(1.5));
}

TEST_CASE(
    "A bond of a thousandth of sigma is a wall with all of its digits, and throws its ends apart by name") {
  const double r = 1e-3;
  const long double s6 = std::pow(1.0L / static_cast<long double>(r), 6.0L), R = r;
  CHECK(relative(unit_fene.tension(r),
                 30.0L * R / (1.0L - R * R / 2.25L) - 24.0L / R * (2.0L * s6 * s6 - s6)) < 1e-14);
  CHECK(relative(unit_fene.stiffness(r), 24.0L / (R * R) * (26.0L * s6 * s6 - 7.0L * s6)) < 1e-14);
  CHECK(relative(unit_fene.energy(r), 4.0L * (s6 * s6 - s6)) < 1e-14);

  const solid::Network pair = solid::cubic_lattice({{1, 1, 2}, 0.96});
  Positions u = Positions::Zero(2, 3);
  u(1, 2) = 1e-3 - 0.96;
  solid::Leapfrog motion({bond::AnyLaw(unit_fene), 0.0}, pair, {}, 1.0, {}, u, Positions::Zero(2, 3));
  CHECK_THROWS_AS(motion.step(), NumericalFailure);
}

TEST_CASE("An angle bent by the smallest numbers pulls back in proportion, one folded flat is an error") {
  const Vec3 a(1.0, 0.0, 0.0);
  for (const double bend : {1e-6, 1e-12, 1e-100, 1e-300, 1e-310}) {
    const Vec3 b(-1.0, bend, 0.0);
    const solid::AngleGradient g = solid::angle_gradient(solid::angle_state(a, b, true), a, b);
    INFO("bend " << bend);
    CHECK(g.b[1] == Approx(bend).epsilon(1e-9));  // of (bend)^2/2
    CHECK(std::abs(g.b[0]) <= 2.0 * bend * bend);
  }
  for (const double bend : {0.0, 1e-12, 1e-300}) {
    CHECK_FALSE(solid::is_defined(a, Vec3(1.0, bend, 0.0), true));
    CHECK_FALSE(solid::is_defined(a, Vec3(-1.0, bend, 0.0), false));
  }
}

TEST_CASE("A fluid of the smallest numbers is the same fluid, one of subnormal numbers is at rest") {
  for (const double tau : {0.8, 1.0}) {
    const fluid::Spec spec{.grid = {{16, 4, 5}}, .relaxation_time = tau};
    const auto ordinary = after_eight_steps(spec, std::ldexp(1.0, -400));
    const auto smallest = after_eight_steps(spec, std::ldexp(1.0, -1000));
    double worst = 0.0, largest = 0.0;
    for (std::size_t node = 0; node < ordinary.size(); ++node) {
      for (std::size_t q = 0; q < ordinary[node].size(); ++q) {
        const double difference = std::abs(std::ldexp(smallest[node][q], 600) - ordinary[node][q]);
        worst = difference <= worst ? worst : difference;
        largest = std::max(largest, std::abs(ordinary[node][q]));
      }
    }
    // What falls below 2^-1022 in a sum counts as zero, some hundred times.
    CHECK(worst / largest < 1e-3);
    for (const fluid::Populations& h : after_eight_steps(spec, std::ldexp(1.0, -1040))) {
      for (const double population : h) CHECK(population == 0.0);
    }
    CHECK(std::ldexp(std::ldexp(1.0, -1040) * 0.5, 1041) == 1.0);  // here they are numbers as before
  }
}

TEST_CASE("Boxes of one and two nodes along any axes are the textbook's") {
  for (const double tau : {0.8, 1.0}) {
    for (int shape = 0; shape < 27; ++shape) {
      const std::int64_t side[] = {1, 2, 16};
      const fluid::Spec spec{.grid = {{side[shape % 3], side[shape / 3 % 3], side[shape / 9]}},
                             .relaxation_time = tau};
      const auto found = after_eight_steps(spec, 0.1);
      fluid::PlainFluid plain(spec, fluid::disorder(0.1));
      for (int step = 0; step < 8; ++step) plain.step(std::vector<Vec3>(found.size(), Vec3::Zero()));
      double worst = 0.0;
      for (std::size_t node = 0; node < found.size(); ++node) {
        const fluid::Populations expected = plain.populations(static_cast<std::int64_t>(node));
        for (std::size_t q = 0; q < found[node].size(); ++q) {
          const double error = std::abs(found[node][q] - expected[q]);
          worst = error <= worst ? worst : error;
        }
      }
      CAPTURE(tau, spec.grid.size[0], spec.grid.size[1], spec.grid.size[2]);
      CHECK(worst < 1e-15);
    }
  }
}

TEST_CASE("A body of one node has no bonds, no frequency, and moves on") {
  const scene::Body body = one_node();
  CHECK(body.network.bonds.empty());
  CHECK(solid::largest_frequency(body.material, body.network, Positions::Zero(1, 3),
                                 solid::FixedDofs::Constant(1, 3, false), 1.0) == 0.0);
  for (const double safety : {0.0, 0.5}) {
    const Positions v = Vec3(0.25, -0.5, 0.125).transpose();
    solid::Leapfrog motion(body.material, body.network, {}, 1.0, {.safety = safety}, Positions::Zero(1, 3),
                           v);
    for (int step = 0; step < 8; ++step) motion.step();
    CHECK(motion.displacement() == 8.0 * v);
    CHECK(motion.potential_energy() == 0.0);
  }
}

TEST_CASE("A body a hundred million spacings away moves as it does here, to the rounding of its place") {
  const auto displacement = [](double boxes) {
    scene::Body body{.material = {bond::Harmonic{0.26, 1.0}, 0.0},
                     .network = solid::cubic_lattice({{3, 3, 3}, 1.0}),
                     .place = {4.3 + 16.0 * boxes, 5.1, 6.2},
                     .coupling = scene::CouplingSpec{}};
    body.conditions.node_mass = 2.0;
    body.conditions.load = Vec3(1e-3, 2e-3, -1e-3).transpose().replicate(27, 1);
    scene::Simulation simulation(
        scene::Scene{.fluid = fluid::Spec{.grid = {{16, 12, 14}}, .relaxation_time = 0.8}, .bodies = {body}});
    for (int step = 0; step < 50; ++step) simulation.advance();
    return simulation.body().displacement();
  };
  const Positions here = displacement(0.0), there = displacement(6250000.0);
  CHECK(here.norm() > 1e-2);
  CHECK((there - here).cwiseAbs().maxCoeff() < 1e-8);  // places are rounded to 1.5e-8, weights with them
}
