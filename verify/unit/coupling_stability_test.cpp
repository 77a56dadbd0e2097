// The linearised exchange of body and fluid against formulas: one mode, a frozen force, and the boundary of a
// whole body, which for one step is an eigenvalue of a symmetric matrix; and of any body against a dense
// solver.
#include "scene/coupling_stability.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <random>

#include "base/root.hpp"
#include "bond/harmonic.hpp"
#include "catch.hpp"
#include "coupling/transfer.hpp"
#include "scene/markers.hpp"
#include "scene/simulation.hpp"
#include "solid/dof_map.hpp"
#include "solid/modes.hpp"

using namespace veriflex;

namespace {

const fluid::Spec box{.grid = {{16, 16, 20}}, .relaxation_time = 1.0};
constexpr double one_marker = 27.0 / 512.0;  // sum D^2 = (3/8)^3 wherever the marker is

/// A node on a bond of stiffness k, whose other end is held; it moves along the bond only and is coupled.
scene::Body one_node(double k, double mass, int substeps, bool subcycled = false) {
  scene::Body body{
      {bond::Harmonic{k, 1.0}, 0.0}, solid::cubic_lattice({{1, 1, 2}, 1.0}), {}, {substeps, 0.0}};
  body.conditions.node_mass = mass;
  body.conditions.fixed = solid::FixedDofs::Constant(2, 3, true);
  body.conditions.fixed(1, 2) = false;
  body.place = {8.3, 7.9, 8.6};
  body.coupling = {.coupled = scene::Coupled::Listed, .listed = {1}, .subcycled = subcycled};
  return body;
}

scene::Body rod(int sections, double mass, int substeps) {
  solid::Network network = solid::rod_lattice({2.5, sections, 1.0});
  solid::add_angles(network);
  scene::Body body{{bond::Harmonic{0.26, 1.0}, 0.025}, network, {}, {substeps, 0.0}};
  body.conditions.node_mass = mass;
  body.place = {8.0, 8.0, 8.0};
  body.coupling.emplace();
  return body;
}

bool stable(const scene::Growth& growth) { return !growth.grows(); }

}  // namespace

TEST_CASE("One mode with one step is stable while m > K/4 + 1/(2 - S)") {
  for (const double k : {0.0, 0.26, 2.0}) {
    const double mass = scene::critical_node_mass(box, one_node(k, 1.0, 1), 1e-6);
    CHECK(mass == Approx(k / 4.0 + 1.0 / (2.0 - one_marker)).epsilon(1e-4));
  }
}

TEST_CASE("A fluid that forgets is the limit S = 0") {
  const double mass =
      scene::critical_node_mass(box, one_node(0.26, 1.0, 1), 1e-6, scene::FluidMemory::Forgets);
  CHECK(mass == Approx(0.26 / 4.0 + 0.5).epsilon(1e-4));
}

TEST_CASE(
    "A frozen force through ever finer sub-steps needs omega < tan(omega/2), and a subcycled one does not") {
  // One step of an oscillator under the constant force - v(0) has determinant 1 - sin(omega)/omega and trace
  // 2 cos(omega) - sin(omega)/omega: an eigenvalue passes through -1 where omega = tan(omega/2).
  const double limit =
      bracketed_root([](double w) { return std::sin(0.5 * w) - w * std::cos(0.5 * w); }, 2.0, 3.0);
  CHECK(limit == Approx(2.3311).epsilon(1e-4));
  const auto growth = [](double omega, bool subcycled) {
    return scene::coupling_growth(box, one_node(omega * omega, 1.0, 1000, subcycled),
                                  scene::FluidMemory::Forgets);
  };
  CHECK(stable(growth(0.998 * limit, false)));
  CHECK_FALSE(stable(growth(1.002 * limit, false)));
  CHECK(stable(growth(1.5 * limit, true)));
}

TEST_CASE("The boundary of a whole body with one step is an eigenvalue of K/4 + P (2 - A)^-1 P^T") {
  // At an eigenvalue -1 of the map u' = - u, v = 2 u and W = A F/2, which leaves 4 m u = K u + 2 P (1 -
  // A/2)^-1 P^T u.
  scene::Body body = rod(4, 1.0, 1);
  const auto nodes = body.network.node_count();
  const std::vector<std::int32_t> coupled = scene::coupled_nodes(body);
  const auto markers = static_cast<Eigen::Index>(coupled.size());
  Positions X(markers, 3);
  for (Eigen::Index m = 0; m < markers; ++m) {
    X.row(m) = body.network.rest.row(coupled[static_cast<std::size_t>(m)]) + body.place.transpose();
  }
  coupling::Transfer transfer(box.grid, {false, false, false}, body.coupling->delta);
  transfer.locate(X);
  Eigen::MatrixXd A(markers, markers);
  Positions spread, back;
  for (Eigen::Index m = 0; m < markers; ++m) {
    Positions unit = Positions::Zero(markers, 3);
    unit(m, 0) = 1.0;
    transfer.spread(unit, spread);
    transfer.interpolate(spread, back);
    A.col(m) = back.col(0);
  }
  const Eigen::MatrixXd resistance = (2.0 * Eigen::MatrixXd::Identity(markers, markers) - A).inverse();
  const solid::FixedDofs free = solid::FixedDofs::Constant(nodes, 3, false);
  Eigen::MatrixXd matrix =
      solid::free_hessian(body.material, body.network, Positions::Zero(nodes, 3), free) / 4.0;
  for (int axis = 0; axis < 3; ++axis) {
    for (Eigen::Index i = 0; i < markers; ++i) {
      for (Eigen::Index j = 0; j < markers; ++j) {
        matrix(axis * nodes + coupled[static_cast<std::size_t>(i)],
               axis * nodes + coupled[static_cast<std::size_t>(j)]) += resistance(i, j);
      }
    }
  }
  const double expected =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
  CHECK(scene::critical_node_mass(box, body, 1e-5) == Approx(expected).epsilon(1e-3));
}

TEST_CASE("What drifts or turns with the fluid does not grow") {
  CHECK(scene::coupling_growth(box, rod(4, 1.0, 4)).factor == 1.0);
}

TEST_CASE("A driven coordinate takes no part in the growth") {
  scene::Body body = one_node(0.26, 0.1, 1);
  CHECK_FALSE(stable(scene::coupling_growth(box, body)));
  body.conditions.drive = solid::Drive{{1}, 2, 0.1, 0.5, 0.0};
  CHECK(stable(scene::coupling_growth(box, body)));
}

namespace {

/// Bodies of any shape, mass, stiffness and way of coupling, some of them driven, small enough for a dense
/// solver.
scene::Body random_body(std::mt19937& random, std::int64_t max_nodes) {
  const auto between = [&](double lo, double hi) {
    return lo + (hi - lo) * static_cast<double>(random()) / 4294967296.0;
  };
  const auto number = [&](std::int64_t lo, std::int64_t hi) {
    return lo + static_cast<std::int64_t>(random()) % (hi - lo + 1);
  };
  solid::Network network;
  do {
    network = number(0, 1) == 0 ? solid::cubic_lattice({{number(1, 4), number(1, 4), number(2, 5)}, 1.0})
                                : solid::rod_lattice({between(0.0, 1.6), number(2, 5), 1.0});
  } while (network.node_count() < 4 || network.node_count() > max_nodes);
  const double angle = number(0, 3) == 0 ? 0.0 : between(0.0, 0.05);
  if (angle > 0.0) solid::add_angles(network);
  const int substeps = static_cast<int>(number(1, 4));
  scene::Body body{{bond::Harmonic{std::exp(between(std::log(0.02), std::log(2.0))), 1.0}, angle},
                   network,
                   {},
                   {substeps, 0.0}};
  scene::CouplingSpec coupling{.marker_volume = std::exp(between(std::log(0.05), std::log(2.0))),
                               .subcycled = number(0, 1) == 1,
                               .forcing_iterations = static_cast<int>(number(1, 2))};
  body.place = {between(6.0, 9.0), between(6.0, 9.0), between(6.0, 9.0)};
  switch (number(0, 3)) {
    case 0:
      coupling.coupled = scene::Coupled::All;
      break;
    case 1:
      coupling.coupled = scene::Coupled::Listed;
      for (std::int32_t i = 0; i < network.node_count(); ++i) {
        if (i == 0 || number(0, 2) > 0) coupling.listed.push_back(i);
      }
      break;
    default:
      break;
  }
  // About where frozen and subcycled forces begin to grow.
  const double least = coupling.subcycled ? 0.1 : 0.4;
  body.conditions.node_mass =
      coupling.marker_volume * std::exp(between(std::log(least), std::log(5.0 * least)));
  if (number(0, 3) == 0) body.conditions.drive = solid::Drive{{0}, 2, 0.1, 0.5, 0.0};
  body.coupling = coupling;
  return body;
}

}  // namespace

TEST_CASE("A hundred small bodies grow as all eigenvalues of their maps say") {
  std::mt19937 random(7);
  int grow = 0;
  for (int i = 0; i < 100; ++i) {
    const scene::CoupledStep step(box, random_body(random, 12), scene::FluidMemory::Keeps);
    const scene::Growth all = scene::dense_growth(step);
    const scene::Growth found = scene::large_growth(step);
    INFO("body " << i << ", m = " << step.node_mass() << ", V = " << step.marker_volume() << ", subcycled "
                 << step.is_subcycled() << ", " << step.substeps() << " sub-steps, "
                 << step.forcing_iterations() << " iterations");
    grow += all.grows() ? 1 : 0;
    if (all.factor > 1.0 + found.resolution) {
      CHECK(found.factor == Approx(all.factor).epsilon(1e-6));
    } else {
      CHECK(found.factor <= all.factor + 1e-6);
    }
    CHECK(found.resolution < 0.004);
    if (!step.is_subcycled()) CHECK(found.resolution == scene::growth_resolution);
  }
  CHECK(grow > 25);
  CHECK(grow < 75);
}

TEST_CASE("The map's step is the simulation's, to first order, by either integrator") {
  // One step from a fluid at rest: what the fluid does to its momentum afterwards is not in the map.
  for (const solid::Scheme scheme : {solid::Scheme::LeapFrog, solid::Scheme::ImplicitMidpoint}) {
    for (const bool subcycled : {false, true}) {
      scene::Body body = rod(6, 0.7, scheme == solid::Scheme::LeapFrog ? 3 : 1);
      body.scheme = scheme;
      body.coupling->subcycled = subcycled;
      const scene::CoupledStep step(box, body, scene::FluidMemory::Keeps);
      const solid::DofMap dofs(solid::prescribed_dofs(body.conditions, body.network.node_count()));
      std::mt19937 random(3);
      Eigen::VectorXd u(step.free_count()), state = Eigen::VectorXd::Zero(step.size());
      for (double& x : u) x = 1e-7 * (static_cast<double>(random()) / 4294967296.0 - 0.5);
      state.head(u.size()) = -(step.stiffness() * u);
      for (double& x : state.segment(u.size(), u.size()))
        x = 1e-7 * (static_cast<double>(random()) / 4294967296.0 - 0.5);
      const Eigen::VectorXd after = step.next(state);

      scene::Simulation simulation({.fluid = box, .bodies = {body}});
      scene::State put = simulation.state();
      put.bodies[0].elastic->displacement = dofs.scatter(u, 1.0);
      put.bodies[0].elastic->velocity = dofs.scatter(state.segment(u.size(), u.size()), 1.0);
      simulation.restore(put);
      simulation.advance();
      const solid::Integrator& solid = simulation.body().solid();
      const Eigen::VectorXd f = -(step.stiffness() * dofs.gather(solid.displacement()));
      const Eigen::VectorXd v = dofs.gather(solid.carried_velocity());
      INFO("implicit " << step.is_implicit() << ", subcycled " << subcycled);
      CHECK((f - after.head(u.size())).norm() < 1e-5 * f.norm());
      CHECK((v - after.segment(u.size(), u.size())).norm() < 1e-5 * v.norm());
    }
  }
}

TEST_CASE("By the implicit rule no stiffness and no mass is too much while V S is below 2") {
  for (const double mass : {0.02, 1.0}) {
    scene::Body body = rod(6, mass, 1);
    body.network = solid::rod_lattice({1.0, 6, 1.0});
    solid::add_angles(body.network);
    body.scheme = solid::Scheme::ImplicitMidpoint;
    body.coupling->subcycled = true;
    body.material = {bond::Harmonic{2600.0, 1.0}, 250.0};
    CHECK(scene::dense_growth(scene::CoupledStep(box, body, scene::FluidMemory::Keeps)).factor ==
          Approx(1.0).epsilon(1e-6));
    body.scheme = solid::Scheme::LeapFrog;
    CHECK(scene::dense_growth(scene::CoupledStep(box, body, scene::FluidMemory::Keeps)).factor > 2.0);
  }
}

TEST_CASE("Two nodes on a bond of any stiffness have a least node mass") {
  // Against each other the two have the stiffness 2 k and S - S', S' being what one gives to the other.
  for (const double k : {0.01, 0.26, 1.5, 1000.0}) {
    scene::Body pair = one_node(k, 1.0, 1);
    pair.conditions.fixed.resize(0, 3);
    pair.coupling = {.coupled = scene::Coupled::All};
    const scene::CoupledStep step(box, pair, scene::FluidMemory::Keeps);
    const double S = step.exchange().coeff(0, 0), given = step.exchange().coeff(0, 1);
    const double along = 0.5 * k + 1.0 / (2.0 - (S - given)), together = 1.0 / (2.0 - (S + given));
    CHECK(scene::critical_node_mass(box, pair, 1e-6) == Approx(std::max(along, together)).epsilon(1e-4));
  }
}

TEST_CASE("Bodies of any kind grow together as all eigenvalues of their common map say") {
  std::mt19937 random(11);
  for (int i = 0; i < 20; ++i) {
    std::vector<scene::Body> bodies{random_body(random, 8), random_body(random, 8)};
    if (i % 2 == 0) {  // alike, so that their map is uniform
      bodies[1] = bodies[0];
      bodies[1].place[0] += 2.5;
    }
    const scene::CoupledStep step(box, bodies, scene::FluidMemory::Keeps);
    const scene::Growth all = scene::dense_growth(step), found = scene::large_growth(step);
    INFO("bodies " << i << ", uniform " << step.is_uniform());
    if (all.factor > 1.0 + found.resolution) {
      CHECK(found.factor == Approx(all.factor).epsilon(1e-6));
    } else {
      CHECK(found.factor <= all.factor + 1e-6);
    }
  }
}

TEST_CASE("Bodies that share no node grow as the one of them that grows more") {
  std::vector<scene::Body> bodies{one_node(0.26, 0.5, 1), one_node(1.3, 0.7, 2, true)};
  bodies[1].place[0] += 6.0;
  const double first = scene::coupling_growth(box, bodies[0]).factor;
  const double second = scene::coupling_growth(box, bodies[1]).factor;
  CHECK(scene::coupling_growth(box, bodies).factor == Approx(std::max(first, second)).epsilon(1e-12));
}

TEST_CASE("A rod whose force follows the sub-steps neither grows nor seems to") {
  scene::Body body = rod(9, 1.0, 4);
  body.coupling->subcycled = true;
  const scene::Growth growth = scene::coupling_growth(box, body);
  CHECK(growth.factor == 1.0);
  // What could have grown from a share of 1e-6 in 4000 steps, and not more: the motion has not grown.
  CHECK(growth.resolution == Approx(std::expm1(std::log(1e6) / 4000.0)).epsilon(1e-3));
}

TEST_CASE(
    "A body under stress may leave its place slowly by itself, which bounds what is seen of its growth") {
  // A bond that is too short by the part e pushes its free end aside, with the stiffness - k e.
  const auto under_stress = [](double e) {
    scene::Body body = one_node(0.26, 1.3, 2);
    body.material = {bond::Harmonic{0.26, 1.0 + e}, 0.0};
    body.conditions.fixed(1, 0) = false;
    return body;
  };
  for (const double e : {1e-9, 1e-7, 1e-5, 1e-4}) {
    const scene::CoupledStep step(box, under_stress(e), scene::FluidMemory::Keeps);
    const auto growth = scene::AlternatingGrowth::of(step, scene::scales_of(step));
    REQUIRE(growth.has_value());
    const double own = std::sqrt(0.26 * e / 1.3);
    INFO("e = " << e << ", by itself it grows by " << own);
    CHECK(growth->own_growth() >= std::max(own, scene::growth_resolution));
    CHECK(growth->own_growth() <= std::max(2.0 * own, scene::growth_resolution));
    CHECK(scene::large_growth(step).resolution == growth->own_growth());
  }
  const scene::CoupledStep fast(box, under_stress(1e-2), scene::FluidMemory::Keeps);
  CHECK_FALSE(scene::AlternatingGrowth::of(fast, scene::scales_of(fast)).has_value());
}

TEST_CASE(
    "Frozen forces alternate while no mode turns by half a circle in a step, in however many sub-steps") {
  const double stiffest =
      scene::scales_of(scene::CoupledStep(box, rod(4, 1.0, 1), scene::FluidMemory::Keeps)).stiffness;
  for (const int substeps : {1, 2, 4, 8}) {
    for (const double turn : {0.8, 1.05}) {  // of a half
      const double cosine = std::cos(turn * std::numbers::pi / substeps);
      const double mass = stiffest / (2.0 * substeps * substeps * (1.0 - cosine));
      const scene::CoupledStep step(box, rod(4, mass, substeps), scene::FluidMemory::Keeps);
      INFO(substeps << " sub-steps, " << turn << " half turns");
      CHECK(scene::AlternatingGrowth::of(step, scene::scales_of(step)).has_value() == (turn < 1.0));
    }
  }
}

TEST_CASE("Of many bodies that grow about alike the mean growth is found") {
  // So near to each other that no Krylov space of a few dimensions tells their eigenvalues apart.
  const fluid::Spec wide{.grid = {{64, 64, 20}}, .relaxation_time = 1.0};
  const double mass = 0.98 * scene::critical_node_mass(box, one_node(0.26, 1.0, 2, true), 1e-6);
  std::vector<scene::Body> bodies;
  for (int i = 0; i < 64; ++i) {
    scene::Body& body = bodies.emplace_back(one_node(0.26 * (1.0 + 1e-4 * i), mass, 2, true));
    body.place = {8.0 * (i % 8) + 4.3, 8.0 * (i / 8) + 3.9, 8.6};
  }
  const scene::CoupledStep step(wide, bodies, scene::FluidMemory::Keeps);
  const double all = scene::dense_growth(step).factor;
  REQUIRE(all > 1.001);
  CHECK(scene::large_growth(step).factor - 1.0 == Approx(all - 1.0).epsilon(0.05));
}

TEST_CASE("A weaker exchange is as stable as a strong one") {
  for (const double volume : {0.5, 0.6, 1.0}) {
    scene::Body weak = rod(6, 1.0, 4);
    weak.coupling->marker_volume = volume;
    CHECK(scene::coupling_growth(box, weak).factor == 1.0);
  }
}

TEST_CASE("Scales of an exchange are largest eigenvalues, which bounds by rows exceed") {
  const scene::CoupledStep step(box, rod(4, 1.0, 1), scene::FluidMemory::Keeps);
  const scene::Scales scales = scene::scales_of(step);
  const auto largest = [](const Eigen::MatrixXd& matrix) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly)
        .eigenvalues()
        .maxCoeff();
  };
  CHECK(scales.stiffness == Approx(largest(step.stiffness())).epsilon(1e-6));
  CHECK(scales.answered == Approx(largest(step.answering())).epsilon(1e-6));
  CHECK(scales.answered < 0.95 * solid::infinity_norm(step.answering()));
}

TEST_CASE("No node mass is looked for where V S is 2 or more") {
  scene::Body strong = one_node(0.26, 1.0, 2);
  strong.coupling->marker_volume = 2.0 / one_marker * 1.001;
  const scene::CoupledStep step(box, strong, scene::FluidMemory::Keeps);
  CHECK_FALSE(scene::AlternatingGrowth::of(step, scene::scales_of(step)).has_value());
  CHECK(scene::answered_slip(box, strong) == Approx(2.002).epsilon(1e-9));
  CHECK_THROWS_WITH(scene::critical_node_mass(box, strong, 0.01),
                    ContainsSubstring("no node mass is stable"));
}

TEST_CASE(
    "A node mass is found from any mass that the body has, and none where nothing is coupled or stiff") {
  for (const double mass : {1e-300, 1.0, 1e300}) {
    CHECK(scene::critical_node_mass(box, one_node(0.26, mass, 1), 1e-6) ==
          Approx(0.26 / 4.0 + 1.0 / (2.0 - one_marker)).epsilon(1e-4));
  }
  scene::Body held = one_node(0.26, 1.0, 1);
  held.conditions.fixed(1, 2) = true;
  CHECK(scene::critical_node_mass(box, held, 1e-6) == 0.0);
}
