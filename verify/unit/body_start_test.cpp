// Bodies that start deformed or moving, and the checks of a body that moves by its own forces alone.
#include <cmath>
#include <functional>
#include <numbers>

#include "bond/harmonic.hpp"
#include "catch.hpp"
#include "io/hdf5.hpp"
#include "observe/run.hpp"
#include "observe/series.hpp"
#include "scene/simulation.hpp"
#include "unit/command.hpp"

using namespace veriflex;
using unit::Folder;

namespace {

constexpr double k = 0.26;

/// Of harmonic bonds, without angles.
scene::Body block(std::array<std::int64_t, 3> nodes) {
  return {.material = {bond::Harmonic{k, 1.0}, 0.0}, .network = solid::cubic_lattice({nodes, 1.0})};
}

/// A pair of nodes that swings against each other by a strain: omega^2 = 2 k/m.
scene::Body pair(double strain, double mass) {
  scene::Body body = block({1, 1, 2});
  body.conditions.node_mass = mass;
  body.start.displacement = Positions::Zero(2, 3);
  body.start.displacement(1, 2) = strain;
  return body;
}

/// How a run of so many steps ends: without an error, or by which.
std::optional<FailureMode> end_of(const scene::Body& body, const observe::BodyLimits& limits, int steps) {
  scene::Simulation simulation(scene::Scene{.bodies = {body}});
  Progress progress("test");
  try {
    observe::Run run(simulation, {.every = 1, .bodies = limits}, {}, "", progress);
    run.advance(steps, steps);
    run.finish();
    return std::nullopt;
  } catch (const NumericalFailure& failure) {
    return failure.mode;
  }
}

/// A case of one bar that starts as `start` says.
std::string bar(const std::string& start, const std::string& monitor = "") {
  return unit::case_head("bar") + R"([[body]]
name = "bar"
shape = { block = { nodes = [2, 2, 6] } }
bond = { law = "harmonic", bond_stiffness = 0.26, rest_length = 1.0 }
node_mass = 4.0
)" + start +
         R"(
[[observe]]
what = "energies"
every = 1
[run]
steps = 1
[monitor]
)" + monitor;
}

}  // namespace

TEST_CASE("A body starts with the displacement and the velocity that it is given") {
  const double mass = 1.0, theta = 2.0 * std::asin(std::sqrt(2.0 * k / mass) / 2.0);
  scene::Body body = pair(0.01, mass);
  body.start.velocity = Positions::Zero(2, 3);
  body.start.velocity.col(0).setConstant(0.125);
  scene::Simulation simulation(scene::Scene{.bodies = {body}});
  for (int step = 1; step <= 20; ++step) {
    simulation.advance();
    const Positions u = simulation.body().displacement();
    CHECK(u(1, 0) == Approx(0.125 * step).epsilon(1e-14));
    // Leap-frog's recurrence, the pair's own turning left out: it moves along x as a whole.
    CHECK(u(1, 2) - u(0, 2) == Approx(0.01 * std::cos(theta * step)).margin(1e-15));
  }
}

TEST_CASE("What holds a node bears its force from the first step on") {
  scene::Body body = pair(0.25, 1e6);
  body.conditions.fixed = solid::FixedDofs::Constant(2, 3, false);
  body.conditions.fixed.row(0).setConstant(true);
  const scene::Scene scene{.bodies = {body}};
  const observe::Series forces = observe::forces(scene);
  scene::Simulation simulation(scene);
  for (int step = 0; step <= 3; ++step) {
    if (step > 0) simulation.advance();
    forces.every_step(simulation);
    if (step > 0) CHECK(forces.row(simulation)[2] == Approx(-0.25 * k).epsilon(1e-5));
  }
}

TEST_CASE("Energy that comes from nowhere ends a run just beyond leap-frog's limit, and not below it") {
  const double limit = k / 2.0;  // of the node mass: omega = sqrt(2 k/m), omega dt = 2
  const observe::BodyLimits limits{.energy_growth = 100.0};
  CHECK(end_of(pair(1e-3, 1.01 * limit), limits, 2000) == std::nullopt);
  CHECK(end_of(pair(1e-3, 0.99 * limit), limits, 2000) == FailureMode::Energy);
}

TEST_CASE("Energy that is lost ends a run as energy that is won does") {
  scene::Body slowed = pair(1e-3, 2.0 * k);
  slowed.conditions.drag = 0.1 * k;
  const observe::BodyLimits limits{.energy_growth = 0.5};
  CHECK(end_of(slowed, limits, 2000) == FailureMode::Energy);
  slowed.conditions.drag = 0.0;
  CHECK(end_of(slowed, limits, 2000) == std::nullopt);
}

TEST_CASE("A dead load puts energy in by its work") {
  scene::Body body = block({1, 1, 2});
  body.conditions.fixed = solid::FixedDofs::Constant(2, 3, false);
  body.conditions.fixed.row(0).setConstant(true);
  body.conditions.load = Positions::Zero(2, 3);
  body.conditions.load(1, 2) = 1e-3;
  const double limit = k / 4.0;
  const observe::BodyLimits limits{.energy_growth = 100.0};
  body.conditions.node_mass = 1.01 * limit;
  CHECK(end_of(body, limits, 2000) == std::nullopt);
  body.conditions.node_mass = 0.99 * limit;
  CHECK(end_of(body, limits, 2000) == FailureMode::Energy);
}

TEST_CASE("A bond over twice its length and a cell turned inside out are no solid, whatever the law allows") {
  const observe::BodyLimits limits{.physical = true};
  CHECK(end_of(pair(0.99, 10.0), limits, 1) == std::nullopt);
  CHECK(end_of(pair(1.01, 10.0), limits, 1) == FailureMode::Unphysical);
  CHECK(end_of(pair(1.01, 10.0), {}, 1) == std::nullopt);

  for (const double pushed : {-0.9, -1.1}) {  // the upper layer of a cube, towards and through the lower one
    scene::Body cube = block({2, 2, 2});
    cube.conditions.node_mass = 1e6;
    cube.start.displacement = Positions::Zero(8, 3);
    cube.start.displacement.col(2) = pushed * cube.network.rest.col(2);
    const bool through = pushed < -1.0;
    CHECK(end_of(cube, limits, 1) ==
          (through ? std::optional(FailureMode::Unphysical) : std::optional<FailureMode>()));
  }
  // A body that has turned is the same body.
  scene::Body turned = block({2, 2, 2});
  turned.conditions.node_mass = 1e6;
  const Positions& rest = turned.network.rest;
  turned.start.displacement = -2.0 * rest;
  turned.start.displacement.col(2).setZero();  // by half a turn about z
  CHECK(end_of(turned, limits, 1) == std::nullopt);
}

TEST_CASE(
    "A column whose middle leaves the line between its ends has buckled, a bent or moved body has not") {
  const observe::BodyLimits limits{.buckled = 0.1};
  const auto bowed = [](double strain, double bow) {  // of a column of 11 sections, clamped all over
    scene::Body column = block({2, 2, 11});
    column.conditions.fixed = solid::FixedDofs::Constant(44, 3, true);
    Positions& u = column.start.displacement = Positions::Zero(44, 3);
    const auto z = column.network.rest.col(2).array();
    u.col(2) = strain * z;
    u.col(0) = bow * (z * std::numbers::pi / 10.0).sin() + 0.3 * z;  // leaning, too
    return column;
  };
  // Of the line that leans by 0.3 the bow stands off by cos(atan 0.3) = 0.958, at a length of 10.
  CHECK(end_of(bowed(-0.1, 1.03), limits, 1) == std::nullopt);
  CHECK(end_of(bowed(-0.1, 1.06), limits, 1) == FailureMode::Buckled);
  CHECK(end_of(bowed(-0.1, 1.06), {}, 1) == std::nullopt);
  CHECK(end_of(bowed(-0.1, 0.051), {.buckled = 0.005}, 1) == std::nullopt);  // however small the limit
  CHECK(end_of(bowed(-0.1, 0.053), {.buckled = 0.005}, 1) == FailureMode::Buckled);
  CHECK(end_of(bowed(0.0, 3.0), limits, 1) == std::nullopt);  // its ends are as far apart as ever, or farther

  scene::Body shortest = block({2, 2, 3});  // one section between its ends
  shortest.conditions.fixed = solid::FixedDofs::Constant(12, 3, true);
  shortest.start.displacement = Positions::Zero(12, 3);
  const auto z = shortest.network.rest.col(2).array();
  shortest.start.displacement.col(2) = -0.1 * z;
  shortest.start.displacement.col(0) = 0.21 * z * (2.0 - z);
  CHECK(end_of(shortest, limits, 1) == FailureMode::Buckled);
}

TEST_CASE("A stiffness factor multiplies the energy of bonds and angles, exactly") {
  const Folder folder;
  const auto potential = [&](const std::string& more) {  // at the start
    folder.write("bar.toml",
                 bar("start = { noise = 0.01, strain = 0.02 }\nangle = { stiffness = 0.025 }\n" + more));
    CHECK(folder.run({"run", "bar.toml"}).code == 0);
    return io::Hdf5File(folder.path() / "results/bar.h5").numbers("/records/energies/bar_potential").front();
  };
  CHECK(potential("stiffness = 4.0\n") == 4.0 * potential(""));
  folder.write("bar.toml", bar("stiffness = 0.0"));
  CHECK_THAT(folder.run({"run", "bar.toml"}).err, ContainsSubstring("it lies between 1e-6 and 1e6"));
}

TEST_CASE("An impact of strain s moves its nodes with s r0 sqrt(k/m), and noise spares what is held") {
  const Folder folder;
  folder.write("bar.toml",
               bar(R"(start = { impact = { nodes = "last section", direction = "z", strain = 0.5 } })") +
                   R"(
[[check]]
kind = "verification"
statement = "four nodes, m v^2/2 = s^2 k/2 each"
metric = "energies.bar_kinetic.max"
target = 0.13
target_kind = "analytic"
source = "4 s^2 k/2, before the first step"
tolerance = { relative = 1e-14, reason = "round-off" }
)");
  CHECK(folder.run({"run", "bar.toml"}).code == 0);
  folder.write("bar.toml", bar("start = { noise = 0.1 }\nclamped = \"all\"") + R"(
[[check]]
kind = "verification"
statement = "nothing moves"
metric = "energies.bar_total.max"
target = 0.0
target_kind = "analytic"
source = "every node is clamped"
tolerance = { absolute = 1e-300, reason = "nothing may move" }
)");
  CHECK(folder.run({"run", "bar.toml"}).code == 0);
}

TEST_CASE("What bodies start with and are checked for is refused where it means nothing") {
  const Folder folder;
  const auto message = [&](const std::string& text) {
    folder.write("bar.toml", text);
    const unit::Ran ran = folder.run({"run", "bar.toml"});
    CHECK(ran.code == 2);
    return ran.err;
  };
  CHECK_THAT(message(bar("", "energy_growth = 100.0")),
             ContainsSubstring("the energy of 'bar' is not its own"));
  CHECK_THAT(message(bar("start = { noise = 0.01 }", "energy_growth = 0.0")),
             ContainsSubstring("no motion keeps"));
  CHECK_THAT(message(bar("", "buckled = 1.0")), ContainsSubstring("a part of a column's length"));
  CHECK_THAT(message(bar("start = { noise = 0.0 }")), ContainsSubstring("'noise' is 0"));
  CHECK_THAT(message(bar("start = { strain = -1.0 }")), ContainsSubstring("turned inside out"));
  CHECK_THAT(message(bar(
                 "guided = true\nstart = { impact = { nodes = \"all\", direction = \"x\", strain = 0.1 } }")),
             ContainsSubstring("none of these nodes may move"));
  CHECK_THAT(
      message(bar("guided = true\ndrive = { nodes = \"last section\", direction = \"x\", amplitude = 0.1, "
                  "period = 100 }")),
      ContainsSubstring("guided along its axis"));
  CHECK_THAT(message(bar("start = { seed = 3 }")), ContainsSubstring("seed"));
  CHECK_THAT(message(bar("start = { impact = { nodes = [99], direction = \"z\", strain = 0.1 } }")),
             ContainsSubstring("node 99"));
}
