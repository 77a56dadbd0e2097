// What a scene could do without, and what its steps will take.

#include <algorithm>

#include "catch.hpp"
#include "engine/rates.hpp"
#include "scene/coupling_stability.hpp"
#include "scene/offers.hpp"
#include "scene/simulation.hpp"

using namespace veriflex;

namespace {

scene::Scene rod_in_box(int substeps, double node_mass) {
  scene::Body body{.material = {bond::Harmonic{0.26, 1.0}, 0.025},
                   .network = solid::rod_lattice({1.5, 10, 1.0})};
  solid::add_angles(body.network);
  body.conditions.node_mass = node_mass;
  body.substeps.count = substeps;
  body.place = {16.0, 16.0, 8.0};
  body.coupling.emplace();
  body.name = "rod";
  return {.fluid = fluid::Spec{.grid = {{32, 32, 32}}, .relaxation_time = 0.9}, .bodies = {body}};
}

std::vector<std::string> settings_of(const scene::Scene& scene) {
  std::vector<std::string> settings;
  for (const scene::Offer& offer : scene::offers(scene, [](std::size_t) { return "substeps"; })) {
    settings.push_back(offer.setting);
  }
  return settings;
}

bool has(const std::vector<std::string>& all, const std::string& one) {
  return std::find(all.begin(), all.end(), one) != all.end();
}

}  // namespace

TEST_CASE("Offered are float storage, a smaller box where it is periodic, and sub-steps that are stable") {
  scene::Scene scene = rod_in_box(8, 1.2);
  scene.fluid->walls[1].emplace();
  const std::vector<std::string> settings = settings_of(scene);
  CHECK(has(settings, "fluid.storage=float"));
  CHECK(has(settings, "fluid.nodes=[24, 32, 32]"));
  CHECK_FALSE(has(settings, "fluid.nodes=[32, 24, 32]"));
  const auto fewer = std::find_if(settings.begin(), settings.end(),
                                  [](const std::string& s) { return s.starts_with("substeps="); });
  REQUIRE(fewer != settings.end());
  const int count = std::stoi(fewer->substr(9));
  CHECK(count < 8);
  scene.bodies[0].substeps.count = count;
  CHECK_FALSE(scene::coupling_growth(*scene.fluid, scene.bodies[0]).grows());
  scene.fluid->storage = fluid::Storage::Float;
  CHECK_FALSE(has(settings_of(scene), "fluid.storage=float"));
}

TEST_CASE("A body that needs its sub-steps is offered none fewer") {
  scene::Scene scene = rod_in_box(2, 0.05);  // 2/omega_max is below a step
  scene.fluid.reset();
  scene.bodies[0].coupling.reset();
  CHECK(settings_of(scene).empty());
}

TEST_CASE("What a run will take is its work over the rates") {
  engine::Rates rates;
  for (auto& of_representation : rates.nodes) {
    for (auto& of_storage : of_representation) of_storage = {2e6, 1e6};
  }
  rates.bonds = 100.0;
  rates.angles = 50.0;
  rates.markers = {10.0, 20.0};
  rates.checked_nodes = 5.0;
  rates.checked_substeps = 4.0;
  scene::ExpectedWork work{{}, {}, 0.0};
  work.counts.bond_evaluations = 100;
  work.counts.angle_evaluations = 100;
  work.counts.marker_interpolations = 10;
  work.checked_nodes = 5.0;
  work.checked_substeps = 12.0;
  CHECK(engine::seconds_of(work, rates) == Approx(1.0 + 2.0 + 1.0 + 1.0 + 3.0));
  work.fluid = fluid::Spec{.grid = {{200, 200, 200}}, .relaxation_time = 1.0};
  work.counts.node_updates = 8'000'000;
  CHECK(engine::seconds_of(work, rates) == Approx(7.5 + 8.0));  // markers meet moments in half of the time
  work.fluid->grid.size = {10, 10, 10};
  CHECK(engine::seconds_of(work, rates) == Approx(7.5 + 4.0));
  rates.of_box = 8e6;
  CHECK(engine::seconds_of(work, rates) == Approx(7.5 + 1.0));
}

TEST_CASE("Populations make many steps at once beside a body too, but not around an obstacle") {
  engine::Rates rates;
  for (auto& of_representation : rates.nodes) {
    for (auto& of_storage : of_representation) of_storage = {1e6, 1e6};
  }
  rates.at_once = {4e6, 8e6};
  rates.bonds = rates.markers[0] = 1e12;
  scene::ExpectedWork work{.fluid = fluid::Spec{.grid = {{200, 200, 200}}, .relaxation_time = 0.9},
                           .counts = {}};
  work.counts.node_updates = 8'000'000;
  work.counts.bond_evaluations = work.counts.marker_interpolations = 1;
  rates.angles = rates.checked_nodes = rates.checked_substeps = 1.0;
  CHECK(engine::seconds_of(work, rates) == Approx(2.0));
  work.fluid->storage = fluid::Storage::Float;
  CHECK(engine::seconds_of(work, rates) == Approx(1.0));
  work.fluid->obstacle = {7};
  CHECK(engine::seconds_of(work, rates) == Approx(8.0));
}

TEST_CASE("A coupling whose force follows the sub-steps is checked as many times as there are") {
  scene::Scene scene = rod_in_box(3, 1.2);
  scene.bodies[0].coupling->subcycled = false;
  const auto nodes = static_cast<double>(scene.bodies[0].network.node_count());
  CHECK(scene::expected_work(scene, 5)->checked_nodes == nodes);
  CHECK(scene::expected_work(scene, 5)->checked_substeps == 0.0);
  scene.bodies[0].coupling->subcycled = true;
  CHECK(scene::expected_work(scene, 5)->checked_nodes == 0.0);
  CHECK(scene::expected_work(scene, 5)->checked_substeps == 3.0 * nodes);
}

TEST_CASE("A scene's expected work is what its steps do") {
  const scene::Scene scene = rod_in_box(3, 1.2);
  constexpr std::int64_t steps = 5;
  const work::Counts before = work::done();
  scene::Simulation simulation(scene);
  for (std::int64_t step = 0; step < steps; ++step) simulation.advance();
  const work::Counts after = work::done();
  const work::Counts expected = scene::expected_work(scene, steps)->counts;
  CHECK(after.node_updates - before.node_updates == expected.node_updates);
  CHECK(after.bond_evaluations - before.bond_evaluations == expected.bond_evaluations);
  CHECK(after.angle_evaluations - before.angle_evaluations == expected.angle_evaluations);
  CHECK(after.marker_interpolations - before.marker_interpolations == expected.marker_interpolations);
}
