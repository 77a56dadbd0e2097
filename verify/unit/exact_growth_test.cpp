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

TEST_CASE("A body that does not rest where it stands has no growth") {
  scene::Scene scene = small_scene(1.0, 1, false, scene::Coupled::All);
  scene.bodies[0].material.law = bond::Harmonic{0.26, 0.9};
  CHECK_THROWS_WITH(scene::exact_growth(scene), ContainsSubstring("does not rest"));
}
