// What has been built says so itself, with its memory; a plan that promises otherwise is found out.

#include <array>
#include <cmath>

#include "base/memory.hpp"
#include "base/parts.hpp"
#include "catch.hpp"
#include "engine/study.hpp"
#include "scene/plan.hpp"
#include "scene/simulation.hpp"
#include "solid/relax.hpp"

using namespace veriflex;
using parts::Kind;

namespace {

parts::Made made(Kind kind) { return parts::made()[static_cast<std::size_t>(kind)]; }

scene::Body rod(std::int64_t sections, bool in_fluid) {
  scene::Body body{.material = {bond::Harmonic{0.26, 1.0}, 0.025},
                   .network = solid::rod_lattice({2.5, sections, 1.0})};
  solid::add_angles(body.network);
  body.place = {20.0, 20.0, 6.0};
  body.name = "rod";
  if (in_fluid) body.coupling.emplace();
  return body;
}

fluid::Spec box(double relaxation_time) { return {{{40, 40, 80}}, relaxation_time}; }

// Builds the scene and makes a step; its parts' memory over that of the plan, and over what was allocated.
struct Ratios {
  double planned, allocated;
  std::vector<std::string> broken;
};
Ratios ratios(const scene::Scene& scene) {
  const scene::Plan plan = scene::plan_scene(scene);
  double planned = 0.0;
  for (const scene::Built& built : plan.built) planned += built.memory_bytes;
  parts::restart();
  scene::Simulation simulation(scene);
  simulation.advance();
  const parts::Peak peak = parts::peak();
  return {peak.bytes / planned, peak.bytes / peak.allocated, scene::broken_promises(plan, parts::made())};
}

bool allocator_tells() {
  const double before = allocated_bytes();
  const std::vector<double> some(100000);
  return allocated_bytes() - before >= 800000.0;
}

}  // namespace

TEST_CASE("Parts are counted while they exist, what several share once") {
  parts::restart();
  const int shared = 0;
  {
    const parts::Built a(Kind::Bonds, 100.0, &shared);
    const parts::Built b(Kind::Bonds, 100.0, &shared);
    parts::Built c(Kind::Angles, 10.0);
    const parts::Built copy = c;
    CHECK(parts::peak().bytes == 120.0);
    c.takes(30.0);
    CHECK(parts::peak().bytes == 140.0);
    parts::Built moved = std::move(c);
    moved = {};
  }
  CHECK(made(Kind::Bonds).count == 2);
  CHECK(made(Kind::Bonds).bytes == 100.0);
  CHECK(made(Kind::Angles).count == 2);
  CHECK(made(Kind::Angles).bytes == 40.0);
  CHECK(parts::peak().bytes == 140.0);
  parts::restart();
  CHECK(made(Kind::Bonds).count == 0);
  CHECK(parts::peak().bytes == 0.0);
}

TEST_CASE("A restart forgets parts of every kind, and keeps those that exist") {
  for (const auto& kind : parts::kinds) {
    INFO(kind.name);
    { const parts::Built gone(kind.value, 50.0); }
    const parts::Built kept(kind.value, 8.0);
    parts::restart();
    CHECK(made(kind.value).count == 1);
    CHECK(made(kind.value).bytes == 8.0);
    CHECK(parts::peak().bytes == 8.0);
  }
}

TEST_CASE("A copy of a part shares what that one shares, and leaves it there at its end") {
  parts::restart();
  const int shared = 0;
  {
    const parts::Built first(Kind::Bonds, 100.0, &shared);
    { const parts::Built copy = first; }
    const parts::Built other(Kind::Angles, 10.0);
    CHECK(parts::peak().bytes == 110.0);
  }
  parts::restart();
  CHECK(parts::peak().bytes == 0.0);
  const parts::Built again(Kind::Bonds, 100.0, &shared);  // counts anew
  CHECK(parts::peak().bytes == 100.0);
}

TEST_CASE(
    "What was allocated is told beside the most that parts took, with those that were there at the start") {
  if (!allocator_tells()) return;
  constexpr std::size_t there = 1'000'000, more = 500'000;
  const auto counted = [](std::size_t size) {
    return parts::Built(Kind::Bonds, 8.0 * static_cast<double>(size));
  };
  const std::vector<double> before(there);
  const parts::Built of_before = counted(there);
  parts::restart();
  const std::vector<double> after(more);
  const parts::Built of_after = counted(more);
  CHECK(parts::peak().allocated == Approx(8.0 * static_cast<double>(there + more)).epsilon(1e-3));
}

TEST_CASE("Parts, their plan and the allocator agree on a scene's memory within 2 %") {
  scene::Scene scene;
  SECTION("a body alone") { scene.bodies = {rod(400, false)}; }
  SECTION("a body that is held and loaded") {
    scene.bodies = {rod(400, false)};
    const Eigen::Index nodes = scene.bodies[0].network.node_count();
    scene.bodies[0].conditions.fixed = solid::FixedDofs::Constant(nodes, 3, false);
    scene.bodies[0].conditions.load = Positions::Zero(nodes, 3);
  }
  SECTION("populations alone") { scene.fluid = box(0.8); }
  SECTION("moments alone") { scene.fluid = box(1.0); }
  SECTION("moments in float between walls") {
    scene.fluid = box(1.0);
    scene.fluid->storage = fluid::Storage::Float;
    scene.fluid->walls[0].emplace();
  }
  SECTION("populations in a gap between walls") {
    scene.fluid = fluid::Spec{{{2, 150, 150}}, 0.8};
    scene.fluid->walls[0].emplace();
  }
  SECTION("populations around an obstacle") {
    scene.fluid = box(0.8);
    for (std::int64_t node = 0; node < 500; ++node) scene.fluid->obstacle.push_back(node);
  }
  SECTION("a body in a fluid") {
    scene.fluid = box(0.8);
    scene.bodies = {rod(60, true)};
  }
  SECTION("two bodies in a fluid") {
    scene.fluid = box(0.8);
    scene.bodies = {rod(60, true), rod(60, true)};
    scene.bodies[1].place[0] = 30.0;
    scene.bodies[1].name = "other";
  }
  const Ratios ratio = ratios(scene);
  CHECK(ratio.broken.empty());
  CHECK(ratio.planned == Approx(1.0).margin(0.02));
  if (allocator_tells()) CHECK(ratio.allocated == Approx(1.0).margin(0.02));
}

TEST_CASE("A plan knows the memory of a coupling before there is one, beside however large a fluid") {
  scene::Scene scene;
  scene.fluid = box(0.8);
  scene.bodies = {rod(60, true)};
  double planned = 0.0;
  for (const scene::Built& built : scene::plan_scene(scene).built) {
    if (built.parts == std::vector{Kind::Coupling}) planned += built.memory_bytes;
  }
  parts::restart();
  scene::Simulation simulation(scene);
  simulation.advance();
  CHECK(planned == Approx(made(Kind::Coupling).bytes).epsilon(0.02));
}

TEST_CASE("A plan knows what an implicit step takes within a tenth, while its Hessian is put together") {
  for (const std::array<std::int64_t, 3>& nodes : {std::array<std::int64_t, 3>{6, 6, 6}, {4, 4, 30}}) {
    scene::Scene scene;
    scene::Body& body = scene.bodies.emplace_back();
    body.material = {bond::Harmonic{0.26, 1.0}, 0.025};
    body.network = solid::cubic_lattice({nodes, 1.0});
    solid::add_angles(body.network);
    body.scheme = solid::Scheme::ImplicitMidpoint;
    body.start.displacement = 1e-3 * body.network.rest;
    CHECK(ratios(scene).planned == Approx(1.0).margin(0.1));
  }
}

TEST_CASE("What a static solution takes is what the allocator has given out for it") {
  if (!allocator_tells()) return;
  solid::Network bar = solid::cubic_lattice({{6, 6, 30}, 1.0});
  solid::add_angles(bar);
  const solid::Material material{bond::Harmonic{0.26, 1.0}, 0.025};
  solid::FixedDofs held = solid::FixedDofs::Constant(bar.node_count(), 3, false);
  held.topRows(36).setConstant(true);
  Positions load = Positions::Zero(bar.node_count(), 3);
  load.bottomRows(36).col(0).setConstant(1e-6);
  const Positions start = Positions::Zero(bar.node_count(), 3);
  const double network = solid::bond_bytes(bar) + solid::angle_bytes(bar);  // there before
  parts::restart();
  solid::equilibrium(material, bar, start, held, load);
  CHECK(made(Kind::Statics).count == 1);
  CHECK((parts::peak().bytes - network) / parts::peak().allocated == Approx(1.0).margin(0.02));
}

TEST_CASE("What damped dynamics takes is counted where it has nothing to do, too") {
  solid::Network pair = solid::cubic_lattice({{1, 1, 2}, 1.0});
  solid::FixedDofs held = solid::FixedDofs::Constant(2, 3, false);
  held.topRows(1).setConstant(true);
  const Positions none = Positions::Zero(2, 3);
  parts::restart();
  const solid::Equilibrium rest = solid::relax({solid::Relaxation::DampedDynamics, 1e-9},
                                               {bond::Harmonic{0.26, 1.0}, 0.0}, pair, none, held, none);
  CHECK(rest.u.isZero(0.0));
  CHECK(made(Kind::LeapFrog).bytes >= parts::array_bytes(none, none));
}

TEST_CASE("A plan that promises what a run does not keep is found out") {
  scene::Scene scene;
  scene.fluid = fluid::Spec{{{4, 4, 4}}, 0.8};
  const scene::Plan plan = scene::plan_scene(scene);
  const auto broken_by = [&](const fluid::Spec& built) {
    parts::restart();
    const auto fluid = fluid::make_fluid(built);
    return scene::broken_promises(plan, parts::made());
  };
  CHECK(broken_by(*scene.fluid).empty());
  fluid::Spec forced = *scene.fluid;
  forced.kept.body_force = true;
  REQUIRE(broken_by(forced).size() == 1);
  CHECK(broken_by(forced)[0] == "body force: there and not planned");
  fluid::Spec moments = *scene.fluid;
  moments.relaxation_time = 1.0;
  CHECK(broken_by(moments).size() == 2);
  parts::restart();
  CHECK(scene::broken_promises(plan, parts::made()).size() == 1);
}

TEST_CASE("A run that builds what its plan leaves out is an error, one of many runs has no plan of its own") {
  engine::Study study{.plan = scene::plan_scene({.fluid = box(0.8)}), .run = {}};
  parts::restart();
  const scene::Simulation planned({.fluid = box(0.8)});
  CHECK_NOTHROW(engine::hold_to_plan(study));
  const scene::Simulation more({.fluid = box(0.8), .bodies = {rod(5, true)}});
  CHECK_THROWS_AS(engine::hold_to_plan(study), std::logic_error);
  study.runs.emplace();
  CHECK_NOTHROW(engine::hold_to_plan(study));
}
