// The spectrum of a scene's own steps: against the waves of the fluid's lattice, subspace iteration, and
// runs; and what the cheap map calls stable against it.
#include "scene/exact_growth.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "analytic/lattice_wave.hpp"
#include "base/error.hpp"
#include "bond/harmonic.hpp"
#include "catch.hpp"
#include "measures/coupling/kicked_run.hpp"
#include "scene/coupling_stability.hpp"
#include "scene/simulated_step.hpp"
#include "scene/transient_growth.hpp"

using namespace veriflex;

namespace {

/// A few nodes in a small box, coupled all or at the surface.
scene::Scene small_scene(double mass, int substeps, bool subcycled, scene::Coupled coupled) {
  solid::Network network = solid::cubic_lattice({{2, 2, 3}, 1.0});
  solid::add_angles(network);
  scene::Body body{{bond::Harmonic{0.26, 1.0}, 0.025}, network, {}, {substeps, 0.0}};
  body.conditions.node_mass = mass;
  body.place = {3.3, 2.9, 2.6};
  body.coupling = {.coupled = coupled, .subcycled = subcycled};
  return {.fluid = fluid::Spec{.grid = {{8, 8, 8}}, .relaxation_time = 0.8}, .bodies = {body}};
}

scene::Scene kicked(scene::Scene scene) {
  for (scene::Body& body : scene.bodies) {
    body.conditions.load = measures::kick_of(body.network.node_count(), 1);
  }
  return scene;
}

}  // namespace

TEST_CASE("A fluid alone decays as the slowest of all waves of its lattice does") {
  constexpr std::array<std::int64_t, 3> size{8, 6, 4};
  for (const double tau : {0.7, 1.0}) {
    double slowest = 0.0;
    for (std::int64_t i = 0; i < size[0] * size[1] * size[2]; ++i) {
      const auto node = Grid{size}.node(i);
      Vec3 k;
      for (std::size_t a = 0; a < 3; ++a) {
        k[static_cast<int>(a)] =
            2.0 * std::numbers::pi * static_cast<double>(node[a]) / static_cast<double>(size[a]);
      }
      const Eigen::ComplexEigenSolver<Eigen::MatrixXcd> waves(analytic::one_step(k, tau), false);
      for (const auto& factor : waves.eigenvalues()) {
        if (std::abs(factor) < 1.0 - 1e-9) slowest = std::max(slowest, std::abs(factor));
      }
    }
    const scene::Scene scene{.fluid = fluid::Spec{.grid = {size}, .relaxation_time = tau}};
    const scene::ExactGrowth found = scene::exact_growth(scene);
    CHECK(found.factor == Approx(slowest).epsilon(1e-6));
    CHECK_FALSE(found.grows());
    CHECK(found.spectrum.front().bodies == 0.0);
  }
}

TEST_CASE("A lattice of even size keeps mass and twelve momenta, one of odd size mass and momentum") {
  const auto invariants = [](std::array<std::int64_t, 3> size) {
    const scene::Scene scene{.fluid = fluid::Spec{.grid = {size}, .relaxation_time = 0.8}};
    return scene::SimulatedStep(scene).invariants();
  };
  CHECK(invariants({4, 6, 4}) == 13);
  CHECK(invariants({5, 7, 5}) == 4);  // a checkerboard does not fit
}

TEST_CASE("The leading eigenvalue is the one that subspace iteration finds") {
  scene::Scene scene = small_scene(0.4, 1, false, scene::Coupled::All);
  scene.fluid->grid = {{6, 6, 4}};
  scene.bodies[0].network = solid::cubic_lattice({{1, 1, 3}, 1.0});
  scene.bodies[0].material.angle_stiffness = 0.0;
  const scene::SimulatedStep step(scene);
  constexpr Eigen::Index dimensions = 60;
  Eigen::MatrixXd basis(step.size(), dimensions);
  std::mt19937 random(3);
  for (Eigen::Index i = 0; i < dimensions; ++i) {
    Eigen::VectorXd x(step.size());
    for (double& value : x) value = static_cast<double>(random()) / 4294967296.0 - 0.5;
    basis.col(i) = step.after(step.without_neutral(x), 8);
  }
  double factor = 0.0;
  for (int pass = 0; pass < 12; ++pass) {
    for (Eigen::Index i = 0; i < dimensions; ++i) {
      for (int twice = 0; twice < 2; ++twice) {
        const Eigen::VectorXd B = step.weighted(basis.col(i));
        basis.col(i) -= basis.leftCols(i) * (basis.leftCols(i).transpose() * B);
      }
      basis.col(i) /= step.length(basis.col(i));
    }
    Eigen::MatrixXd images(step.size(), dimensions), projected(dimensions, dimensions);
    for (Eigen::Index i = 0; i < dimensions; ++i) {
      images.col(i) = step.after(basis.col(i), 1);
      projected.col(i) = basis.transpose() * step.weighted(images.col(i));
    }
    factor = Eigen::EigenSolver<Eigen::MatrixXd>(projected, false).eigenvalues().cwiseAbs().maxCoeff();
    basis = images;
  }
  CHECK(scene::exact_growth(scene).factor == Approx(factor).epsilon(1e-6));
}

TEST_CASE("The spectrum of what decays by a tenth a step is found above the rounding of a step") {
  for (const double mass : {1.36, 1.5}) {
    scene::Scene scene = small_scene(mass, 1, false, scene::Coupled::All);
    scene.fluid->relaxation_time = 1.5;
    scene.bodies[0].material = {bond::Harmonic{0.78, 1.0}, 0.075};
    scene.bodies[0].coupling->marker_volume = 0.25;
    const scene::ExactGrowth found = scene::exact_growth(scene, {.eigenvalues = 1});
    CHECK(found.factor == Approx(0.91).epsilon(0.02));
    CHECK(found.residual < 1e-5);
  }
}

TEST_CASE("A kicked run grows as the spectrum says") {
  for (const bool subcycled : {false, true}) {
    scene::Scene scene = small_scene(1.0, subcycled ? 3 : 1, subcycled, scene::Coupled::Boundary);
    double& mass = scene.bodies[0].conditions.node_mass;
    mass = 0.95 * scene::critical_node_mass(*scene.fluid, scene.bodies[0], 1e-3);
    const scene::ExactGrowth found = scene::exact_growth(scene);
    REQUIRE(found.grows());
    const measures::KickedRun run = measures::run_kicked(kicked(scene), 1500);
    CHECK(run.grows);
    CHECK(run.growth == Approx(found.factor).epsilon(2e-3));
  }
}

TEST_CASE("Runs grow below the critical mass of the spectrum, and not above") {
  const scene::Scene scene = small_scene(1.0, 2, false, scene::Coupled::All);
  const double guess = scene::critical_node_mass(*scene.fluid, scene.bodies[0], 1e-3);
  const double mass = scene::critical_mass_factor(scene, guess, 1e-3);
  CHECK(mass < 1.001 * guess);
  const auto grows = [&](double m) {
    return measures::run_kicked(kicked(small_scene(m, 2, false, scene::Coupled::All)), 3000).grows;
  };
  CHECK(grows(0.995 * mass));
  CHECK_FALSE(grows(1.005 * mass));
}

namespace {

/// A free body of 2 to 8 nodes, all coupled: a node that is not swings undamped, which is no growth either,
/// but hides what else is near.
scene::Scene random_scene(std::mt19937& random) {
  const auto between = [&](double lo, double hi) {
    return lo + (hi - lo) * static_cast<double>(random()) / 4294967296.0;
  };
  const auto number = [&](std::int64_t lo, std::int64_t hi) {
    return lo + static_cast<std::int64_t>(random()) % (hi - lo + 1);
  };
  const auto of_any_size = [&](double lo, double hi) {
    return std::exp(between(std::log(lo), std::log(hi)));
  };
  solid::Network network = solid::cubic_lattice({{number(1, 2), number(1, 2), 2}, 1.0});
  const double angle = number(0, 3) == 0 ? 0.0 : between(0.0, 0.05);
  if (angle > 0.0) solid::add_angles(network);
  scene::Body body{{bond::Harmonic{of_any_size(0.01, 2.0), 1.0}, angle},
                   network,
                   {},
                   {static_cast<int>(number(1, 4)), 0.0}};
  body.place = {between(2.0, 3.0), between(2.0, 3.0), between(2.0, 3.0)};
  body.coupling = {
      .coupled = scene::Coupled::All, .marker_volume = of_any_size(0.1, 2.0), .subcycled = number(0, 1) == 1};
  return {.fluid = fluid::Spec{.grid = {{6, 6, 6}}, .relaxation_time = of_any_size(0.65, 2.0)},
          .bodies = {body}};
}

}  // namespace

TEST_CASE("What the map calls stable, the spectrum calls stable") {
  std::mt19937 random(5);
  for (int i = 0; i < 8; ++i) {
    scene::Scene scene = random_scene(random);
    scene::Body& body = scene.bodies[0];
    // Where a stabilisation that the map counts on and the fluid does not give would show first.
    body.conditions.node_mass = 1.002 * scene::critical_node_mass(*scene.fluid, body, 2e-4);
    INFO("body " << i << " of " << body.network.node_count() << " nodes, m = " << body.conditions.node_mass);
    CHECK_FALSE(scene::coupling_growth(*scene.fluid, body).grows());
    CHECK_FALSE(scene::exact_growth(scene, {.eigenvalues = 1}).grows());
  }
}

TEST_CASE("Two plates that share nodes of the fluid grow where each alone does not, and their map says so") {
  scene::Body plate{{bond::Harmonic{0.05, 1.0}, 0.0}, solid::cubic_lattice({{2, 2, 1}, 1.0}), {}, {1, 0.0}};
  plate.place = {2.0, 2.0, 2.0};
  plate.coupling = {.coupled = scene::Coupled::All};
  scene::Body other = plate;
  other.place[2] += 1.0;
  scene::Scene both{.fluid = fluid::Spec{.grid = {{6, 6, 8}}, .relaxation_time = 1.0},
                    .bodies = {plate, other}};
  const double alone = scene::critical_node_mass(*both.fluid, plate, 1e-4);
  const auto with_mass = [&](double mass) {
    for (scene::Body& body : both.bodies) body.conditions.node_mass = mass;
    return both;
  };
  CHECK(scene::bodies_that_share_nodes(both) == std::vector<std::vector<std::size_t>>{{0, 1}});
  with_mass(1.01 * alone);
  CHECK_FALSE(scene::coupling_growth(*both.fluid, both.bodies[0]).grows());
  CHECK(scene::exact_growth(both, {.eigenvalues = 1}).grows());
  CHECK(scene::coupling_growth(*both.fluid, both.bodies).grows());
  double mass = 1.02 * alone;
  while (scene::coupling_growth(*both.fluid, with_mass(mass).bodies).grows()) mass *= 1.02;
  CHECK(mass < 1.5 * alone);
  CHECK_FALSE(scene::exact_growth(both, {.eigenvalues = 1}).grows());

  both.bodies[1].place[2] += 3.0;  // their supports do not meet
  CHECK(scene::bodies_that_share_nodes(both).size() == 2);
  CHECK_FALSE(scene::coupling_growth(*both.fluid, with_mass(1.01 * alone).bodies).grows());
}

TEST_CASE("A run that has decayed to what rounding leaves does not grow") {
  scene::Scene scene = small_scene(1.0, 1, false, scene::Coupled::All);
  double& mass = scene.bodies[0].conditions.node_mass;
  mass = 1.2 * scene::critical_node_mass(*scene.fluid, scene.bodies[0], 1e-3);
  for (const std::int64_t steps : {2000, 2500, 3000, 3500}) {
    CHECK_FALSE(measures::run_kicked(kicked(scene), steps).grows);
  }
}

TEST_CASE("Growth is asked neither of a scene without fluid nor of float populations") {
  scene::Scene scene = small_scene(1.0, 1, false, scene::Coupled::All);
  scene.fluid->storage = fluid::Storage::Float;
  CHECK_THROWS_AS(scene::exact_growth(scene), BadParameter);
  scene.fluid.reset();
  CHECK_THROWS_AS(scene::exact_growth(scene), BadParameter);
}

TEST_CASE("A spectrum that is not found is an error, not a stable scene") {
  scene::Scene scene = small_scene(1.0, 1, false, scene::Coupled::All);
  scene.fluid->relaxation_time = 0.51;  // all decays slowly
  try {
    scene::exact_growth(scene, {.resolution = 1e-3, .most_steps = 10});
    FAIL("found in ten steps");
  } catch (const NumericalFailure& failure) {
    CHECK(failure.mode == FailureMode::NotConverged);
  }
}

TEST_CASE("A scene at rest has neither a flow to start from nor what would set it in motion") {
  scene::Scene scene{.fluid = fluid::Spec{.grid = {{4, 4, 4}}, .relaxation_time = 0.9}};
  scene.initial_flow = [](std::int64_t) { return fluid::Populations{}; };
  scene.fluid->body_force = {1e-5, 0.0, 0.0};
  scene.fluid->walls[1].emplace().high_velocity = {0.01, 0.0, 0.0};
  const scene::Scene rests = scene::at_rest(scene);
  CHECK(!rests.initial_flow);
  CHECK(rests.fluid->body_force.isZero(0.0));
  CHECK(rests.fluid->walls[1]->high_velocity.isZero(0.0));
}

TEST_CASE("A body that does not rest where it stands has no growth") {
  scene::Scene scene = small_scene(1.0, 1, false, scene::Coupled::All);
  scene.bodies[0].material.law = bond::Harmonic{0.26, 0.9};
  CHECK_THROWS_WITH(scene::exact_growth(scene), ContainsSubstring("does not rest"));
}

TEST_CASE(
    "The most that steps amplify is no less than what they do to any state, and tends to the spectrum's "
    "rate") {
  scene::Scene scene = small_scene(0.7, 1, false, scene::Coupled::All);
  scene.fluid->grid = {{6, 6, 6}};
  const std::vector<std::int64_t> steps{1, 8, 64};
  const std::vector<double> grown = scene::transient_growth(scene, steps);
  const scene::SimulatedStep step(scene);
  double largest = 0.0;
  scene::SimulatedStep::Vector state = step.noise();
  for (int i = 0; i < 40; ++i) {  // the state that a run comes to is one that grows, or decays slowest
    const scene::SimulatedStep::Vector next = step.after(state, 1);
    largest = std::max(largest, step.length(next) / step.length(state));
    state = next / step.length(next);
  }
  CHECK(grown[0] >= largest * (1.0 - 1e-6));
  CHECK(grown[0] > 1.0);
  const double rate = scene::exact_growth(scene, {.eigenvalues = 2}).factor;
  CHECK(grown[2] >= std::pow(rate, 64) * (1.0 - 1e-4));
  CHECK(std::pow(grown[2] / grown[1], 1.0 / 56.0) == Approx(rate).epsilon(0.02));
}

TEST_CASE(
    "By the implicit rule a light body is stable where its force follows it, and grows where it is frozen") {
  for (const bool subcycled : {true, false}) {
    scene::Scene scene = small_scene(0.05, 1, subcycled, scene::Coupled::All);
    scene.bodies[0].scheme = solid::Scheme::ImplicitMidpoint;
    const scene::ExactGrowth exact = scene::exact_growth(scene, {.eigenvalues = 2});
    const scene::Growth map = scene::coupling_growth(*scene.fluid, scene.bodies[0]);
    CHECK(exact.grows() == !subcycled);
    CHECK(map.grows() == !subcycled);
    if (!subcycled) CHECK(exact.factor == Approx(map.factor).epsilon(0.05));
  }
}

TEST_CASE("In lengths of energies a fluid alone amplifies nothing") {
  const scene::Scene scene{.fluid = fluid::Spec{.grid = {{4, 4, 4}}, .relaxation_time = 0.6}};
  const std::vector<std::int64_t> steps{1, 4};
  for (const double grown : scene::transient_growth(scene, steps)) CHECK(grown <= 1.0 + 1e-6);
}
