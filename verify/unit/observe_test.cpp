// What is observed of a fluid, and the watch over it.
#include "base/error.hpp"
#include "catch.hpp"
#include "fluid/obstacle.hpp"
#include "observe/field.hpp"
#include "observe/watch.hpp"
#include "unit/command.hpp"

using namespace veriflex;
using observe::Watch;

namespace {

std::unique_ptr<fluid::Fluid> small_box() {
  return fluid::make_fluid({.grid = {{4, 3, 2}}, .relaxation_time = 0.8});
}

/// At rest but for one node.
std::unique_ptr<fluid::Fluid> with_one(std::int64_t node, double rho, const Vec3& u) {
  std::unique_ptr<fluid::Fluid> fluid = small_box();
  fluid->start([&](std::int64_t at) {
    return at == node ? fluid::equilibrium(rho, u) : fluid::equilibrium(1.0, Vec3::Zero());
  });
  return fluid;
}

std::string complaint(const fluid::Fluid& fluid, const Watch& watch = {}) {
  try {
    observe::check(fluid, watch);
  } catch (const NumericalFailure& failure) {
    return failure.what();
  }
  return "none";
}

std::vector<std::string> names(const observe::Record& record) {
  std::vector<std::string> all;
  for (const observe::Column& column : record.columns) all.push_back(column.name);
  return all;
}

}  // namespace

TEST_CASE("The watch says nothing of a healthy fluid") {
  CHECK(complaint(*small_box()) == "none");
  CHECK(complaint(*with_one(5, 1.2, {0.17, 0.0, 0.0})) == "none");  // Mach 0.294
}

TEST_CASE("The watch names step, node, quantity, value and bound") {
  // Node 13 of 4 x 3 x 2 is (1, 0, 1).
  CHECK(complaint(*with_one(13, 1.0, {0.0, 0.0, 0.2})) ==
        "step 0, node (1, 0, 1): the Mach number is 0.34641, the limit is 0.3 (watch.mach_limit)");
  CHECK(complaint(*with_one(13, -0.25, Vec3::Zero())) ==
        "step 0, node (1, 0, 1): the density is -0.25, it must stay above 0");
  CHECK(complaint(*with_one(13, NAN, Vec3::Zero())) ==
        "step 0, node (1, 0, 1): the velocity is nan, not a finite number");
  CHECK(complaint(*with_one(13, 1.0, {0.0, 0.0, 0.2}), {.every = 1, .mach_limit = 0.4}) == "none");
}

TEST_CASE("The watch looks when it is due") {
  const std::unique_ptr<fluid::Fluid> fast =
      fluid::make_fluid({.grid = {{4, 4, 4}}, .relaxation_time = 0.8, .body_force = {0.1, 0.0, 0.0}});
  const Watch watch{.every = 10, .mach_limit = 0.3};
  for (int step = 0; step < 9; ++step) {
    fast->collide_and_stream();
    CHECK_NOTHROW(observe::check_when_due(*fast, watch));
  }
  fast->collide_and_stream();
  CHECK_THROWS_WITH(observe::check_when_due(*fast, watch), ContainsSubstring("step 10, node (0, 0, 0)"));
}

TEST_CASE("Lines and planes are the nodes of the grid that they say") {
  const Grid grid{{4, 3, 2}};
  CHECK(observe::line(grid, 0, {9, 2, 1}) == std::vector<std::int64_t>{20, 21, 22, 23});
  CHECK(observe::line(grid, 2, {1, 2, 0}) == std::vector<std::int64_t>{9, 21});
  CHECK(observe::plane(grid, 2, 1).front() == 12);
  CHECK(observe::plane(grid, 2, 1).size() == 12);
  CHECK(observe::plane(grid, 0, 3) == std::vector<std::int64_t>{3, 7, 11, 15, 19, 23});
}

TEST_CASE("A record of the fluid has the columns that were asked for, and the fluid's values") {
  const std::unique_ptr<fluid::Fluid> fluid = with_one(13, 1.5, {0.01, 0.02, -0.03});
  const std::vector<std::int64_t> nodes{0, 13};
  const observe::Record all = observe::at_nodes(
      *fluid, nodes, {.density = true, .velocity = true, .stress = true}, "state", "all there is");
  CHECK(names(all) == std::vector<std::string>{"x", "y", "z", "density", "velocity_x", "velocity_y",
                                               "velocity_z", "stress_xx", "stress_yy", "stress_zz",
                                               "stress_xy", "stress_xz", "stress_yz"});
  CHECK(all.find("x")->values == std::vector<double>{0.0, 1.0});
  CHECK(all.find("z")->values == std::vector<double>{0.0, 1.0});
  CHECK(all.find("density")->values[1] == Approx(1.5));
  CHECK(all.find("velocity_z")->values[1] == Approx(-0.03));
  CHECK(std::abs(all.find("stress_xy")->values[1]) < 1e-15);  // started in equilibrium
  CHECK(names(observe::at_nodes(*fluid, nodes, {.density = true}, "state", "")) ==
        std::vector<std::string>{"x", "y", "z", "density"});
}

TEST_CASE("Voxels are the nodes inside, across the edges of the periodic box too") {
  const Grid grid{{8, 8, 8}};
  CHECK(fluid::voxels(grid, fluid::Sphere{{3.0, 3.0, 3.0}, 1.1}).size() == 7);
  const std::vector<std::int64_t> corner = fluid::voxels(grid, fluid::Sphere{{0.0, 0.0, 0.0}, 1.1});
  CHECK(corner.size() == 7);
  CHECK(std::find(corner.begin(), corner.end(), grid.index(7, 0, 0)) != corner.end());
  CHECK(fluid::voxels(grid, fluid::Sphere{{3.5, 3.5, 3.5}, 0.8}).empty());
  for (const std::size_t axis : {0U, 1U, 2U}) {
    const std::vector<std::int64_t> inside = fluid::voxels(grid, fluid::Cylinder{{3.0, 3.0, 3.0}, 1.1, axis});
    CHECK(inside.size() == 5 * 8);
    CHECK(std::find(inside.begin(), inside.end(), observe::line(grid, axis, {3, 3, 3})[7]) != inside.end());
  }
}

namespace {

/// A shipped case with some values replaced, through the command.
unit::Ran run_case(const std::string& id, std::vector<std::string> overrides) {
  const unit::Folder folder;
  std::vector<std::string> words{"run", VERIFLEX_SOURCE_DIR "/cases/" + id + ".toml", "--out", "out"};
  for (const std::string& one : overrides) words.insert(words.end(), {"--set", one});
  return folder.run(words);
}

}  // namespace

TEST_CASE("A flow that breaks ends the run with step and place") {
  const unit::Ran unstable =
      run_case("conservation-periodic", {"fluid.relaxation_time=0.5001", "conservation.velocity=0.2",
                                         "watch={ every = 1, mach_limit = 10.0 }"});
  INFO(unstable.err);
  CHECK(unstable.code == 3);
  CHECK_THAT(unstable.err, ContainsSubstring("conservation-periodic.toml: step "));
  CHECK_THAT(unstable.err, ContainsSubstring(", node ("));
  CHECK_THAT(unstable.err, ContainsSubstring(", it must stay above 0"));

  const unit::Ran fast = run_case("conservation-periodic", {"conservation.velocity=0.15"});
  INFO(fast.err);
  CHECK(fast.code == 3);
  CHECK_THAT(fast.err, ContainsSubstring("the limit is 0.3 (watch.mach_limit)"));
}

TEST_CASE("A flow that does not become steady names what still changes") {
  const unit::Ran ran = run_case("channel-couette", {"channel.step_limit=200"});
  INFO(ran.err);
  CHECK(ran.code == 3);
  CHECK_THAT(ran.err, ContainsSubstring("step 200: the velocity still changes by "));
  CHECK_THAT(ran.err, ContainsSubstring("steady means at most 1e-15"));
}

TEST_CASE("What a fluid case may get wrong is refused with its place") {
  const std::vector<std::tuple<std::string, std::string, std::string>> bad{
      {"channel-poiseuille", "fluid.relaxation_time=0.5", "'relaxation_time' is 0.5"},
      {"channel-poiseuille", "channel.relaxation_times=[1.0, 0.5]", "one that is not more than 0.5"},
      {"channel-poiseuille", "channel.storages=[\"half\"]", "'storages' holds 'half'"},
      {"channel-poiseuille", "channel.resolutions=[8]", "an order needs two"},
      {"channel-poiseuille", "channel.resolutions=[16, 8]", "they do not rise"},
      {"channel-poiseuille", "channel.velocity=0.0", "'velocity' is 0"},
      {"channel-poiseuille", "fluid.body_force=[1.0, 0.0, 0.0]", "'body_force' is set"},
      {"channel-poiseuille", "channel.steady_change=0.0", "round-off never comes to rest"},
      {"channel-womersley", "channel.period=97", "not a multiple of 8"},
      {"channel-duct", "channel.flow=\"pipe\"", "unknown flow 'pipe'"},
      {"array-spheres", "channel.resolutions=[8, 12]", "no multiples of the cell's nodes"},
      {"array-spheres", "fluid.nodes=[8, 8, 16]", "not a cube"},
      {"array-spheres", "fluid.body_force=[1e-5, 1e-5, 0.0]", "oblique"},
      {"array-spheres", "fluid.obstacle.radius=3.5", "the solid fraction is 0.3508"},
      {"array-spheres", "fluid.obstacle.radius=0.1", "the obstacle covers no nodes"},
      {"array-spheres", "fluid.obstacle.radius=-1.0", "'radius' is -1"},
      {"array-spheres", "fluid.obstacle.shape=\"cube\"", "unknown shape 'cube'"},
      {"array-spheres", "fluid.nodes=[1000000, 1000000, 1000000]", "does not fit into memory"},
      {"array-spheres", "channel.resolutions=[8, 4096]", "does not fit into memory"},
      {"conservation-periodic", "fluid.nodes=[100000, 100000, 1000]", "does not fit into memory"},
      {"conservation-periodic", "fluid.nodes=[15, 12, 8]", "a checkerboard does not fit"},
      {"conservation-periodic", "fluid.storage=\"float\"", "'storage' is set"},
      {"conservation-closed", "watch.every=0", "'every' is 0"},
      {"conservation-closed", "watch.mach_limit=-1.0", "'mach_limit' is -1"},
  };
  for (const auto& [id, value, message] : bad) {
    const unit::Ran ran = run_case(id, {value});
    INFO(id << " " << value << ": " << ran.err);
    CHECK(ran.code == 2);
    CHECK_THAT(ran.err, ContainsSubstring(message));
  }
}

TEST_CASE("A box beyond the memory is refused by plan, validate and run alike") {
  const unit::Folder folder;
  const std::string good = unit::contents(VERIFLEX_SOURCE_DIR "/cases/conservation-periodic.toml");
  folder.write("conservation-periodic.toml", unit::replaced(good, "[16, 12, 8]", "[100000, 100000, 1000]"));
  for (const char* command : {"plan", "validate", "run"}) {
    const unit::Ran ran = folder.run({command, "conservation-periodic.toml"});
    INFO(command << ": " << ran.err);
    CHECK(ran.code == 2);
    CHECK_THAT(ran.err,
               ContainsSubstring("conservation-periodic.toml:12:9: a box of 100000 x 100000 x 1000 nodes "
                                 "does not fit into memory (its populations take 1.2e+06 GB, "));
    CHECK_THAT(ran.err, ContainsSubstring("storage = \"float\""));
  }
}
