// Numbers of a scene in time, held against what the scene did.
#include "observe/series.hpp"

#include <algorithm>
#include <cmath>

#include "bond/harmonic.hpp"
#include "catch.hpp"

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
