// Numbers of a scene in time, held against what the scene did.
#include "observe/series.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "bond/harmonic.hpp"
#include "catch.hpp"
#include "scene/markers.hpp"

using namespace veriflex;

namespace {

/// The numbers of a row, by column.
double value(const observe::Series& series, const std::vector<double>& row, const std::string& column) {
  const auto at = std::find_if(series.columns.begin(), series.columns.end(),
                               [&](const observe::Column& c) { return c.name == column; });
  REQUIRE(at != series.columns.end());
  return row[static_cast<std::size_t>(at - series.columns.begin())];
}

/// Two nodes that swing against each other along z.
scene::Body pair(double stretch) {
  scene::Body body{.material = {bond::Harmonic{0.26, 1.0}, 0.0},
                   .network = solid::cubic_lattice({{1, 1, 2}, 1.0}),
                   .name = "pair"};
  body.start.displacement = Positions::Zero(2, 3);
  body.start.displacement(1, 2) = stretch;
  return body;
}

/// In a fluid that a force moves along x between walls.
fluid::Spec channel() {
  fluid::Spec spec{.grid = {{8, 6, 8}}, .relaxation_time = 0.9};
  spec.body_force = {1e-5, 0.0, 0.0};
  spec.walls[1].emplace();
  return spec;
}

}  // namespace

TEST_CASE(
    "The energy of a body is that of its motion and of its deformation, and stays what the start gave") {
  const scene::Scene scene{.bodies = {pair(0.01)}};
  const observe::Series series = observe::energies(scene);
  scene::Simulation simulation(scene);
  const double start = 0.5 * 0.26 * 0.01 * 0.01;
  double most_kinetic = 0.0;
  for (int step = 0; step < 40; ++step) {
    const std::vector<double> row = series.row(simulation);
    const double kinetic = value(series, row, "pair_kinetic"),
                 potential = value(series, row, "pair_potential");
    CHECK(value(series, row, "pair_total") == Approx(kinetic + potential).epsilon(1e-14));
    CHECK(value(series, row, "pair_total") == Approx(start).epsilon(0.15));  // leap-frog's swings about it
    most_kinetic = std::max(most_kinetic, kinetic);
    simulation.advance();
  }
  CHECK(most_kinetic > 0.8 * start);
}

TEST_CASE("The strains of a row are the extremes of every step since the row before") {
  const scene::Scene scene{.bodies = {pair(0.01)}};
  const observe::Series series = observe::strains(scene);
  scene::Simulation simulation(scene);
  series.every_step(simulation);
  for (int row = 0; row < 3; ++row) {
    double least = row == 0 ? 0.01 : INFINITY, greatest = -least;
    if (row == 0) greatest = 0.01;
    for (int step = 0; step < 9; ++step) {  // about a period: the extremes are not those of its end
      simulation.advance();
      series.every_step(simulation);
      const Positions& u = simulation.body().solid().displacement();
      least = std::min(least, u(1, 2) - u(0, 2));
      greatest = std::max(greatest, u(1, 2) - u(0, 2));
    }
    const std::vector<double> now = series.row(simulation);
    CHECK(value(series, now, "pair_min") == Approx(least).epsilon(1e-12));
    CHECK(value(series, now, "pair_max") == Approx(greatest).epsilon(1e-12));
  }
}

TEST_CASE(
    "What holds a body in a stream bears the fluid's force and its load, and walls what they take out") {
  scene::Body held = pair(0.0);
  held.place = {4.0, 2.5, 4.0};
  held.coupling = scene::CouplingSpec{};
  held.conditions.fixed = solid::FixedDofs::Constant(2, 3, true);
  held.conditions.load = Vec3(0.0, 2e-6, 0.0).transpose().replicate(2, 1);
  const scene::Scene scene{.fluid = channel(), .bodies = {held}};
  const observe::Series forces = observe::forces(scene), momentum = observe::momentum(scene);
  scene::Simulation simulation(scene);
  const auto see = [&] {
    forces.every_step(simulation);
    momentum.every_step(simulation);
  };
  see();
  const double pushed = 1e-5 * static_cast<double>(scene.fluid->grid.count());
  double on_body = 0.0;  // impulse of the fluid on it
  for (int step = 1; step <= 200; ++step) {
    simulation.advance();
    see();
    on_body += simulation.body().exchanged().col(0).sum();
  }
  const std::vector<double> force = forces.row(simulation), all = momentum.row(simulation);
  const double drag = simulation.body().exchanged().col(0).sum();
  CHECK(drag > 1e-5);
  CHECK(value(forces, force, "pair_fluid_x") == Approx(drag).epsilon(1e-14));
  CHECK(value(forces, force, "pair_support_x") == Approx(-drag).epsilon(1e-12));
  CHECK(value(forces, force, "pair_support_y") + value(forces, force, "pair_fluid_y") ==
        Approx(-4e-6).epsilon(1e-9));
  // Nothing is left of the balance of the fluid.
  const double fluid = simulation.fluid().totals().momentum[0];
  CHECK(value(momentum, all, "walls_x") == Approx(fluid - 200.0 * pushed + on_body).epsilon(1e-10));
  CHECK(value(momentum, all, "walls_x") < 0.0);
}

TEST_CASE(
    "The tip of a body is its last section, along the body's own axis, and moves as that does on average") {
  scene::Body plate = pair(0.0);
  plate.network = solid::cubic_lattice({{2, 2, 3}, 1.0});
  plate.network.rest = scene::turned(plate.network.rest, 1);
  plate.network.vectors = scene::turned(plate.network.vectors, 1);
  plate.axis = 1;
  plate.start.displacement = Positions::Zero(12, 3);
  Vec3 mean = Vec3::Zero();
  for (Eigen::Index i = 0; i < 12; ++i) {
    plate.start.displacement.row(i) << 1e-3 * static_cast<double>(i), 2e-3,
        -1e-3 * static_cast<double>(i * i);
    if (plate.network.rest(i, 1) == 2.0) mean += 0.25 * plate.start.displacement.row(i).transpose();
  }
  const scene::Scene scene{.bodies = {plate}};
  const observe::Series series = observe::tips(scene);
  const std::vector<double> row = series.row(scene::Simulation(scene));
  CHECK(value(series, row, "pair_x") == Approx(mean[0]).epsilon(1e-14));
  CHECK(value(series, row, "pair_y") == Approx(2e-3).epsilon(1e-14));
  CHECK(value(series, row, "pair_z") == Approx(mean[2]).epsilon(1e-14));
}

TEST_CASE(
    "The force of the fluid on all is that on the bodies and on the obstacle, where there are several") {
  scene::Body held = pair(0.0);
  held.place = {2.0, 2.5, 4.0};
  held.coupling = scene::CouplingSpec{};
  held.conditions.fixed = solid::FixedDofs::Constant(2, 3, true);
  scene::Body other = held;
  other.name = "other";
  other.place = {5.0, 2.5, 4.0};
  scene::Scene scene{.fluid = channel(), .bodies = {held}};
  for (const observe::Column& column : observe::forces(scene).columns) CHECK(column.name.find("total") != 0);
  scene.bodies.push_back(other);
  scene.fluid->obstacle = {scene.fluid->grid.index(3, 5, 0)};
  const observe::Series forces = observe::forces(scene);
  scene::Simulation simulation(scene);
  forces.every_step(simulation);
  for (int step = 0; step < 20; ++step) {
    simulation.advance();
    forces.every_step(simulation);
  }
  const std::vector<double> row = forces.row(simulation);
  CHECK(value(forces, row, "other_fluid_x") > 0.0);
  CHECK(value(forces, row, "obstacle_fluid_x") > 0.0);
  for (const std::string axis : {"x", "y", "z"}) {
    CHECK(value(forces, row, "total_fluid_" + axis) ==
          Approx(value(forces, row, "pair_fluid_" + axis) + value(forces, row, "other_fluid_" + axis) +
                 value(forces, row, "obstacle_fluid_" + axis))
              .epsilon(1e-13));
  }
}

TEST_CASE("What holds each of several bodies is what the change of its momentum and its load leave over") {
  scene::Scene scene{.bodies = {pair(0.01), pair(0.03), pair(-0.02)}};
  const std::array<std::string, 3> names{"first", "free", "last"};
  for (std::size_t i = 0; i < 3; ++i) {
    scene.bodies[i].name = names[i];
    if (names[i] == "free") continue;
    scene.bodies[i].conditions.fixed = solid::FixedDofs::Constant(2, 3, false);
    scene.bodies[i].conditions.fixed.row(0).setConstant(true);
  }
  const Vec3 load{2e-5, 0.0, 3e-4};
  scene.bodies[2].conditions.load = load.transpose().replicate(2, 1);
  const observe::Series forces = observe::forces(scene);
  scene::Simulation simulation(scene);
  forces.every_step(simulation);
  for (int step = 0; step < 5; ++step) {
    const Vec3 before[]{simulation.body(0).momentum(), simulation.body(2).momentum()};
    simulation.advance();
    forces.every_step(simulation);
    const std::vector<double> row = forces.row(simulation);
    const Vec3 first = simulation.body(0).momentum() - before[0],
               last = simulation.body(2).momentum() - before[1] - 2.0 * load;
    CHECK(first.norm() > 1e-6);
    for (int axis = 0; axis < 3; ++axis) {
      const std::string component{'_', "xyz"[axis]};
      CHECK(value(forces, row, "first_support" + component) == Approx(first[axis]).margin(1e-16));
      CHECK(value(forces, row, "last_support" + component) == Approx(last[axis]).margin(1e-16));
    }
  }
}

TEST_CASE("The slip of markers in a given motion is that of the fluid there against the motion now") {
  scene::Body plate{
      .material = {bond::Harmonic{0.26, 1.0}, 0.0},
      .network = solid::plate_lattice({{2.0, 2.0}, 0.0, 1.0}),
      .place = {4.3, 3.0, 4.1},
      .coupling = scene::CouplingSpec{},
      .motion = scene::Motion{.velocity = {1e-3, 0.0, 0.0}, .amplitude = {0.0, 0.0, 0.01}, .omega = 0.3},
      .name = "plate"};
  const scene::Scene scene{.fluid = fluid::Spec{.grid = {{8, 8, 8}}, .relaxation_time = 0.9},
                           .bodies = {plate}};
  const observe::Series series = observe::slip(scene);
  scene::Simulation simulation(scene);
  simulation.advance();
  // The fluid was at rest: the slip is the motion's velocity at the start, everywhere.
  const double speed = std::hypot(1e-3, 0.01 * 0.3);
  CHECK(value(series, series.row(simulation), "plate_rms") == Approx(speed).epsilon(1e-12));
  CHECK(value(series, series.row(simulation), "plate_max") == Approx(speed).epsilon(1e-12));
  simulation.advance();
  const Positions& slip = simulation.body().slip();
  CHECK(value(series, series.row(simulation), "plate_rms") ==
        Approx(std::sqrt(slip.squaredNorm() / static_cast<double>(slip.rows()))).epsilon(1e-12));
  CHECK(value(series, series.row(simulation), "plate_max") ==
        Approx(slip.rowwise().norm().maxCoeff()).epsilon(1e-12));
}
