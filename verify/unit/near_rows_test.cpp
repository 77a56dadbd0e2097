// Bodies in a fluid that makes many steps at once: the rows near them go ahead, and nothing else changes.
#include "fluid/near_rows.hpp"

#include <fmt/format.h>
#include <omp.h>
#include <signal.h>

#include <random>

#include "base/stop.hpp"
#include "catch.hpp"
#include "driven_bar.hpp"
#include "observe/run.hpp"
#include "row_order.hpp"

using namespace veriflex;
using namespace veriflex::unit;

namespace {

using Random = std::mt19937;

double any_place(Random& random, double least, double most) {
  return std::uniform_real_distribution<double>(least, most)(random);
}

bool are_same(const scene::State& a, const scene::State& b) {
  bool same =
      a.steps == b.steps && a.fluid->steps == b.fluid->steps && a.fluid->populations == b.fluid->populations;
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    if (!a.bodies[i].elastic) continue;
    same = same && a.bodies[i].elastic->displacement == b.bodies[i].elastic->displacement &&
           a.bodies[i].elastic->velocity == b.bodies[i].elastic->velocity;
  }
  return same;
}

/// One or two bars anywhere, across the faces too where there are no walls, and now and then a sphere in a
/// given motion; held or driven, force frozen or following.
scene::Scene any_scene(Random& random) {
  const auto setting = [&] { return Setting{0.7, any(random, 0, 1) == 0, any(random, 0, 1) == 0}; };
  scene::Scene scene = disordered(setting());
  fluid::Spec& fluid = *scene.fluid;
  fluid.grid.size = {any(random, 0, 1) == 0 ? 12 : 16, any(random, 24, 40), any(random, 24, 40)};
  if (any(random, 0, 1) == 0) fluid.storage = fluid::Storage::Float;
  if (any(random, 0, 1) == 0) fluid.body_force = {1e-4, -2e-4, 5e-5};
  for (auto& walls : fluid.walls) {
    const std::int64_t kind = any(random, 0, 5);
    if (kind == 0) walls = fluid::Walls{};
    if (kind == 1) walls = fluid::sliding();
  }
  const auto somewhere_in = [&] {
    Vec3 place;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto size = static_cast<double>(fluid.grid.size[axis]);
      place[static_cast<Eigen::Index>(axis)] =
          fluid.walls[axis] ? any_place(random, 2.5, size - 7.0) : any_place(random, -size, 2.0 * size);
    }
    return place;
  };
  scene.bodies.front().place = somewhere_in();
  if (any(random, 0, 1) == 0) scene.bodies.push_back(kicked_bar(setting(), somewhere_in()));
  if (any(random, 0, 2) == 0) {
    scene::Body towed = bar(setting(), somewhere_in());
    towed.motion = scene::Motion{.velocity = {0.001, 0.0, 0.0}, .amplitude = {0.0, 0.3, 0.0}, .omega = 0.2};
    scene.bodies.push_back(std::move(towed));
  }
  return scene;
}

}  // namespace

TEST_CASE("Bodies and fluid move the same bit by bit when the rows near the bodies go ahead of the others") {
  Random random(20261127);
  int ahead = 0;
  for (int trial = 0; trial < 60; ++trial) {
    scene::Scene scene = any_scene(random);
    const std::int64_t before = any(random, 0, 3), steps = any(random, 2, 40);
    CAPTURE(trial, scene.fluid->grid.size, scene.bodies.size(), before, steps);
    scene.fluid->blocking = fluid::Blocking{1, 100};
    scene::Simulation plain(scene);
    plain.advance(before + steps);
    CHECK(plain.seconds().near.wall == 0.0);

    scene.fluid->blocking = fluid::Blocking{any(random, 2, 9), any(random, 1, 30)};
    const Threads threads(static_cast<int>(any(random, 1, 3)));
    CAPTURE(scene.fluid->blocking->steps, scene.fluid->blocking->rows, omp_get_max_threads());
    scene::Simulation blocked(scene);
    blocked.advance(before);
    blocked.advance(steps);
    CHECK(are_same(blocked.state(), plain.state()));
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      CHECK(blocked.body(i).exchanged() == plain.body(i).exchanged());
      CHECK(blocked.body(i).slip() == plain.body(i).slip());
    }
    ahead += blocked.seconds().near.wall > 0.0 ? 1 : 0;
  }
  CHECK(ahead > 30);  // else the rows near the bodies were too many to go ahead
}

TEST_CASE("Rows near a body make as many steps ahead as those of the body need to be known") {
  Random random(11);
  for (int trial = 0; trial < 200; ++trial) {
    const fluid::RowGrid grid{any(random, 1, 30), any(random, 1, 30)};
    const std::int64_t steps = any(random, 1, 12);
    const int threads = static_cast<int>(any(random, 1, 3));
    std::vector<std::int64_t> touched;
    for (std::int64_t i = any(random, 0, 4); i > 0; --i)
      touched.push_back(any(random, 0, grid.rows * grid.planes - 1));
    const fluid::NearRows near(grid, touched, steps);
    CHECK(near.cover(touched));

    RowOrder order(grid);
    const fluid::MakeRows make = [&](std::int64_t step, std::int64_t z, std::int64_t y_begin,
                                     std::int64_t y_end) { order.make(step, z, y_begin, y_end); };
    int unknown = 0;
    CAPTURE(trial, grid.rows, grid.planes, steps, threads, touched);
    const std::int64_t until = any(random, 1, steps);  // a block may end early
    for (std::int64_t step = 0; step < until; ++step) {
      near.make(step, threads, make);
      // Touched rows and all beside them, two rows off since a support may move on by one, are known.
      for (const std::int64_t row : touched) {
        for (std::int64_t dy = -2; dy <= 2; ++dy) {
          for (std::int64_t dz = -2; dz <= 2; ++dz) {
            const bool known = order.at(row % grid.rows + dy, row / grid.rows + dz) == step + 1;
            if (step + 1 < steps && !known) ++unknown;
          }
        }
      }
    }
    fluid::make_steps(grid, until, {until, any(random, 1, 30)}, threads,
                      [&](std::int64_t step, std::int64_t z, std::int64_t y_begin, std::int64_t y_end) {
                        near.make_others(step, z, y_begin, y_end, make);
                      });
    CHECK(unknown == 0);
    CHECK(order.out_of_order() == 0);
    CHECK(order.all_have_made(until));
  }
}

TEST_CASE("A body that leaves the rows ahead ends the block, and the run is the same") {
  scene::Scene scene = disordered({0.7, false, false}, {5.0, 6.0, 8.0});
  scene.fluid->grid.size = {12, 40, 40};
  scene.bodies.front().motion = scene::Motion{.velocity = {0.0, 0.45, 0.3}};
  scene.fluid->blocking = fluid::Blocking{12, 8};
  scene::Simulation blocked(scene);
  blocked.advance(36);
  scene.fluid->blocking = fluid::Blocking{1, 8};
  scene::Simulation plain(scene);
  plain.advance(36);
  CHECK(are_same(blocked.state(), plain.state()));
}

TEST_CASE(
    "A body that fails in the midst of a block leaves the fluid as a failure between single steps does") {
  scene::Scene scene = disordered({0.7, true, false}, {5.0, 10.0, 15.0});
  scene.fluid->grid.size = {12, 32, 40};
  scene.bodies.front().conditions.load.row(15) << 0.0, 0.0, 1.0;  // pulls its bonds to their limit
  const auto failing = [&](std::int64_t steps) {
    scene.fluid->blocking = fluid::Blocking{steps, 8};
    scene::Simulation simulation(scene);
    std::string why;
    try {
      simulation.advance(60);
    } catch (const NumericalFailure& failure) {
      why = failure.what();
    }
    return std::pair(why, simulation.state());
  };
  const auto plain = failing(1), blocked = failing(7);
  INFO(plain.first << plain.second.steps << " " << displacement(plain.second).row(15) << " "
                   << displacement(plain.second).row(11));
  CHECK(plain.first.find("bond") != std::string::npos);
  CHECK(plain.second.steps % 7 != 0);
  CHECK(blocked.first == plain.first);
  CHECK(are_same(blocked.second, plain.second));
}

TEST_CASE("A run looks at bodies after each step and at the fluid when it is due, in a block or not") {
  const auto seen = [](fluid::Blocking blocking) {
    scene::Scene scene = disordered({0.7, false, false}, {5.0, 10.0, 15.0});
    scene.fluid->grid.size = {12, 40, 40};
    scene.fluid->blocking = blocking;
    scene::Simulation simulation(scene);
    Progress progress("");
    std::vector<Positions> places;
    std::vector<Vec3> momenta;
    const observe::Observer body{
        {1.0}, [&](const scene::Simulation& now) { places.push_back(now.body().positions()); }, true};
    const observe::Observer fluid{
        {7.5}, [&](const scene::Simulation& now) { momenta.push_back(now.fluid().totals().momentum); }};
    observe::Run run(simulation, {.every = 10}, {body, fluid}, "", progress);
    run.advance(13, 50);
    run.advance(37, 50);
    run.finish();
    CHECK((simulation.seconds().near.wall > 0.0) == (blocking.steps > 1));
    return std::pair(places, momenta);
  };
  const auto plain = seen({1, 8});
  CHECK(plain.first.size() == 51);
  CHECK(plain.second.size() == 8);
  CHECK(seen({6, 8}) == plain);
}

TEST_CASE("A stop in the midst of a block of bodies and fluid is seen") {
  scene::Scene scene = disordered({0.7, false, false}, {5.0, 10.0, 15.0});
  scene.fluid->grid.size = {12, 40, 40};
  scene.fluid->blocking = fluid::Blocking{8, 8};
  scene::Simulation simulation(scene);
  simulation.advance(3);
  stop::signal = SIGTERM;
  CHECK_THROWS_AS(simulation.advance(20), Stopped);
  stop::signal = 0;
  stop::forget();
}

TEST_CASE("Rows go ahead where they are few, and a scene says how many steps it makes at once") {
  scene::Scene scene = disordered({0.7, false, false}, {5.0, 10.0, 15.0});
  scene.fluid->grid.size = {12, 64, 64};
  scene.fluid->blocking = fluid::Blocking{4, 8};
  const auto seen = [](const scene::Scene& of) {
    scene::Simulation simulation(of);
    simulation.advance(8);
    return std::pair(simulation.steps_at_once(), simulation.seconds().near.wall > 0.0);
  };
  CHECK(seen(scene) == std::pair<std::int64_t, bool>(4, true));

  scene::Scene other = scene;
  other.fluid->grid.size = {12, 12, 14};  // all rows are near the body
  CHECK(seen(other) == std::pair<std::int64_t, bool>(4, false));
  other = scene;
  other.uniform_force = [](std::int64_t) { return Vec3(1e-4, 0.0, 0.0); };
  CHECK(seen(other) == std::pair<std::int64_t, bool>(1, false));
  other = scene;
  other.fluid->relaxation_time = 1.0;  // of moments
  CHECK(seen(other) == std::pair<std::int64_t, bool>(1, false));
}
