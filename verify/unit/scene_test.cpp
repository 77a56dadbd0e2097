// Scenes of any parts: what is absent, several bodies in one fluid, and states taken out and put back.
#include "scene/simulation.hpp"

#include <algorithm>
#include <cmath>

#include "bond/harmonic.hpp"
#include "catch.hpp"
#include "fluid/obstacle.hpp"
#include "observe/interrupted.hpp"
#include "observe/run.hpp"
#include "scene/contact.hpp"
#include "unit/allocations.hpp"

using namespace veriflex;

namespace {

solid::Network with_angles(solid::Network network) {
  solid::add_angles(network);
  return network;
}

/// A free sphere with weight.
scene::Body sphere(const Vec3& place) {
  scene::Body body{.material = {bond::Harmonic{0.26, 1.0}, 0.025},
                   .network = with_angles(solid::spheroid_lattice({1.5, 1.5, 1.0})),
                   .substeps = {.count = 2},
                   .place = place,
                   .coupling = scene::CouplingSpec{},
                   .name = "sphere"};
  body.conditions.load = Vec3(1e-5, 2e-5, -3e-5).transpose().replicate(body.network.node_count(), 1);
  return body;
}

/// A clamped and driven rod whose sub-steps follow its stiffness.
scene::Body rod(const Vec3& place) {
  scene::Body body{.material = {bond::AnyLaw(bond::Harmonic{0.26, 1.0}), 0.025},
                   .network = with_angles(solid::rod_lattice({1.0, 6, 1.0})),
                   .substeps = {.safety = 0.5},
                   .place = place,
                   .coupling = scene::CouplingSpec{.subcycled = true},
                   .name = "rod"};
  body.conditions.fixed = solid::FixedDofs::Constant(body.network.node_count(), 3, false);
  body.conditions.fixed.topRows(5).setConstant(true);
  body.conditions.drive = solid::Drive{{25, 26}, 0, 0.2, 0.3, 5.0};
  return body;
}

/// The same, stiffer than leap-frog bears without sub-steps, by the implicit midpoint rule.
scene::Body stiff_rod(const Vec3& place) {
  scene::Body body = rod(place);
  body.material = {bond::AnyLaw(bond::Harmonic{26.0, 1.0}), 2.5};
  body.scheme = solid::Scheme::ImplicitMidpoint;
  body.substeps = {};
  return body;
}

scene::Body oscillating(const Vec3& place) {
  return {.material = {bond::Harmonic{0.26, 1.0}, 0.0},
          .network = solid::plate_lattice({{4.0, 2.0}, 0.0, 1.0}),
          .place = place,
          .coupling = scene::CouplingSpec{.forcing_iterations = 2},
          .motion = scene::Motion{.velocity = {0.01, 0.0, 0.0}, .amplitude = {0.0, 0.3, 0.0}, .omega = 0.2},
          .name = "plate"};
}

fluid::Spec box(fluid::Storage storage, bool closed = false) {
  fluid::Spec spec{.grid = {{24, 14, 15}}, .relaxation_time = 0.8, .storage = storage};
  spec.body_force = {1e-6, 0.0, 0.0};
  if (closed) {
    spec.walls[0] = fluid::Walls{};
    spec.walls[1] = fluid::Walls{{1e-3, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    spec.obstacle = fluid::voxels(spec.grid, fluid::Sphere{{20.0, 7.0, 7.0}, 2.2}, fluid::closed(spec));
  }
  return spec;
}

bool same(const scene::State& a, const scene::State& b) {
  if (a.steps != b.steps || a.fluid.has_value() != b.fluid.has_value()) return false;
  if (a.fluid && (a.fluid->steps != b.fluid->steps || a.fluid->populations != b.fluid->populations))
    return false;
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    const auto &p = a.bodies[i], &q = b.bodies[i];
    if (p.steps != q.steps || p.elastic.has_value() != q.elastic.has_value()) return false;
    if (!p.elastic) continue;
    if (p.elastic->displacement != q.elastic->displacement) return false;
    if (p.elastic->velocity != q.elastic->velocity) return false;
  }
  return true;
}

void advance(scene::Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i) simulation.advance();
}

}  // namespace

TEST_CASE("Shapes hold the lattice nodes inside their surface, symmetric about their centre") {
  CHECK(solid::spheroid_lattice({1.0, 1.0, 1.0}).node_count() == 7);
  CHECK(solid::spheroid_lattice({2.5, 2.5, 1.0}).node_count() == 81);
  CHECK(solid::spheroid_lattice({3.0, 3.0, 1.0}).node_count() == 123);
  CHECK(solid::plate_lattice({{4.0, 2.0}, 0.0, 1.0}).node_count() == 15);
  CHECK(solid::plate_lattice({{4.9, 2.0}, 2.0, 0.5}).node_count() == 45);
  for (const solid::Network& network :
       {solid::spheroid_lattice({2.3, 4.1, 1.5}), solid::plate_lattice({{6.0, 3.0}, 2.0, 1.5})}) {
    CHECK(network.rest.colwise().sum().norm() == 0.0);
    const Positions& X = network.rest;
    for (Eigen::Index i = 0; i < X.rows(); ++i) {  // the node opposite to each is there, too
      CHECK((X.rowwise() + X.row(i)).rowwise().norm().minCoeff() == 0.0);
    }
  }
  const solid::Network spheroid = solid::spheroid_lattice({2.3, 4.1, 1.5});
  const Positions X = spheroid.rest / 1.5;
  for (Eigen::Index i = 0; i < X.rows(); ++i) {
    CHECK((X(i, 0) * X(i, 0) + X(i, 1) * X(i, 1)) / (2.3 * 2.3) + X(i, 2) * X(i, 2) / (4.1 * 4.1) <= 1.0);
  }
  CHECK(X.col(2).maxCoeff() == 4.0);
}

TEST_CASE("Forces of several bodies add up where they share a node") {
  coupling::SummedForces sum;
  const std::vector<std::int64_t> a{7, 3, 9}, b{3, 8};
  Positions of_a(3, 3), of_b(2, 3);
  of_a << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  of_b << 10, 20, 30, 40, 50, 60;
  for (int twice = 0; twice < 2; ++twice) {
    sum.clear();
    sum.add(a, of_a);
    sum.add(b, of_b);
    sum.sum();
    CHECK(std::vector<std::int64_t>(sum.nodes().begin(), sum.nodes().end()) ==
          std::vector<std::int64_t>{3, 7, 8, 9});
    Positions expected(4, 3);
    expected << 14, 25, 36, 1, 2, 3, 40, 50, 60, 7, 8, 9;
    REQUIRE(sum.force().rows() == 4);  // one a node: Eigen compares as far as both go
    CHECK(sum.force() == expected);
  }
}

TEST_CASE("A run goes on bit by bit from a state that was taken out and put back") {
  const fluid::Spec wide = box(fluid::Storage::Double);
  const fluid::Spec narrow = box(fluid::Storage::Float);
  const fluid::Spec closed = box(fluid::Storage::Double, true);
  const auto stream = [](std::int64_t node) {
    return fluid::equilibrium(1.0, {1e-3 * std::sin(0.1 * static_cast<double>(node)), 1e-3, 0.0});
  };
  const Vec3 left(6.3, 6.6, 7.1), right(11.2, 6.1, 4.2);
  const std::vector<scene::Scene> scenes{
      {.bodies = {sphere(left)}},
      {.bodies = {rod(left)}},
      {.bodies = {stiff_rod(left)}},
      {.fluid = wide, .initial_flow = stream},
      {.fluid = narrow, .initial_flow = stream},
      {.fluid = closed, .initial_flow = stream},
      {.fluid = wide, .bodies = {sphere(left)}},
      {.fluid = narrow, .bodies = {sphere(left), rod(right)}},
      {.fluid = narrow, .bodies = {sphere(left), stiff_rod(right)}},
      {.fluid = closed, .initial_flow = stream, .bodies = {sphere(left), rod(right)}},
      {.fluid = wide, .bodies = {rod(right), oscillating(left)}},
  };
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    for (const int until : {4, 7}) {  // the fluid's even and odd steps move different data
      INFO("scene " << i << ", state after " << until << " steps");
      scene::Simulation whole(scenes[i]);
      advance(whole, until);
      const scene::State state = whole.state();
      advance(whole, 5);
      scene::Simulation restored(scenes[i]);
      advance(restored, 2);
      restored.restore(state);
      CHECK(same(restored.state(), state));
      advance(restored, 5);
      CHECK(same(restored.state(), whole.state()));
      CHECK_FALSE(same(restored.state(), state));
    }
  }
}

TEST_CASE("The order of two bodies changes nothing, not even where they share nodes") {
  const fluid::Spec spec = box(fluid::Storage::Double);
  const scene::Body a = sphere({7.3, 6.6, 7.1}), b = oscillating({10.6, 6.1, 7.2});
  scene::Simulation first({.fluid = spec, .bodies = {a, b}}), second({.fluid = spec, .bodies = {b, a}});
  advance(first, 21);
  advance(second, 21);
  const scene::State p = first.state(), q = second.state();
  CHECK(p.fluid->populations == q.fluid->populations);
  CHECK(p.bodies[0].elastic->displacement == q.bodies[1].elastic->displacement);
  scene::Simulation alone({.fluid = spec, .bodies = {a}});
  advance(alone, 21);
  CHECK(alone.state().bodies[0].elastic->displacement != p.bodies[0].elastic->displacement);
}

TEST_CASE("Two bodies and their fluid keep their momentum to round-off") {
  fluid::Spec spec = box(fluid::Storage::Double);
  spec.body_force.setZero();
  scene::Body other = sphere({10.5, 6.1, 7.2});
  other.conditions.load *= -1.0;
  scene::Simulation simulation({.fluid = spec, .bodies = {sphere({6.3, 6.6, 7.1}), other}});
  advance(simulation, 200);
  CHECK(simulation.momentum().norm() < 1e-14);
  CHECK(simulation.body(0).momentum().norm() > 1e-6);
}

TEST_CASE("A body in another fluid's scene that meets none moves as it does alone") {
  scene::Body body = sphere({6.3, 6.6, 7.1});
  body.coupling.reset();
  scene::Simulation with({.fluid = box(fluid::Storage::Double), .bodies = {body}});
  scene::Simulation alone({.bodies = {body}});
  advance(with, 20);
  advance(alone, 20);
  CHECK(with.body().displacement() == alone.body().displacement());
  CHECK(with.body().touched_nodes() == 0);
}

TEST_CASE(
    "In a box a node deep a sheet stays in its plane, and where that stands across the box changes nothing") {
  const auto after = [](double z) {
    scene::Body sheet = sphere({4.3, 3.9, z});
    sheet.network = with_angles(solid::cubic_lattice({{3, 2, 1}, 1.0}));
    sheet.conditions.load = Vec3(1e-5, 2e-5, 0.0).transpose().replicate(sheet.network.node_count(), 1);
    scene::Scene scene{.fluid = fluid::Spec{.grid = {{12, 10, 1}}, .relaxation_time = 0.8},
                       .bodies = {sheet}};
    scene.fluid->walls[1].emplace();
    scene::Simulation simulation(scene);
    for (int step = 0; step < 300; ++step) simulation.advance();
    return simulation.body().displacement();
  };
  const Positions in_node = after(0.0), between = after(0.4);
  CHECK(in_node.col(0).minCoeff() > 1e-3);
  CHECK(in_node.col(2).cwiseAbs().maxCoeff() < 1e-15);
  CHECK((in_node - between).cwiseAbs().maxCoeff() < 1e-13);
}

TEST_CASE("A uniform force gives each node its share, beside the reaction of a body") {
  const fluid::Spec fluid = box(fluid::Storage::Double);
  const auto volume = static_cast<double>(fluid.grid.count());
  const auto force = [](std::int64_t step) { return Vec3(1e-6 * static_cast<double>(step), 0.0, 2e-6); };
  for (const bool with_body : {false, true}) {
    scene::Scene scene{.fluid = fluid, .uniform_force = force};
    if (with_body) scene.bodies = {sphere({12.0, 7.0, 7.0})};
    if (with_body) scene.bodies.front().conditions.load.setZero();
    scene::Simulation simulation(std::move(scene));
    for (int step = 0; step < 4; ++step) simulation.advance();
    CHECK((simulation.momentum() - volume * Vec3(10e-6, 0.0, 8e-6)).norm() < 1e-12);
  }
}

TEST_CASE("What a scene does not name costs neither memory nor a call") {
  const auto largest_of = [](const scene::Scene& scene) {
    std::size_t largest = 0;
    for (const std::size_t size : allocations_of([&] {
           scene::Simulation simulation(scene);
           simulation.advance();
         }))
      largest = std::max(largest, size);
    return largest;
  };
  const scene::Body body = sphere({6.3, 6.6, 7.1});
  const std::size_t rows = 14 * 15 * sizeof(std::int32_t);  // a transfer's table of the box's rows
  CHECK(largest_of({.bodies = {sphere({0.0, 0.0, 0.0})}}) < 65536);
  scene::Body alone = body;
  alone.coupling.reset();
  const scene::Scene apart{.fluid = box(fluid::Storage::Double), .bodies = {alone}};
  const auto counts = [&](const scene::Scene& scene) {
    const std::vector<std::size_t> sizes = allocations_of([&] { scene::Simulation simulation(scene); });
    return std::count(sizes.begin(), sizes.end(), rows);
  };
  CHECK(counts(apart) == 0);
  CHECK(counts({.fluid = box(fluid::Storage::Double), .bodies = {body}}) == 1);

  scene::Simulation fluid({.fluid = box(fluid::Storage::Double)});
  advance(fluid, 2);
  CHECK(allocations_of([&] { advance(fluid, 10); }).empty());
  scene::Simulation solid({.bodies = {body}});
  advance(solid, 1);
  CHECK(allocations_of([&] { advance(solid, 10); }).empty());
}

TEST_CASE("A motion that is given needs a fluid") {
  CHECK_THROWS_WITH(scene::Simulation({.bodies = {oscillating({0.0, 0.0, 0.0})}}),
                    ContainsSubstring("it meets no fluid"));
}

TEST_CASE("Bodies that come near are found across the edges of the box and not across walls") {
  const Grid grid{{10, 12, 14}};
  const Positions a = Vec3(0.2, 5.0, 13.8).transpose(), b = Vec3(9.6, 5.0, 14.3).transpose();
  const auto met = scene::nearest_within(1.0, a, b, grid, {false, false, false});
  REQUIRE(met);
  CHECK(met->distance == Approx(std::hypot(0.6, 0.5)));
  CHECK_FALSE(scene::nearest_within(1.0, a, b, grid, {true, false, false}));
  CHECK_FALSE(scene::nearest_within(0.7, a, b, grid, {false, false, false}));
  CHECK_FALSE(scene::nearest_within(1.0, a, Positions::Constant(1, 3, NAN), grid, {true, true, true}));
}

TEST_CASE("A run observes its start, the steps that are due and its end, and warns of a contact once") {
  scene::Body a = sphere({6.0, 7.0, 7.0}), b = sphere({9.5, 7.0, 7.0});
  b.name = "other";
  scene::Simulation simulation({.fluid = box(fluid::Storage::Double), .bodies = {a, b}});
  std::vector<std::int64_t> seen, phases, at_end;
  const auto note = [](std::vector<std::int64_t>& to) {
    return [&to](const scene::Simulation& s) { to.push_back(s.steps()); };
  };
  Progress progress("test");
  observe::Run run(simulation, {.every = 3, .mach_limit = 0.3},
                   {{{4.0}, note(seen)}, {{2.5}, note(phases)}, {{INFINITY}, note(at_end)}}, "", progress);
  run.advance(6, 10);
  run.advance(4, 10);
  run.finish();
  CHECK(seen == std::vector<std::int64_t>{0, 4, 8, 10});
  CHECK(phases == std::vector<std::int64_t>{0, 3, 5, 8, 10});
  CHECK(at_end == std::vector<std::int64_t>{10});
  CHECK(progress.warnings().empty());

  b.place = {7.9, 7.0, 7.0};
  scene::Simulation near({.fluid = box(fluid::Storage::Double), .bodies = {a, b}});
  observe::Run touching(near, {.every = 1, .mach_limit = 0.3}, {}, "", progress);
  touching.advance(3, 3);
  touching.finish();
  REQUIRE(progress.warnings().size() == 1);
  CHECK_THAT(progress.warnings().front(), ContainsSubstring("sphere and other are"));
}

TEST_CASE("A run that breaks off leaves its last good state") {
  scene::Body body = sphere({6.0, 7.0, 7.0});
  body.conditions.load(0, 0) = 5.0;
  for (const bool in_fluid : {false, true}) {
    scene::Scene scene{.bodies = {body}};
    if (in_fluid) scene.fluid = box(fluid::Storage::Double);
    scene::Simulation simulation(scene);
    Progress progress("test");
    observe::Run run(simulation, {.every = 2, .mach_limit = 0.3}, {}, "the sphere", progress);
    try {
      run.advance(1000, 1000);
      run.finish();
      // Without a fluid and with harmonic bonds nothing may break: the state is sound to the end.
      CHECK_FALSE(in_fluid);
    } catch (const observe::Interrupted& interrupted) {
      CHECK_THAT(interrupted.what(), ContainsSubstring("the sphere: "));
      // Pulled by one node: a bond, the fluid or a marker gives way; the class is not lost with the words.
      CHECK(interrupted.mode != FailureMode::Other);
      CHECK(interrupted.seen.metric("last_good_step") != nullptr);
      REQUIRE(interrupted.seen.record("last_good_nodes") != nullptr);
      CHECK(interrupted.seen.record("last_good_nodes")->columns.front().values.size() == 19);
    }
  }
}
