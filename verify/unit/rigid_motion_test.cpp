// A body as a rigid one, its stretches, and when a column reaches a value.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "bond/harmonic.hpp"
#include "catch.hpp"
#include "observe/series.hpp"
#include "scene/simulation.hpp"
#include "unit/command.hpp"

using namespace veriflex;

namespace {

scene::Body free_block(const solid::Block& block) {
  solid::Network network = solid::cubic_lattice(block);
  solid::add_angles(network);
  return {.material = {bond::Harmonic{0.26, 1.0}, 0.025},
          .network = std::move(network),
          .place = {5.0, 6.0, 7.0},
          .name = "block"};
}

/// The row of a series after some steps of those bodies without a fluid.
std::vector<double> row_after(int steps, observe::Series (*of)(const scene::Scene&),
                              const std::vector<scene::Body>& bodies) {
  const scene::Scene scene{.bodies = bodies};
  const observe::Series series = of(scene);
  scene::Simulation simulation(scene);
  if (series.every_step) series.every_step(simulation);
  for (int step = 0; step < steps; ++step) {
    simulation.advance();
    if (series.every_step) series.every_step(simulation);
  }
  return series.row(simulation);
}

}  // namespace

TEST_CASE("A body that moves as a rigid one has that velocity, angular velocity and turn") {
  scene::Body body = free_block({{3, 4, 5}, 1.0});
  const Vec3 omega(1e-5, -2e-5, 3e-5), velocity(1e-4, 2e-4, -3e-4);
  const Positions& rest = body.network.rest;
  const Positions x = rest.rowwise() - rest.colwise().mean();
  body.start.velocity.resize(rest.rows(), 3);
  for (Eigen::Index i = 0; i < rest.rows(); ++i)
    body.start.velocity.row(i) = (velocity + omega.cross(Vec3(x.row(i)))).transpose();
  constexpr int steps = 50;
  const std::vector<double> row = row_after(steps, &observe::rigid_motion, {body});
  const Vec3 centre = body.place + Vec3(rest.colwise().mean()) + steps * velocity;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    CHECK(row[axis] == Approx(centre[a]).epsilon(1e-12));
    CHECK(row[3 + axis] == Approx(velocity[a]).epsilon(1e-10));
    CHECK(row[6 + axis] == Approx(omega[a]).epsilon(1e-3));
    CHECK(row[9 + axis] == Approx(steps * omega[a]).epsilon(1e-3));
  }
}

TEST_CASE("Each of several bodies turns as it does alone") {
  scene::Body one = free_block({{2, 3, 2}, 1.0}), other = free_block({{3, 2, 2}, 1.0});
  one.start.velocity = other.start.velocity = Positions::Zero(12, 3);
  one.start.velocity(0, 1) = 1e-5;
  other.start.velocity(5, 2) = -3e-5;
  std::vector<double> alone = row_after(20, &observe::rigid_motion, {one});
  const std::vector<double> of_other = row_after(20, &observe::rigid_motion, {other});
  alone.insert(alone.end(), of_other.begin(), of_other.end());
  CHECK(row_after(20, &observe::rigid_motion, {one, other}) == alone);
}

TEST_CASE("Where a single node moves, the body turns by its angular momentum over the inertia of all") {
  for (const Eigen::Index moving : {0, 7}) {
    CAPTURE(moving);
    scene::Body body = free_block({{2, 2, 2}, 1.0});
    body.start.velocity = Positions::Zero(8, 3);
    const Vec3 velocity(1e-5, 2e-5, -1e-5);
    body.start.velocity.row(moving) = velocity.transpose();
    const Positions& rest = body.network.rest;
    const Vec3 x = (rest.row(moving) - rest.colwise().mean()).transpose();
    const Vec3 omega = x.cross(velocity) / (8.0 * 0.5);  // sum of y^2 + z^2 over the corners
    const std::vector<double> row = row_after(0, &observe::rigid_motion, {body});
    for (std::size_t axis = 0; axis < 3; ++axis)
      CHECK(row[6 + axis] == Approx(omega[static_cast<Eigen::Index>(axis)]).epsilon(1e-12));
  }
}

TEST_CASE("A line of nodes turns about the axes across it only") {
  scene::Body body = free_block({{1, 1, 4}, 1.0});
  body.start.velocity = Positions::Zero(4, 3);
  for (Eigen::Index i = 0; i < 4; ++i)
    body.start.velocity.row(i) = Vec3(1e-5, 0.0, 0.0).cross(Vec3(body.network.rest.row(i))).transpose();
  const std::vector<double> row = row_after(0, &observe::rigid_motion, {body});
  CHECK(row[6] == Approx(1e-5).epsilon(1e-10));
  CHECK(row[7] == Approx(0.0).margin(1e-18));
  CHECK(row[8] == Approx(0.0).margin(1e-18));
}

TEST_CASE("An affine map of a body has its own principal stretches, however it is turned") {
  scene::Body body = free_block({{4, 3, 3}, 1.0});
  const Mat3 turn = Eigen::AngleAxisd(2.0, Vec3(1.0, 2.0, -1.0).normalized()).toRotationMatrix();
  const Mat3 other = Eigen::AngleAxisd(0.7, Vec3::UnitX()).toRotationMatrix();
  const Mat3 map = turn * Vec3(1.1, 0.8, 1.0).asDiagonal() * other;
  body.start.displacement = body.network.rest * (map - Mat3::Identity()).transpose();
  const std::vector<double> row = row_after(0, &observe::deformation, {body});
  REQUIRE(row.size() == 4);
  CHECK(row[0] == Approx(1.1).epsilon(1e-12));
  CHECK(row[1] == Approx(1.0).epsilon(1e-12));
  CHECK(row[2] == Approx(0.8).epsilon(1e-12));
  CHECK(row[3] == Approx(0.3 / 1.9).epsilon(1e-12));
}

TEST_CASE("A body whose nodes lie in a plane has no stretch across it, and no column") {
  CHECK(observe::deformation(scene::Scene{.bodies = {free_block({{4, 3, 1}, 1.0})}}).columns.empty());
}

namespace {

/// The exit code of a run in which a fluid gains 0.0064 of momentum a step, looked at every ten steps.
int accelerated(const std::string& asked, const std::string& metric, double target) {
  const unit::Folder folder;
  folder.write("wave.toml", unit::case_head("wave") + fmt::format(R"([fluid]
nodes = [4, 4, 4]
relaxation_time = 1.0
body_force = [1e-4, 0.0, 0.0]
[[observe]]
what = "momentum"
every = 10
{}
[run]
steps = 100
[[check]]
kind = "verification"
statement = "uniform acceleration"
metric = "momentum.fluid_x.{}"
target = {}
target_kind = "analytic"
source = "64 nodes of 1e-4 a step: 0.0064 t"
tolerance = {{ absolute = 1e-9, reason = "rounding" }}
)",
                                                                  asked, metric, target));
  return folder.run({"run", "wave.toml", "--out", "out"}).code;
}

}  // namespace

TEST_CASE(
    "A column reaches its value between two rows, counted from another, or the run says that it did not") {
  const auto outcome = [](const std::string& reaches) {
    return accelerated("reaches = " + reaches, "reached", 25.0);
  };
  CHECK(outcome(R"({ column = "fluid_x", value = 0.16 })") == 0);
  CHECK(outcome(R"({ column = "fluid_x", value = 0.24, from = 0.08 })") == 0);
  CHECK(outcome(R"({ column = "fluid_x", value = 0.64001 })") == 3);
  CHECK(outcome(R"({ column = "fluid", value = 0.1 })") == 2);
}

TEST_CASE("Mean and extremes of a column are of the rows since the time that is asked for") {
  CHECK(accelerated("", "mean", 0.32) == 0);
  CHECK(accelerated("mean_from = 41.0", "mean", 0.48) == 0);  // of 50, 60 ... 100 steps
  CHECK(accelerated("mean_from = 50.0", "min", 0.32) == 0);
  CHECK(accelerated("mean_from = 100.0", "mean", 0.64) == 0);
  CHECK(accelerated("mean_from = 100.5", "mean", 0.64) == 2);
}

TEST_CASE(
    "A column that swings has a period and extremes over whole ones, or the run says that it has none") {
  // A node on a bond whose other end is held, by leap-frog at its own frequency.
  const auto ran = [](const std::string& swings, const std::string& checks) {
    const unit::Folder folder;
    folder.write("bond.toml", unit::case_head("bond") + R"([[body]]
name = "pair"
shape = { chain = { nodes = 2 } }
bond = { law = "harmonic", bond_stiffness = 0.01, rest_length = 1.0 }
node_mass = 1.0
clamped = "first section"
start = { strain = 0.02 }
[[observe]]
what = "rigid motion"
every = 1
swings = )" + swings + R"(
[run]
steps = 400
)" + checks);
    return folder.run({"run", "bond.toml", "--out", "out"}).code;
  };
  const auto check = [](const std::string& metric, double target, const std::string& tolerance) {
    return fmt::format(R"([[check]]
kind = "verification"
statement = "exact"
metric = "rigid_motion.pair_{}"
target = {:.17g}
target_kind = "analytic"
source = "leap-frog: sin omega dt/2 = sqrt k/m dt/2"
tolerance = {{ absolute = {}, reason = "linear between rows" }}
)",
                       metric, target, tolerance);
  };
  const double omega = 2.0 * std::asin(0.5 * std::sqrt(0.01));
  const std::string z = R"({ column = "pair_z", from = 100.0 })";
  CHECK(ran(z, check("z.period", 2.0 * std::numbers::pi / omega, "1e-3")) == 0);
  CHECK(ran(z, check("z.swing_max", 0.51, "1e-5")) == 0);  // the centre of both nodes
  CHECK(ran(z, check("z.swing_mean", 0.5, "1e-4")) == 0);
  CHECK(ran(R"({ column = "pair_z", from = 390.0 })", "") == 3);
  CHECK(ran(R"({ column = "pair", from = 0.0 })", "") == 2);
}
