// What is observed of a fluid, and the monitor over it.
#include <map>
#include <numbers>

#include "base/error.hpp"
#include "catch.hpp"
#include "fluid/initial.hpp"
#include "fluid/obstacle.hpp"
#include "io/file.hpp"
#include "io/hdf5.hpp"
#include "io/vtk.hpp"
#include "observe/check.hpp"
#include "observe/field.hpp"
#include "observe/interrupted.hpp"
#include "observe/run.hpp"
#include "repository.hpp"
#include "unit/command.hpp"

using namespace veriflex;
using observe::MonitorSpec;

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

std::string complaint(const fluid::Fluid& fluid, const MonitorSpec& monitor = {}) {
  try {
    observe::check(fluid, monitor);
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

TEST_CASE("The monitor says nothing of a healthy fluid") {
  CHECK(complaint(*small_box()) == "none");
  CHECK(complaint(*with_one(5, 1.2, {0.17, 0.0, 0.0})) == "none");  // Mach 0.294
}

TEST_CASE("The monitor names step, node, quantity, value and bound") {
  // Node 13 of 4 x 3 x 2 is (1, 0, 1).
  CHECK(complaint(*with_one(13, 1.0, {0.0, 0.0, 0.2})) ==
        "step 0, node (1, 0, 1): the Mach number is 0.34641, the limit is 0.3 (monitor.mach_limit)");
  CHECK(complaint(*with_one(13, -0.25, Vec3::Zero())) ==
        "step 0, node (1, 0, 1): the density is -0.25, it must stay above 0");
  CHECK(complaint(*with_one(13, NAN, Vec3::Zero())) ==
        "step 0, node (1, 0, 1): the velocity is nan, not a finite number");
  CHECK(complaint(*with_one(13, 1.0, {0.0, 0.0, 0.2}), {.every = 1, .mach_limit = 0.4}) == "none");
}

namespace {

/// At rest, under a force that soon makes it too fast.
scene::Simulation accelerated() {
  return scene::Simulation(
      {.fluid = fluid::Spec{.grid = {{4, 4, 4}}, .relaxation_time = 0.8, .body_force = {0.1, 0.0, 0.0}}});
}

}  // namespace

TEST_CASE("A run checks its fluid when that is due") {
  scene::Simulation fast = accelerated();
  Progress progress("test");
  observe::Run run(fast, {.every = 10, .mach_limit = 0.3}, {}, "", progress);
  CHECK_NOTHROW(run.advance(9, 10));
  CHECK_THROWS_WITH(run.advance(1, 10), ContainsSubstring("step 10, node (0, 0, 0)"));
}

TEST_CASE("A run checks its fluid before the first step, after the last, and keeps what it saw last") {
  const MonitorSpec rarely{.every = 1000, .mach_limit = 0.3};
  Progress progress("test");
  scene::Simulation broken({.fluid = fluid::Spec{.grid = {{4, 3, 2}}, .relaxation_time = 0.8},
                            .initial_flow = [](std::int64_t node) {
                              return fluid::equilibrium(node == 13 ? NAN : 1.0, Vec3::Zero());
                            }});
  CHECK_THROWS_AS(observe::Run(broken, rarely, {}, "", progress), NumericalFailure);
  scene::Simulation fast = accelerated();
  observe::Run run(fast, rarely, {}, "", progress);
  CHECK_NOTHROW(run.advance(5, 5));
  try {
    run.finish();
    FAIL("it saw nothing");
  } catch (const observe::Interrupted& failure) {
    CHECK_THAT(failure.what(), ContainsSubstring("step 5"));
    REQUIRE(failure.seen.metric("last_good_step") != nullptr);
    CHECK(failure.seen.metric("last_good_step")->value == 0.0);
  }
}

TEST_CASE("An observer is due at the steps nearest to the multiples of its interval") {
  const auto steps = [](double interval) {
    std::vector<std::int64_t> due;
    for (std::int64_t step = 0; step <= 12; ++step) {
      if (observe::Due{interval}.at(step)) due.push_back(step);
    }
    return due;
  };
  CHECK(steps(1.0).size() == 13);
  CHECK(steps(4.0) == std::vector<std::int64_t>{0, 4, 8, 12});
  CHECK(steps(2.4) == std::vector<std::int64_t>{0, 2, 5, 7, 10, 12});  // 2.4, 4.8, 7.2, 9.6, 12
  CHECK(steps(INFINITY).empty());
}

TEST_CASE("A metric is set once, and only if it was declared") {
  observe::Observations seen;
  seen.declared = {{"length", {}, "L", "of a rod"}};
  seen.records = {{"line", "", {{"x", "", "L", "", {}}}}};
  seen.set("length", 2.0);
  REQUIRE(seen.metric("length") != nullptr);
  CHECK(seen.metric("length")->value == 2.0);
  CHECK(seen.metric("length")->meaning == "of a rod");
  CHECK_THROWS_AS(seen.set("length", 3.0), std::logic_error);
  CHECK_THROWS_AS(seen.set("width", 3.0), std::logic_error);
  seen.open("line").append({1.0});
  CHECK(seen.record("line")->columns[0].values == std::vector<double>{1.0});
  CHECK_THROWS_AS(seen.open("plane"), std::logic_error);
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

TEST_CASE(
    "The stress of a sheared fluid is its viscosity times the rate of strain, each component in its column") {
  Mat3 gradient;  // d u_i/d x_j, without divergence
  gradient << 1e-3, 2e-3, -3e-3, 4e-3, -5e-3, 6e-3, 7e-3, -8e-3, 4e-3;
  const std::unique_ptr<fluid::Fluid> fluid = small_box();
  fluid->start([&](std::int64_t) { return fluid::near_equilibrium(1.0, Vec3::Zero(), gradient, 0.8); });
  const observe::Record record =
      observe::at_nodes(*fluid, std::vector<std::int64_t>{13}, {.stress = true}, "state", "");
  const Mat3 exact = fluid::viscosity(0.8) * (gradient + gradient.transpose());
  const auto column = [&](const std::string& axes) { return record.find("stress_" + axes)->values[0]; };
  CHECK(column("xx") == Approx(exact(0, 0)));
  CHECK(column("yy") == Approx(exact(1, 1)));
  CHECK(column("zz") == Approx(exact(2, 2)));
  CHECK(column("xy") == Approx(exact(0, 1)));
  CHECK(column("xz") == Approx(exact(0, 2)));
  CHECK(column("yz") == Approx(exact(1, 2)));
}

TEST_CASE("An obstacle has no image across a wall, and none of it stands beyond one") {
  const Grid grid{{16, 12, 9}};
  const std::array<bool, 3> closed{true, false, false};
  const std::vector<std::int64_t> half = fluid::voxels(grid, fluid::Sphere{{0.0, 6.0, 4.0}, 2.5}, closed);
  CHECK(half.size() == 51);  // of a ball of 81 nodes the middle layer of 21 and one side of 30
  for (const std::int64_t node : half) CHECK(grid.node(node)[0] <= 2);
  CHECK(fluid::voxels(grid, fluid::Sphere{{0.0, 0.0, 4.0}, 2.5}, closed).size() == 51);  // y is periodic
  CHECK(fluid::voxels(grid, fluid::Sphere{{-3.0, 6.0, 4.0}, 2.5}, closed).empty());
  CHECK(fluid::voxels(grid, fluid::Sphere{{19.0, 6.0, 4.0}, 2.5}, closed).empty());
}

TEST_CASE("A grid for VTK says how many cells it has, where each ends and of which kind each is") {
  const io::VtkGrid lines{.time = 0.5,
                          .points = {0, 0, 0, 1, 0, 0, 1, 1, 0},
                          .cell = io::VtkCell::line,
                          .corners = {0, 1, 1, 2},
                          .on_points = {},
                          .on_cells = {}};
  const std::string text = io::vtk_xml(lines);
  CHECK_THAT(text, ContainsSubstring("NumberOfPoints=\"3\" NumberOfCells=\"2\""));
  // Behind the XML: so many bytes, and these, of each array.
  std::string data;
  const auto add = [&](const auto& values) {
    const std::uint64_t bytes = values.size() * sizeof values[0];
    data.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    data.append(reinterpret_cast<const char*>(values.data()), bytes);
  };
  add(lines.points);
  add(lines.corners);
  add(std::vector<std::int64_t>{2, 4});
  add(std::vector<std::uint8_t>{3, 3});
  CHECK_THAT(text, ContainsSubstring("<AppendedData encoding=\"raw\">\n_" + data + "\n</AppendedData>"));
}

TEST_CASE("Voxels are the nodes inside, across the edges of the periodic box too") {
  const Grid grid{{8, 8, 8}};
  const std::array<bool, 3> open{};
  CHECK(fluid::voxels(grid, fluid::Sphere{{3.0, 3.0, 3.0}, 1.1}, open).size() == 7);
  const std::vector<std::int64_t> corner = fluid::voxels(grid, fluid::Sphere{{0.0, 0.0, 0.0}, 1.1}, open);
  CHECK(corner.size() == 7);
  CHECK(std::find(corner.begin(), corner.end(), grid.index(7, 0, 0)) != corner.end());
  CHECK(fluid::voxels(grid, fluid::Sphere{{3.5, 3.5, 3.5}, 0.8}, open).empty());
  for (const std::size_t axis : {0U, 1U, 2U}) {
    const std::vector<std::int64_t> inside =
        fluid::voxels(grid, fluid::Cylinder{{3.0, 3.0, 3.0}, 1.1, axis}, open);
    CHECK(inside.size() == 5 * 8);
    CHECK(std::find(inside.begin(), inside.end(), observe::line(grid, axis, {3, 3, 3})[7]) != inside.end());
  }
}

namespace {

/// A shipped case with some values replaced, through the command.
unit::Ran run_case(const std::string& id, std::vector<std::string> overrides) {
  const unit::Folder folder;
  std::vector<std::string> words{"run", repository::cases() / (id + ".toml"), "--out", "out"};
  for (const std::string& one : overrides) words.insert(words.end(), {"--set", one});
  return folder.run(words);
}

/// One run of a case that is a sweep, unjudged.
unit::Ran one_run(const std::string& id, std::vector<std::string> overrides) {
  overrides.insert(overrides.end(), {"sweep=", "check="});
  return run_case(id, overrides);
}

}  // namespace

TEST_CASE("A flow that breaks ends the run with step and place") {
  const unit::Ran unstable =
      one_run("conservation-periodic", {"fluid.relaxation_time=0.5001", "conservation.velocity=0.2",
                                        "monitor={ every = 1, mach_limit = 10.0 }"});
  INFO(unstable.err);
  CHECK(unstable.code == 3);
  CHECK_THAT(unstable.err, ContainsSubstring("conservation-periodic.toml: step "));
  CHECK_THAT(unstable.err, ContainsSubstring(", node ("));
  CHECK_THAT(unstable.err, ContainsSubstring(", it must stay above 0"));

  const unit::Ran fast =
      one_run("conservation-periodic", {"conservation.velocity=0.15", "monitor={ every = 1 }"});
  INFO(fast.err);
  CHECK(fast.code == 3);
  CHECK_THAT(fast.err, ContainsSubstring("the limit is 0.3 (monitor.mach_limit)"));
}

TEST_CASE("Two shear layers start as they are defined, along either axis of the plane") {
  const unit::Folder folder;
  constexpr double U = 0.04, k = 20.0, d = 0.05;
  const auto probed = [&](const std::string& velocity, const std::string& along) {
    folder.write("layers.toml", unit::case_head("layers") + R"([fluid]
nodes = [16, 16, 1]
relaxation_time = 0.6
initial = { flow = "double-shear-layer", velocity = )" +
                                    velocity + ", along = \"" + along + R"(", steepness = 20.0 }
[[observe]]
what = "probe"
every = 1
point = [{ node = [2, 5, 0] }, { node = [5, 13, 0] }]
[run]
steps = 1
)");
    CHECK(folder.run({"run", "layers.toml"}).code == 0);
    const io::Hdf5File file(folder.path() / "results/layers.h5");
    std::map<std::string, double> values;  // at the start
    for (const std::string name : {"velocity_x_0", "velocity_x_1", "velocity_y_0"})
      values[name] = file.numbers("/records/probe/" + name).front();
    return values;
  };
  const auto across = [&](double part) { return d * U * std::sin(2.0 * std::numbers::pi * (part + 0.25)); };
  const auto x = probed("[0.04, 0.0, 0.0]", "y");
  CHECK(x.at("velocity_x_0") == Approx(U * std::tanh(k * (5.0 / 16.0 - 0.25))).epsilon(1e-12));
  CHECK(x.at("velocity_x_1") == Approx(U * std::tanh(k * (0.75 - 13.0 / 16.0))).epsilon(1e-12));
  CHECK(x.at("velocity_y_0") == Approx(across(2.0 / 16.0)).epsilon(1e-12));
  const auto y = probed("[0.0, -0.04, 0.0]", "x");
  CHECK(y.at("velocity_y_0") == Approx(-U * std::tanh(k * (2.0 / 16.0 - 0.25))).epsilon(1e-12));
  CHECK(y.at("velocity_x_1") == Approx(across(13.0 / 16.0)).epsilon(1e-12));

  const auto refused = [&](const std::string& change) {
    return folder.run({"run", "layers.toml", "--set", change}).err;
  };
  CHECK_THAT(refused("fluid.initial.velocity=[0.0,0.04,0.04]"),
             ContainsSubstring("along no axis, or several"));
  CHECK_THAT(refused("fluid.initial.velocity=[0.04,0.0,0.0]"), ContainsSubstring("along its own normal"));
  CHECK_THAT(refused("fluid.initial.steepness=0.0"), ContainsSubstring("'steepness' is 0"));
}

TEST_CASE("Probes with weights make one number of each field, their weighted sum") {
  const unit::Folder folder;
  const std::string scene = unit::case_head("probes") + R"([fluid]
nodes = [16, 8, 1]
relaxation_time = 0.8
initial = { flow = "shear-wave", velocity = [0.0, 0.04, 0.0], along = "x" }
[run]
steps = 10
[[observe]]
what = "probe"
name = "each"
every = 5
point = [{ node = [2, 5, 0] }, { node = [5, 1, 0] }, { node = [9, 7, 0] }]
[[observe]]
what = "probe"
name = "all"
every = 5
)";
  folder.write(
      "probes.toml",
      scene +
          R"(point = [{ node = [2, 5, 0], weight = 1.5 }, { node = [5, 1, 0], weight = -0.5 }, { node = [9, 7, 0], weight = -1.0 }]
)");
  const unit::Ran ran = folder.run({"run", "probes.toml"});
  INFO(ran.err);
  CHECK(ran.code == 0);
  CHECK_THAT(ran.out, ContainsSubstring("all.velocity_y"));
  const io::Hdf5File file(folder.path() / "results/probes.h5");
  const auto values = [&](const std::string& name) { return file.numbers("/records/" + name); };
  for (const std::string field : {"density", "velocity_y"}) {
    const std::vector<double> sum = values("all/" + field);
    REQUIRE(sum.size() == 3);
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const double expected = 1.5 * values("each/" + field + "_0")[i] -
                              0.5 * values("each/" + field + "_1")[i] - values("each/" + field + "_2")[i];
      CHECK(sum[i] == Approx(expected).margin(1e-15));
    }
  }
  CHECK(std::abs(values("all/velocity_y")[0]) > 0.01);

  for (const std::string points : {"{ node = [2, 5, 0], weight = 1.5 }, { node = [5, 1, 0] }",
                                   "{ node = [2, 5, 0] }, { node = [5, 1, 0], weight = 1.5 }"}) {
    folder.write("probes.toml", scene + "point = [" + points + "]\n");
    CHECK_THAT(folder.run({"run", "probes.toml"}).err,
               ContainsSubstring("some points have a weight and some have none"));
  }
}

TEST_CASE("A flow that does not become steady names what still changes") {
  const unit::Ran ran = run_case("array-cylinders", {"channel.step_limit=1500"});
  INFO(ran.err);
  CHECK(ran.code == 3);
  CHECK_THAT(ran.err, ContainsSubstring("step 1500: the velocity still changes by "));
  CHECK_THAT(ran.err, ContainsSubstring("steady means at most 1e-09"));
}

TEST_CASE("What a fluid case may get wrong is refused with its place") {
  const std::vector<std::tuple<std::string, std::string, std::string>> bad{
      {"channel-poiseuille", "fluid.relaxation_time=0.5", "'relaxation_time' is 0.5"},
      {"channel-poiseuille", "channel.relaxation_times=[1.0, 0.6]", "is now an axis of a sweep"},
      {"channel-poiseuille", "fluid.storage=\"half\"", "unknown storage 'half'"},
      {"channel-poiseuille", "channel.nodes=[8, 16]", "'nodes' is an array"},
      {"channel-poiseuille", "channel.velocity=0.0", "'velocity' is 0"},
      {"channel-poiseuille", "fluid.body_force=[1.0, 0.0, 0.0]", "'body_force' is set"},
      {"channel-poiseuille", "channel.steady_change=0.0", "never comes to rest"},
      {"channel-couette", "channel.steady_change=1e-18", "never comes to rest"},
      {"channel-couette", "channel.step_limit=1000", "to become steady"},
      {"channel-poiseuille", "fluid.relaxation_time=0.50000001", "to become steady"},
      {"channel-poiseuille", "fluid.relaxation_time=1e8", "to become steady"},
      {"channel-couette", "channel.velocity=1e-308", "squares are lost to underflow"},
      {"channel-womersley", "channel.period=1000000000", "steps"},
      {"vortex-planes", "vortex.decays=1e6", "nothing is left of the flow but rounding"},
      {"vortex-planes", "vortex.reynolds=1e-308", "is lost to underflow"},
      {"vortex-planes", "fluid.relaxation_time=0.5000000000000001", "a run would take"},
      {"galilean-taylor-green", "fluid.relaxation_time=0.5000000000000001", "a run would take"},
      {"channel-womersley", "channel.period=97", "Use a multiple of 8"},
      {"channel-duct", "channel.flow=\"pipe\"", "unknown flow 'pipe'"},
      {"array-spheres", "channel.nodes=12", "multiple"},
      {"array-spheres", "fluid.nodes=[8, 8, 16]", "not a cube"},
      {"array-spheres", "fluid.body_force=[1e-5, 1e-5, 0.0]", "oblique"},
      {"array-spheres", "fluid.obstacle.radius=4.0", "touches its own images"},
      {"array-spheres", "fluid.obstacle.radius=3.0", "has no 'offset'"},
      {"array-spheres", "fluid.obstacle.radius=0.1", "the obstacle covers no nodes"},
      {"array-spheres", "fluid.obstacle.radius=-1.0", "'radius' is -1"},
      {"array-spheres", "fluid.obstacle.shape=\"cube\"", "unknown shape 'cube'"},
      {"array-spheres", "fluid.nodes=[1000000, 1000000, 1000000]", "does not fit into memory"},
      {"conservation-periodic", "fluid.nodes=[100000, 100000, 1000]", "does not fit into memory"},
      {"conservation-periodic", "fluid.nodes=[15, 12, 8]", "a checkerboard does not fit"},
      {"conservation-closed", "monitor.every=0", "'every' is 0"},
      {"conservation-closed", "monitor.mach_limit=-1.0", "'mach_limit' is -1"},
  };
  for (const auto& [id, value, message] : bad) {
    const unit::Ran ran = run_case(id, {value});
    INFO(id << " " << value << ": " << ran.err);
    CHECK(ran.code == 2);
    CHECK_THAT(ran.err, ContainsSubstring(message));
  }
}

TEST_CASE("A run that is fast at its end only, or shorter than monitor.every, ends with an error") {
  const unit::Ran fast_end =
      one_run("conservation-periodic", {"fluid.nodes=[8, 4, 4]", "fluid.body_force=[2e-3, 0.0, 0.0]",
                                        "conservation.steps=90", "conservation.velocity=0.0",
                                        "conservation.staggered_velocity=0.0", "monitor={ every = 1000 }"});
  INFO(fast_end.err);
  CHECK(fast_end.code == 3);
  CHECK_THAT(fast_end.err, ContainsSubstring("step 90, node (0, 0, 0): the Mach number is 0.31"));

  const unit::Ran short_run =
      one_run("channel-womersley", {"channel.nodes=3", "channel.period=16", "channel.periods=1",
                                    "channel.velocity=3.0", "monitor={ every = 1000000 }"});
  INFO(short_run.err);
  CHECK(short_run.code == 3);
  CHECK_THAT(short_run.err, ContainsSubstring("the Mach number is"));

  const unit::Ran no_number =
      one_run("vortex-planes", {"fluid.relaxation_time=0.5001", "vortex.nodes=8", "vortex.reynolds=1e5",
                                "vortex.decays=0.1", "monitor={ every = 1000000, mach_limit = 100.0 }"});
  INFO(no_number.err);
  CHECK(no_number.code == 3);
  CHECK_THAT(no_number.err, ContainsSubstring("not a finite number"));
}

TEST_CASE("What flows inside of an obstacle ends no run") {
  const unit::Ran ran = run_case(
      "conservation-closed",
      {"fluid.nodes=[12, 12, 4]", "fluid.relaxation_time=0.51", "fluid.body_force=[0.0, 0.0, 1e-4]",
       "fluid.obstacle={ shape = \"cylinder\", axis = \"z\", centre = [5.5, 5.5, 0.0], radius = 5.4 }",
       "conservation.steps=2000", "conservation.velocity=0.0"});
  INFO(ran.err);
  CHECK(ran.code == 0);
}

TEST_CASE("Runs that fail take no row of the others with them, and leave their last good state") {
  // Only the coarsest gap is too fast.
  const unit::Folder folder;
  const unit::Ran ran = folder.run(
      {"run", repository::cases() / "channel-womersley.toml", "--out", "out", "--set",
       "sweep.axes=[{ keys = [\"channel.nodes\", \"channel.velocity\", \"channel.period\"], values = "
       "[[4, 0.25, 96], [8, 0.02, 384], [16, 0.01, 1536]] }]",
       "--set", "check=", "--set", "channel.periods=1", "--set", "monitor={ every = 4, mach_limit = 0.12 }"});
  INFO(ran.err);
  REQUIRE(ran.code == 0);
  std::vector<unit::fs::path> written;  // its name tells of what was set
  for (const auto& entry : unit::fs::recursive_directory_iterator(folder.path() / "out")) {
    if (entry.path().extension() == ".h5") written.push_back(entry.path());
  }
  REQUIRE(written.size() == 4);  // the study and its rows
  int failed = 0;
  for (const unit::fs::path& path : written) {
    const io::Hdf5File file(path);
    if (path.parent_path().filename() == "out") {
      CHECK(file.texts("/records/sweep/outcome") ==
            std::vector<std::string>{"mach", "completed", "completed"});
    } else if (file.attribute("/", "outcome") == "mach") {
      const std::vector<std::string> names = file.texts("/metrics/name");
      CHECK(std::find(names.begin(), names.end(), "last_good_step") != names.end());
      ++failed;
    }
  }
  CHECK(failed == 1);
}

TEST_CASE("Steady states in float end at what float can meet, and less is refused") {
  CHECK(one_run("channel-couette", {"fluid.storage=\"float\"", "channel.nodes=8"}).code == 0);
  const unit::Ran asked =
      run_case("channel-couette", {"fluid.storage=\"float\"", "channel.steady_change=1e-12"});
  CHECK(asked.code == 2);
  CHECK_THAT(asked.err, ContainsSubstring("populations in float"));
}

TEST_CASE("Arrays beyond the internal series run against the target that the case gives") {
  const unit::Folder folder;
  folder.write("dense.toml", unit::case_head("dense", "channel") + R"(
[fluid]
nodes = [8, 8, 8]
relaxation_time = 0.9330127018922193
body_force = [1e-5, 0.0, 0.0]

[fluid.obstacle]
shape = "sphere"
centre = [3.5, 3.5, 3.5]
radius = 2.9773

[channel]
flow = "array"
nodes = 24

[[check]]
kind = "verification"
statement = "the drag is the tabulated one"
metric = "drag"
target = 7.442
target_kind = "published-number"
source = "Zick and Homsy 1982"
tolerance = { relative = 0.1, reason = "the staircase of 24 nodes a cell" }
)");
  const unit::Ran ran = folder.run({"run", "dense.toml", "--out", "out"});
  INFO(ran.out << ran.err);
  CHECK(ran.code == 0);
}

TEST_CASE("The profile of a duct is held against a user's table") {
  const auto verdict_of = [](const std::string& table) {
    const unit::Folder folder;
    folder.write("table.csv", table);
    folder.write("table.toml", unit::replaced(R"(schema = 1
id = "table"
kind = "peer-code"
source = "a user's own"
obtained = "measured"

[data]
file = "table.csv"
sha256 = "SUM"
)",
                                              "SUM", io::sha256(table)));
    folder.write("duct.toml", unit::case_head("duct", "channel") + R"(
[fluid]
relaxation_time = 1.0

[channel]
flow = "duct"
nodes = 8
velocity = 0.02

[[check]]
kind = "verification"
statement = "the profile is that of the table"
curve = { record = "profile", x = "position", y = "middle" }
reference = "table"
tolerance = { relative = 0.06, floor = 1.0, reason = "8 nodes" }
)");
    return folder.run({"run", "duct.toml", "--out", "out"}).code;
  };
  // The series at z = 9/16, over that on the axis.
  CHECK(verdict_of("position,middle\n0.0625,0.2581\n0.4375,0.9736\n") == 0);
  CHECK(verdict_of("position,middle\n0.0625,0.2581\n0.4375,0.85\n") == 1);
}

TEST_CASE("A box beyond the memory is refused by plan, validate and run alike") {
  const unit::Folder folder;
  const std::string good = unit::contents(repository::cases() / "conservation-periodic.toml");
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
