// A body in a fluid: single steps against arithmetic of the test's own, what is seen of a stroke, and scenes
// that are refused because they are not the ones that were meant.
#include <cmath>

#include "base/error.hpp"
#include "bond/harmonic.hpp"
#include "catch.hpp"
#include "measures/filament/filament_compare.hpp"
#include "observe/snapshot.hpp"
#include "scene/markers.hpp"
#include "scene/simulation.hpp"
#include "unit/command.hpp"

using namespace veriflex;
using unit::Folder;
using unit::Ran;

namespace {

const Grid box{{12, 10, 11}};

/// Velocity of the fluid at X by the kernel itself, over all nodes of the box.
Vec3 velocity_at(const fluid::Fluid& fluid, const Vec3& X) {
  Vec3 sum = Vec3::Zero();
  std::vector<std::int64_t> all(static_cast<std::size_t>(box.count()));
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::int64_t>(i);
  Positions u;
  fluid.velocities(all, u);
  for (Eigen::Index i = 0; i < u.rows(); ++i) {
    const auto at = box.node(i);
    double weight = 1.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      weight *= coupling::FourPoint::phi(
          std::remainder(static_cast<double>(at[axis]) - X[static_cast<Eigen::Index>(axis)],
                         static_cast<double>(box.size[axis])));
    }
    sum += weight * u.row(i).transpose();
  }
  return sum;
}

/// Mass times place of the fluid's momentum along x, over that momentum.
Vec3 centre_of_momentum(const fluid::Fluid& fluid) {
  std::vector<std::int64_t> all(static_cast<std::size_t>(box.count()));
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::int64_t>(i);
  std::vector<fluid::Populations> h(all.size());
  fluid.populations(all, h);
  Vec3 moment = Vec3::Zero();
  double whole = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto at = box.node(all[i]);
    const double along = fluid::momentum(h[i])[0];
    moment +=
        along * Vec3(static_cast<double>(at[0]), static_cast<double>(at[1]), static_cast<double>(at[2]));
    whole += along;
  }
  return moment / whole;
}

struct Free {
  double mass, volume;
  int substeps, rounds;
  bool subcycled;
};

constexpr double load = 0.02;

/// Two nodes on a bond along z, both pushed along x: the bond is never strained, and each moves as a point.
scene::Simulation pushed_pair(const Free& free) {
  scene::Body body{
      {bond::Harmonic{0.26, 1.0}, 0.0}, solid::cubic_lattice({{1, 1, 2}, 1.0}), {}, {free.substeps, 0.0}};
  body.conditions.node_mass = free.mass;
  body.conditions.load = Positions::Zero(2, 3);
  body.conditions.load.col(0).setConstant(load);
  body.place = {5.3, 4.6, 5.2};
  body.coupling = {.delta = coupling::Delta::FourPoint,
                   .coupled = scene::Coupled::Listed,
                   .listed = {0},
                   .marker_volume = free.volume,
                   .subcycled = free.subcycled,
                   .forcing_iterations = free.rounds};
  return scene::Simulation({.fluid = fluid::Spec{.grid = box, .relaxation_time = 0.9}, .bodies = {body}});
}

}  // namespace

TEST_CASE(
    "A free node takes F = V (u_f - v) as arithmetic says, for any V, mass and sub-steps, frozen and "
    "subcycled") {
  for (const Free& free :
       {Free{1.0, 1.0, 1, 1, false}, Free{0.8, 0.6, 3, 1, false}, Free{0.8, 0.6, 3, 1, true},
        Free{2.0, 1.7, 4, 1, true}, Free{3.0, 1.2, 2, 2, false}}) {
    INFO("V = " << free.volume << ", subcycled " << free.subcycled << ", rounds " << free.rounds);
    scene::Simulation simulation = pushed_pair(free);
    const double h = 1.0 / free.substeps;
    // The coupled node is bound to one that is not: the bond turns, and its force is of second order in the
    // turn.
    for (int step = 0; step < 3; ++step) {
      const Vec3 X = simulation.body().positions().row(0);
      const double u = velocity_at(simulation.fluid(), X)[0];
      double v = simulation.body().solid().carried_velocity()(0, 0);
      const double before = simulation.body().solid().displacement()(0, 0);
      const Vec3 momentum = simulation.fluid().totals().momentum;

      double squares = 0.0;  // sum D^2: what the marker feels of its own force
      for (std::int64_t i = 0; i < box.count(); ++i) {
        double weight = 1.0;
        const auto at = box.node(i);
        for (std::size_t axis = 0; axis < 3; ++axis)
          weight *=
              coupling::FourPoint::phi(static_cast<double>(at[axis]) - X[static_cast<Eigen::Index>(axis)]);
        squares += weight * weight;
      }
      double wanted = u;
      if (free.rounds == 2) wanted += (u - v) * (1.0 - free.volume * squares);
      double F = free.volume * (wanted - v), mean = 0.0, moved = 0.0;
      for (int i = 0; i < free.substeps; ++i) {
        if (free.subcycled) F = free.volume * (wanted - v);
        mean += F / free.substeps;
        v += h / free.mass * (load + F);
        moved += h * v;
      }
      simulation.advance();
      CHECK(simulation.body().exchanged()(0, 0) == Approx(mean).epsilon(1e-3));
      CHECK(simulation.body().solid().displacement()(0, 0) - before == Approx(moved).epsilon(1e-3));
      const Vec3 gained = simulation.fluid().totals().momentum - momentum;
      CHECK((gained + simulation.body().exchanged().row(0).transpose()).norm() < 1e-15);
    }
  }
}

TEST_CASE(
    "The reaction enters the fluid where the marker was when the velocity was taken, not where it went") {
  scene::Simulation simulation = pushed_pair({0.3, 1.0, 2, 1, false});
  const Vec3 X = simulation.body().positions().row(0);
  simulation.advance();
  const double moved = simulation.body().positions()(0, 0) - X[0];
  CHECK(moved > 0.01);
  CHECK((centre_of_momentum(simulation.fluid()) - X).norm() < 1e-6 * moved + 1e-12);
}

TEST_CASE("The ring of a rod shorter than it is thick lies around its own axis") {
  for (int axis = 0; axis < 3; ++axis) {
    solid::Network network = solid::rod_lattice({2.5, 3, 1.0});
    network.rest = scene::turned(network.rest, axis);
    network.vectors = scene::turned(network.vectors, axis);
    const auto ring =
        scene::coupled_nodes({.material = {bond::Harmonic{0.26, 1.0}, 0.0},
                              .network = network,
                              .axis = axis,
                              .coupling = scene::CouplingSpec{.coupled = scene::Coupled::Ring}});
    CHECK(ring.size() == 3 * 12);  // of 21 nodes a section 9 have four neighbours in it
  }
}

TEST_CASE("A marker and its mirror image between walls are accepted alike") {
  coupling::Transfer transfer({{8, 8, 7}}, {false, false, true}, coupling::Delta::Cosine);
  const auto at = [](double z) { return Positions(Vec3(4.3, 3.8, z).transpose()); };
  for (const double z : {1.0, 1.4, 2.0, 3.0}) {
    CHECK_NOTHROW(transfer.locate(at(z)));
    CHECK_NOTHROW(transfer.locate(at(6.0 - z)));
  }
  for (const double z : {0.999, 0.5}) {
    CHECK_THROWS_WITH(transfer.locate(at(z)), ContainsSubstring("reaches node -1"));
    CHECK_THROWS_WITH(transfer.locate(at(6.0 - z)), ContainsSubstring("reaches node 7"));
  }
}

TEST_CASE("A marker whose support contains a solid node is refused, and one beside it is not") {
  const std::vector<std::int64_t> solid{box.index(6, 5, 5)};
  coupling::Transfer transfer(box, {false, false, false}, coupling::Delta::Cosine, solid);
  for (int axis = 0; axis < 3; ++axis) {
    Positions X = Vec3(6.0, 5.0, 5.0).transpose();
    X(0, axis) -= 2.0;  // at that distance the weight is zero
    CHECK_NOTHROW(transfer.locate(X));
    X(0, axis) += 0.01;
    CHECK_THROWS_WITH(transfer.locate(X), ContainsSubstring("node (6, 5, 5) of the obstacle"));
  }
}

TEST_CASE("Each node of a support counts where it is solid, and no other of the box") {
  const Grid uneven{{6, 9, 12}};
  const Vec3 X{5.3, 2.4, 11.6};  // across the edges of the periodic box
  const auto away = [&](std::int64_t node, std::size_t axis) {
    return std::abs(
        std::remainder(static_cast<double>(uneven.node(node)[axis]) - X[static_cast<Eigen::Index>(axis)],
                       static_cast<double>(uneven.size[axis])));
  };
  for (std::int64_t node = 0; node < uneven.count(); ++node) {
    const bool is_under = away(node, 0) < 2.0 && away(node, 1) < 2.0 && away(node, 2) < 2.0;
    coupling::Transfer transfer(uneven, {false, false, false}, coupling::Delta::Cosine, std::vector{node});
    bool is_refused = false;
    try {
      transfer.locate(X.transpose());
    } catch (const NumericalFailure&) {
      is_refused = true;
    }
    INFO("node " << node);
    CHECK(is_refused == is_under);
  }
}

TEST_CASE("A picture of a body shows what the fluid does to each of its nodes that is coupled") {
  scene::Simulation simulation = pushed_pair({1.0, 1.0, 1, 1, false});
  simulation.advance(3);
  const io::VtkGrid picture = observe::picture_of_body(simulation.body(), 3.0);
  const auto force = std::find_if(picture.on_points.begin(), picture.on_points.end(),
                                  [](const io::VtkArray& one) { return one.name == "fluid_force"; });
  REQUIRE(force != picture.on_points.end());
  const Vec3 exchanged = simulation.body().exchanged().row(0);
  CHECK(exchanged.norm() > 0.0);
  CHECK(force->values == std::vector<double>{exchanged[0], exchanged[1], exchanged[2], 0.0, 0.0, 0.0});
}

TEST_CASE(
    "A picture of a body without bonds has each of its nodes as a cell, one of a fluid the stress of each "
    "node") {
  scene::Body dots;
  dots.network.rest = (Positions(3, 3) << 0, 0, 0, 1, 0, 0, 0, 2, 0).finished();
  dots.network.vectors.resize(0, 3);
  dots.motion = scene::Motion{.velocity = {0.01, 0.0, 0.0}};
  dots.place = {3.0, 3.0, 3.0};
  dots.coupling = {.coupled = scene::Coupled::All};
  const scene::Simulation of_dots(
      {.fluid = fluid::Spec{.grid = box, .relaxation_time = 0.9}, .bodies = {dots}});
  const io::VtkGrid picture = observe::picture_of_body(of_dots.body(), 0.0);
  CHECK(picture.cell == io::VtkCell::vertex);
  CHECK(picture.corners == std::vector<std::int64_t>{0, 1, 2});

  scene::Simulation simulation = pushed_pair({0.8, 0.6, 3, 1, false});
  simulation.advance(5);
  const fluid::Fluid& fluid = simulation.fluid();
  const std::array<std::int64_t, 3> from{4, 3, 5}, to{6, 5, 6};
  const io::VtkImage image =
      observe::picture_of_fluid(fluid, from, to, {.density = false, .velocity = false, .stress = true}, 5.0);
  REQUIRE(image.on_nodes.size() == 1);
  const std::vector<double>& stress = image.on_nodes[0].values;
  REQUIRE(stress.size() == 6 * 3 * 3 * 2);
  const std::vector<std::int64_t> last{fluid.spec().grid.index(6, 5, 6)};
  std::vector<fluid::Populations> h(1);
  fluid.populations(last, h);
  const Mat3 s = fluid::viscous_stress(h[0], 0.9);
  CHECK(std::vector<double>(stress.end() - 6, stress.end()) ==
        std::vector<double>{s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(0, 2)});
}

TEST_CASE("Swimming and the change from period to period are measured over the last period") {
  measures::StrokeResult seen;
  for (int k = 0; k < 3 * measures::phases_per_period; ++k) {
    seen.centre.push_back({0.0, k < 16 ? 100.0 : 0.25 * (k - 15), 0.0});
    seen.lines.push_back(Positions::Constant(3, 3, k < 8 ? 50.0 : k < 16 ? 0.0 : 0.5));
    seen.lines.back().col(1).setConstant(seen.centre.back()[1]);
  }
  seen.centre[15][1] = 0.75;
  seen.lines[15].col(1).setConstant(0.75);
  CHECK(measures::swum(seen) == Approx(0.25 * 8 - 0.75));
  CHECK(measures::change_over_last_period(seen, 2.0) == Approx(0.5 * std::sqrt(2.0) / 2.0));
}

TEST_CASE("A film has one frame for each phase of the last period, however many steps a period takes") {
  for (const double reynolds : {0.97, 1.0, 1.03, 1.06}) {
    const measures::Stroke stroke{.fluid = {.grid = {{12, 16, 12}}, .relaxation_time = 1.0},
                                  .rod = {1.0, 4, 1.0},
                                  .law = bond::Harmonic{0.26, 1.0},
                                  .angle_stiffness = 0.025,
                                  .node_mass = 1.0,
                                  .substeps = {2, 0.0},
                                  .coupling = {},
                                  .offset = Vec3::Zero(),
                                  .amplitude = 0.5,
                                  .reynolds = reynolds,
                                  .driven = measures::Driven::Node,
                                  .ramp_periods = 0.0,
                                  .periods = 2,
                                  .monitor = {},
                                  .film = 4};
    Progress progress("");
    measures::StrokeResult seen;
    measures::run_stroke(stroke, "", progress, seen);
    CAPTURE(reynolds, stroke.period(), seen.steps);
    std::vector<double> phases;
    for (const measures::Frame& frame : seen.film) phases.push_back(frame.phase);
    CHECK(phases == std::vector{0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0});
  }
}

namespace {

/// A small driven filament.
const std::string stroke = unit::case_head("stroke", "filament") +
                           R"(bond = { law = "harmonic", bond_stiffness = 0.26, rest_length = 1.0 }
compared_bond = { law = "harmonic", bond_stiffness = 0.25, rest_length = 1.0 }
angle = { stiffness = 0.025 }
solid = { shape = "rod", radius = 1.0, sections = 4 }
fluid = { nodes = [12, 16, 12], relaxation_time = 1.0 }
coupling = { marker_volume = 1.0 }
filament = { node_mass = 1.0, substeps = 2, amplitude = 0.5, reynolds = 1.0, periods = 1 }

[[check]]
kind = "verification"
statement = "any number"
metric = "deviation_z_max"
target = 0.0
target_kind = "analytic"
source = "any"
tolerance = { absolute = 1.0, reason = "only a number is wanted" }
)";

struct Refused {
  std::string set;
  std::string message;
};

}  // namespace

TEST_CASE("A filament that is not the one that was meant is refused with its reason") {
  const Folder folder;
  folder.write("stroke.toml", stroke);
  const std::vector<Refused> all{
      {"fluid.nodes=[5,16,12]", "the filament overlaps its own image along x"},
      {"fluid.nodes=[12,6,12]", "the filament overlaps its own image along y"},
      {"fluid.nodes=[12,16,6]", "the filament overlaps its own image along z"},
      {"filament.amplitude=4.0", "a stroke of 4 to either side"},
      {"filament.amplitude=1e300", "a period of the stroke takes"},
      {"filament.reynolds=1e-30", "a period of the stroke takes"},
      {"filament.reynolds=1e6", "a period of the stroke takes"},
      {"filament.ramp_periods=-5.0", "'ramp_periods' is -5"},
      {"filament.offset=[1.6e14,0.0,0.0]", "no longer tells places"},
      {"filament.modulus_factors=[0.0]", "a modulus is positive"},
      {"filament.modulus_factors=[-1.0]", "a modulus is positive"},
      {"filament.modulus_factors=[0.9, 0.9]", "twice the same run"},
      {"filament.node_mass=1e-300", "the coupling of the harmonic body to the fluid is unstable"},
      {"angle.stiffness=1e300", "bad"},
      {"coupling.marker_volume=30.0", "No node mass is stable with it: V S ="},
      {"coupling.forcing_iterations=100", "Use a node mass above"},
      {R"(fluid.obstacle={shape="sphere", centre=[6.0, 8.0, 6.0], radius=2.5})", "of the obstacle"},
      {R"(fluid.walls_z={low_velocity=[0.0, 0.0, 0.0]})", "any"},
      {"filament.periods=1000000", "'periods' is 1000000"},
  };
  for (const Refused& refused : all) {
    INFO(refused.set);
    const Ran ran = folder.run({"run", "stroke.toml", "--set", refused.set});
    if (refused.message == "any") {
      CHECK(ran.code == 0);
      continue;
    }
    CHECK(ran.code == 2);
    if (refused.message != "bad") CHECK_THAT(ran.err, ContainsSubstring(refused.message));
  }
}

TEST_CASE("Whole boxes of offset change nothing, and one period is no change of periods") {
  const Folder folder;
  folder.write("stroke.toml", stroke);
  const Ran ran = folder.run({"run", "stroke.toml", "--set", "check.0.metric=period_change"});
  CHECK(ran.code == 2);
  CHECK_THAT(ran.err, ContainsSubstring("period_change"));
  std::vector<std::string> seen;
  for (const std::string offset : {"[0.0, 0.0, 0.0]", "[12.0, -16.0, 2.4e8]"}) {
    const Ran moved = folder.run({"run", "stroke.toml", "--set", "filament.offset=" + offset, "--json"});
    CHECK(moved.code == 0);
    const std::size_t at = moved.out.find("\"measured\"");
    seen.push_back(moved.out.substr(at, moved.out.find(',', at) - at));
  }
  CHECK(seen[0] == seen[1]);
}

TEST_CASE("Immersed bodies and scenes that have no room, no end or no meaning are refused") {
  const Folder folder;
  const std::vector<std::vector<std::string>> all{
      {"immersed-rod", "immersed.radius=30.0", "the rod overlaps its own image along x"},
      {"immersed-rod", "immersed.amplitudes=[40.0]", "the rod overlaps its own image along y"},
      {"immersed-rod", "immersed.oscillation_periods=[4611686018427387904]", "a period without end"},
      {"immersed-cylinders", "immersed.marker_spacing=1e-200", "'marker_spacing' is 1e-200"},
      {"immersed-cylinders", "immersed.radius=1e6", "'radius' is 1000000"},
      {"immersed-cylinders", "immersed.solid_fractions=[]", "has no 'drag_1'"},
      {"immersed-cylinders", "immersed.solid_fractions=[0.78]", "bodies touch at 0.785"},
      {"immersed-cylinders", "fluid.relaxation_time=0.50000000000001", "to settle the flow takes"},
      {"immersed-plate", "immersed.period=1000000000", "'period' is 1000000000"},
      {"immersed-rod", "fluid.relaxation_time=1e6", "the Stokes layer is"},
      {"filament-sensitivity-small", "variant.1.name=FIRST", "is no name"},
      {"crossflow-harmonic", "fluid.nodes=[40, 20, 40]", "the rod overlaps its own image along y"},
      {"coupling-stability", "coupling_stability.stiffness=1e308", "it lies between"},
      {"scene-sphere-beside-rod", "body.1.place=[17.0,12.0,4.0]", "rod stands in sphere"},
      {"scene-sphere-beside-rod", "body.0.place=[2.0,12.0,24.0]", "sphere leaves the fluid"},
      {"scene-sphere-beside-rod", "body.1.clamped=[5000]", "the body has nodes 0 to 179"},
      {"scene-sphere-beside-rod", "body.0.shape={cube={}}", "'cube' is no shape"},
      {"scene-sphere-beside-rod", "body.0.node_mass=0.1", "the coupling of sphere to the fluid is unstable"},
      {"scene-sphere-beside-rod", "body.1.name=sphere", "two bodies are called 'sphere'"},
      {"scene-sphere-beside-rod", "run.periods=3", "both steps and periods"},
      {"flag-behind-cylinder-coarse", "fluid.nodes=[250, 41, 2]", "cylinder overlaps its own image along z"},
      {"scene-two-prescribed", "observe.0.phases=100", "there is one look a step at most"},
      {"scene-two-prescribed", "body.0.node_mass=1.0", "the motion of that body is given"},
      {"scene-chain-alone", "body.0.coupling={}", "the scene has no fluid"},
  };
  for (const auto& refused : all) {
    INFO(refused[0] << " " << refused[1]);
    const Ran ran = folder.run({"run", refused[0], "--set", refused[1]});
    CHECK(ran.code == 2);
    CHECK_THAT(ran.err, ContainsSubstring(refused[2]));
  }
}

TEST_CASE(
    "A run that leaves its validity within its only period says so at its last step, with what was seen") {
  const Folder folder;
  const Ran plate = folder.run({"run", "immersed-plate", "--set", "sweep=", "--set", "check=", "--set",
                                "immersed.nodes=16", "--set", "immersed.period=64", "--set",
                                "immersed.periods=1", "--set", "immersed.velocity=0.7", "--out", "out"});
  CHECK(plate.code == 3);
  CHECK_THAT(plate.err, ContainsSubstring("Mach number"));
}

TEST_CASE("Plans of immersed bodies say that they meet a fluid") {
  const Folder folder;
  for (const std::string id : {"immersed-spheres", "immersed-cylinders", "immersed-plate", "immersed-rod",
                               "coupling-stability", "filament-stroke", "crossflow-harmonic"}) {
    INFO(id);
    const Ran plan = folder.run({"plan", id});
    CHECK(plan.code == 0);
    CHECK(plan.out.find("no body meets a fluid") == std::string::npos);
  }
}
