#include "engine/read_scene.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace veriflex::engine {

namespace {

constexpr std::int64_t max_nodes = 1'000'000'000'000;

[[noreturn]] void fail_at(const io::Table& table, const BadParameter& bad) {
  table.fail(bad.parameter, bad.problem, bad.why, bad.suggestion);
}

std::array<std::int64_t, 3> read_nodes(const io::Table& solid, const std::string& shape) {
  if (shape == "pair") return {1, 1, 2};
  if (shape == "chain") return {1, 1, solid.integer("nodes", 2, max_nodes)};
  const std::vector<std::int64_t> nodes = solid.integers("nodes");
  if (nodes.size() != 3) {
    solid.fail("nodes", fmt::format("'nodes' has {} numbers", nodes.size()),
               "a bar has n, m and l nodes along x, y and z", "Write for example nodes = [4, 4, 12]");
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const std::int64_t min = i == 2 ? 2 : 1;
    if (nodes[i] < min || nodes[i] > max_nodes) {
      solid.fail("nodes", fmt::format("'nodes' holds {}", nodes[i]),
                 fmt::format("the number along {} must lie between {} and {}", "xyz"[i], min, max_nodes),
                 "Choose a number in that range");
    }
  }
  // Beyond this the numbers of nodes and bonds leave 64 bits; what fits into memory is the plan's matter.
  if (static_cast<double>(nodes[0]) * static_cast<double>(nodes[1]) * static_cast<double>(nodes[2]) >
      static_cast<double>(max_nodes)) {
    solid.fail("nodes", fmt::format("{} x {} x {} nodes are too many", nodes[0], nodes[1], nodes[2]),
               fmt::format("{} is more than any memory holds", max_nodes), "Use fewer nodes");
  }
  return {nodes[0], nodes[1], nodes[2]};
}

}  // namespace

bond::AnyLaw read_law(const io::Table& top, const std::string& where) {
  const io::Table table = top.table(where);
  const std::string name = table.text("law");
  try {
    return bond::make_law(name, [&](const std::string& parameter) -> std::optional<double> {
      return table.has(parameter) ? std::optional(table.number_or_infinity(parameter)) : std::nullopt;
    });
  } catch (const MissingParameter& missing) {
    table.number(missing.parameter);  // throws, and knows about misspelt keys
    throw;
  } catch (const BadParameter& bad) {
    fail_at(table, bad);
  }
}

bond::Derivation read_derivation(const io::Table& top, const bond::AnyLaw& law) {
  try {
    return bond::derive(law);
  } catch (const BadParameter& bad) {
    fail_at(top.table("bond"), bad);
  } catch (const NumericalFailure& failure) {
    throw InputError(top.table("bond").place(), "the bond law has no usable rest state", failure.what(),
                     "Look at the size of its parameters");
  }
}

double read_angle_stiffness(const io::Table& top) {
  if (!top.has("angle")) return 0.0;
  const io::Table table = top.table("angle");
  const double stiffness = table.number("stiffness");
  if (!(stiffness >= 0.0)) {
    table.fail("stiffness", fmt::format("'stiffness' is {}", stiffness), "k_a cannot be negative",
               "Give 0 or more");
  }
  return stiffness;
}

double read_stiffness_factor(const io::Table& table) {
  const double factor = table.number("stiffness", 1.0);
  if (!(factor >= 1e-6) || factor > 1e6)
    table.fail("stiffness", fmt::format("'stiffness' is {}", factor), "it lies between 1e-6 and 1e6",
               "1 is the body's own");
  return factor;
}

scene::SolidSpec read_solid(const io::Table& top, const bond::AnyLaw& law, double rest_length) {
  const io::Table table = top.table("solid");
  const std::string shape = table.choice("shape", {"pair", "chain", "bar", "rod"});
  const double spacing = table.number("spacing", rest_length);
  if (const Interval domain = bond::domain(law); !domain.contains(spacing)) {
    table.fail(
        "spacing", fmt::format("'spacing' is {}", spacing),
        fmt::format("bond law {} is defined between {} and {}", bond::name_of(law), domain.lo, domain.hi),
        "Choose a spacing inside, near the rest length");
  }
  const double angle_stiffness = read_angle_stiffness(top);
  if (shape == "rod") {
    const double radius = table.number("radius");
    if (!(radius >= 0.0) || radius > 1000.0) {
      table.fail("radius", fmt::format("'radius' is {}", radius), "it is in spacings, from 0 to 1000",
                 "2.5 gives 21 nodes a section");
    }
    return {.shape = solid::Rod{radius, table.integer("sections", 1, max_nodes), spacing},
            .angle_stiffness = angle_stiffness};
  }
  return {.shape = solid::Block{read_nodes(table, shape), spacing}, .angle_stiffness = angle_stiffness};
}

scene::SolidSpec read_solid_at_rest(const io::Table& top, const bond::AnyLaw& law, double rest_length) {
  const scene::SolidSpec solid = read_solid(top, law, rest_length);
  const double spacing = std::visit([](const auto& shape) { return shape.spacing; }, solid.shape);
  if (spacing != rest_length) {
    top.table("solid").fail(
        "spacing", fmt::format("'spacing' is {}", spacing),
        fmt::format("the theory is that of a body at rest, and the rest length is {}", rest_length),
        "Leave it out");
  }
  return solid;
}

double need_positive(const io::Table& table, const std::string& key, double value,
                     const std::string& suggestion) {
  if (!(value > 0.0))
    table.fail(key, fmt::format("'{}' is {}", key, value), "it must be positive", suggestion);
  return value;
}

Vec3 read_vector(const io::Table& table, const std::string& key) {
  const std::vector<double> v = table.numbers(key);
  if (v.size() != 3) {
    table.fail(key, fmt::format("'{}' has {} numbers", key, v.size()), "a vector has x, y and z",
               fmt::format("Write for example {} = [0.0, 0.0, 1e-6]", key));
  }
  return {v[0], v[1], v[2]};
}

int read_axis(const io::Table& table, const std::string& key) {
  return table.choice(key, {"x", "y", "z"})[0] - 'x';
}

// Or the viscosity that stands for it.
double read_relaxation_time(const io::Table& table) {
  if (table.has("viscosity")) {
    if (table.has("relaxation_time")) {
      table.fail("viscosity", "both viscosity and relaxation_time",
                 fmt::format("either says the other, and relaxation_time stands at {}",
                             to_string(table.place("relaxation_time"))),
                 "Keep one");
    }
    const double viscosity =
        need_positive(table, "viscosity", table.number("viscosity"), "For example 0.1 is tau = 0.8");
    return 3.0 * viscosity + 0.5;
  }
  const double tau = table.number("relaxation_time");
  if (!(tau > 0.5)) {
    table.fail("relaxation_time", fmt::format("'relaxation_time' is {}", tau),
               "the viscosity (tau - 1/2)/3 must be positive", "Use more than 0.5, for example 1.0");
  }
  return tau;
}

namespace {

constexpr std::int64_t max_fluid_nodes = 1'000'000;  // along one axis

/// What stands in the place of the wall at one end of an axis.
std::variant<std::monostate, fluid::Inflow, fluid::Outflow> read_opening(const io::Table& walls,
                                                                         std::size_t axis, bool high) {
  const std::string end = high ? "high" : "low";
  const std::string in = end + "_inflow", out = end + "_outflow";
  for (const std::string& key : {in, out}) {
    if (!walls.has(key)) continue;
    for (const std::string& other : {end + "_velocity", key == in ? out : in}) {
      if (walls.has(other)) {
        walls.fail(other, fmt::format("'{}' and '{}' are both given", key, other),
                   "an end of an axis is a wall, an inflow or an outflow", "Leave one of them out");
      }
    }
  }
  if (walls.has(out)) {
    const io::Table table = walls.table(out);
    return fluid::Outflow{
        need_positive(table, "density", table.number("density", 1.0), "Leave it out for 1")};
  }
  if (!walls.has(in)) return {};
  const io::Table table = walls.table(in);
  fluid::Inflow inflow{.velocity = read_vector(table, "velocity")};
  const double inwards = (high ? -1.0 : 1.0) * inflow.velocity[static_cast<Eigen::Index>(axis)];
  if (!(inwards > 0.0)) {
    table.fail("velocity", "the fluid does not enter the box with it",
               fmt::format("at the {} end its component along {} must be {}", end, "xyz"[axis],
                           high ? "negative" : "positive"),
               "Change its sign, or make that end an outflow");
  }
  inflow.parabolic = table.has("profile") && table.choice("profile", {"uniform", "parabolic"}) == "parabolic";
  inflow.rise = table.number("rise", 0.0);
  if (!(inflow.rise >= 0.0 && std::isfinite(inflow.rise))) {
    table.fail("rise", fmt::format("'rise' is {}", inflow.rise), "it is a number of steps",
               "Leave it out for none");
  }
  return inflow;
}

std::optional<fluid::Walls> read_walls(const io::Table& fluid, std::size_t axis) {
  const std::string key = fmt::format("walls_{}", "xyz"[axis]);
  if (!fluid.has(key)) return std::nullopt;
  const io::Table table = fluid.table(key);
  fluid::Walls walls;
  if (table.has("low_velocity")) walls.low_velocity = read_vector(table, "low_velocity");
  if (table.has("high_velocity")) walls.high_velocity = read_vector(table, "high_velocity");
  for (const auto& [name, velocity] :
       {std::pair{"low_velocity", walls.low_velocity}, {"high_velocity", walls.high_velocity}}) {
    if (velocity[static_cast<Eigen::Index>(axis)] != 0.0) {
      table.fail(name, "the wall moves through the fluid", "a wall can move along itself only",
                 "Set that component to 0");
    }
  }
  for (const bool high : {false, true}) walls.openings[high ? 1 : 0] = read_opening(table, axis, high);
  return walls;
}

/// What enters must be able to leave: between inflows alone the mass would grow until nothing is valid.
void check_openings(const io::Table& fluid, const fluid::Spec& spec) {
  const fluid::Inflow* inflow = nullptr;
  std::size_t axis_of_inflow = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t end = 0; spec.walls[axis] && end < 2; ++end) {
      const auto& opening = spec.walls[axis]->openings[end];
      if (std::holds_alternative<fluid::Outflow>(opening)) return;
      if (const auto* found = std::get_if<fluid::Inflow>(&opening)) {
        inflow = found;
        axis_of_inflow = axis;
      }
    }
  }
  if (inflow == nullptr) return;
  fluid.fail(fmt::format("walls_{}", "xyz"[axis_of_inflow]), "fluid enters the box and cannot leave it",
             "no end of an axis is an outflow", "Give the end across an outflow: high_outflow = {}");
}

/// The voxels of the obstacle; a box that does not fit into memory is refused before they are sought.
std::vector<std::int64_t> read_voxels(const io::Table& fluid, const fluid::Spec& spec) {
  const fluid::Shape shape = read_obstacle(fluid);
  try {
    fluid::require_memory(spec);
  } catch (const BadParameter& bad) {
    fluid.fail("nodes", bad.problem, bad.why, bad.suggestion);
  }
  std::vector<std::int64_t> nodes = fluid::voxels(spec.grid, shape, fluid::closed(spec));
  if (nodes.empty() || static_cast<std::int64_t>(nodes.size()) == spec.grid.count()) {
    fluid.table("obstacle")
        .fail("radius", fmt::format("the obstacle covers {} nodes", nodes.empty() ? "no" : "all"),
              nodes.empty() ? "its centre may lie beyond a wall, or its radius be below the lattice's spacing"
                            : "it stops the fluid at some nodes of the box only",
              "Change its radius or centre");
  }
  return nodes;
}

}  // namespace

std::vector<std::string> read_kept(const io::Table& table, const std::vector<std::string>& known) {
  if (!table.has("keep")) return {};
  const std::vector<std::string> kept = table.texts("keep");
  for (const std::string& part : kept) {
    if (std::find(known.begin(), known.end(), part) != known.end()) continue;
    table.fail("keep", fmt::format("'{}' is no part that can be kept", part),
               fmt::format("these can: {}", fmt::join(known, ", ")),
               "Write for example keep = [\"" + known.front() + "\"]");
  }
  return kept;
}

std::array<std::int64_t, 3> read_box(const io::Table& fluid) {
  const std::vector<std::int64_t> nodes = fluid.integers("nodes");
  if (nodes.size() != 3) {
    fluid.fail("nodes", fmt::format("'nodes' has {} numbers", nodes.size()),
               "the box has nodes along x, y and z", "Write for example nodes = [32, 32, 32]");
  }
  for (const std::int64_t n : nodes) {
    if (n < 1 || n > max_fluid_nodes) {
      fluid.fail("nodes", fmt::format("'nodes' holds {}", n),
                 fmt::format("an axis has 1 to {} nodes", max_fluid_nodes), "Choose a number in that range");
    }
  }
  return {nodes[0], nodes[1], nodes[2]};
}

fluid::Shape read_obstacle(const io::Table& fluid) {
  const io::Table table = fluid.table("obstacle");
  const std::string shape = table.choice("shape", {"sphere", "cylinder"});
  const Vec3 centre = read_vector(table, "centre");
  const double radius = need_positive(table, "radius", table.number("radius"), "Give for example 4.0");
  if (centre.cwiseAbs().maxCoeff() > static_cast<double>(max_fluid_nodes)) {
    table.fail("centre", "the centre lies beyond any box",
               fmt::format("an axis has at most {} nodes", max_fluid_nodes), "Give a place in the box");
  }
  if (shape == "sphere") return fluid::Sphere{centre, radius};
  return fluid::Cylinder{centre, radius, static_cast<std::size_t>(read_axis(table))};
}

void check_representation(const io::Table& top, const fluid::Spec& spec) {
  try {
    fluid::representation_of(spec);
  } catch (const BadParameter& bad) {
    top.table("fluid").fail("representation", bad.problem, bad.why, bad.suggestion);
  }
}

fluid::Spec read_fluid(const io::Table& top, Varied varied) {
  const io::Table table = top.table("fluid");
  fluid::Spec spec{.grid = {{1, 1, 1}}, .relaxation_time = 1.0};
  if (varied == Varied::Nothing) spec.grid.size = read_box(table);
  if (varied != Varied::NodesAndRelaxationTime) spec.relaxation_time = read_relaxation_time(table);
  if (table.has("storage")) {
    spec.storage = row_named(fluid::storages, table.choice("storage", names_of(fluid::storages))).value;
  }
  if (table.has("representation")) {
    const std::string name = table.choice("representation", names_of(fluid::representations));
    spec.representation = row_named(fluid::representations, name).value;
  }
  if (varied != Varied::NodesAndRelaxationTime) check_representation(top, spec);
  if (table.has("body_force")) spec.body_force = read_vector(table, "body_force");
  if (table.has("force_scheme")) {
    spec.scheme = row_named(fluid::schemes, table.choice("force_scheme", names_of(fluid::schemes))).value;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) spec.walls[axis] = read_walls(table, axis);
  check_openings(table, spec);
  if (varied == Varied::Nothing && table.has("obstacle")) spec.obstacle = read_voxels(table, spec);
  for (const std::string& part : read_kept(table, {"body force", "obstacle"}))
    (part == "obstacle" ? spec.kept.obstacle : spec.kept.body_force) = true;
  return spec;
}

observe::MonitorSpec read_monitor(const io::Table& top) {
  observe::MonitorSpec monitor;
  if (!top.has("monitor")) return monitor;
  const io::Table table = top.table("monitor");
  if (table.has("every")) monitor.every = table.integer("every", 1, 1'000'000'000);
  monitor.mach_limit = table.number("mach_limit", monitor.mach_limit);
  if (!(monitor.mach_limit > 0.0)) {
    table.fail("mach_limit", fmt::format("'mach_limit' is {}", monitor.mach_limit), "nothing may move then",
               "Give for example 0.3");
  }
  return monitor;
}

constexpr std::int64_t max_listed_node = 2'000'000'000;

scene::CouplingSpec read_coupling(const io::Table& top) {
  scene::CouplingSpec spec;
  if (!top.has("coupling")) return spec;
  const io::Table table = top.table("coupling");
  if (table.has("delta")) {
    spec.delta = row_named(coupling::deltas, table.choice("delta", names_of(coupling::deltas))).value;
  }
  if (table.has_list("nodes")) {
    spec.coupled = scene::Coupled::Listed;
    for (const std::int64_t node : table.integers("nodes")) {
      if (node < 0 || node > max_listed_node) {
        table.fail("nodes", fmt::format("'nodes' lists node {}", node), "nodes are counted from 0",
                   "List the body's own nodes");
      }
      spec.listed.push_back(static_cast<std::int32_t>(node));
    }
  } else if (table.has("nodes")) {
    const std::string name = table.choice("nodes", {"boundary", "ring", "all"});
    spec.coupled = name == "boundary" ? scene::Coupled::Boundary
                   : name == "ring"   ? scene::Coupled::Ring
                                      : scene::Coupled::All;
  }
  spec.marker_volume = table.number("marker_volume", spec.marker_volume);
  if (!(spec.marker_volume >= 1e-9) || spec.marker_volume > 1e9) {
    table.fail("marker_volume", fmt::format("'marker_volume' is {}", spec.marker_volume),
               "it lies between 1e-9 and 1e9", "1 is the paper's, one lattice cell");
  }
  spec.subcycled = table.flag("subcycled", spec.subcycled);
  spec.allow_unstable = table.flag("allow_unstable", spec.allow_unstable);
  if (table.has("forcing_iterations"))
    spec.forcing_iterations = static_cast<int>(table.integer("forcing_iterations", 1, 100));
  return spec;
}

scene::Plan read_plan(const io::Table& top, const scene::Outline& scene) {
  try {
    return scene::plan(scene);
  } catch (const BadParameter& bad) {
    // The parameter is named with its table: "solid.nodes".
    const std::size_t dot = bad.parameter.find('.');
    top.table(bad.parameter.substr(0, dot))
        .fail(bad.parameter.substr(dot + 1), bad.problem, bad.why, bad.suggestion);
  }
}

}  // namespace veriflex::engine
