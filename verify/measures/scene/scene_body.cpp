#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <numeric>

#include "base/memory.hpp"
#include "engine/read_scene.hpp"
#include "io/lammps_data.hpp"
#include "measures/scene/scene.hpp"
#include "measures/solid/noise.hpp"
#include "scene/lammps_network.hpp"
#include "scene/markers.hpp"

// A [[body]]: its shape, what it is made of, where it stands, and how it is held, driven, loaded and coupled.

namespace veriflex::measures {

namespace {

constexpr std::int64_t max_nodes = 700'000'000;
constexpr double largest_size = 1e6;      // of a shape, in spacings
constexpr double farthest_place = 1e9;    // beyond, a number no longer tells places within a spacing apart
constexpr double automatic_safety = 0.5;  // of sub-steps = "auto": sub-step over the linear limit

double read_size(const io::Table& t, const std::string& key, double least) {
  const double size = t.number(key);
  if (!(size >= least) || size > largest_size) {
    t.fail(key, fmt::format("'{}' is {}", key, size),
           fmt::format("it is in spacings, from {} to {}", least, largest_size), "Give for example 4.5");
  }
  return size;
}

/// Refuses a body beyond the memory before it is built.
void require_room(const io::Table& t, double cells) {
  constexpr double bytes_per_node = 1000.0;  // rest, bonds, angles, and what a motion carries
  const double available = available_memory_bytes();
  if (cells < static_cast<double>(max_nodes) && cells * bytes_per_node < available) return;
  throw InputError(t.place(), fmt::format("the body may have {:.3g} nodes", cells),
                   fmt::format("it would take about {:.3g} GB, {:.3g} GB are available",
                               cells * bytes_per_node * 1e-9, available * 1e-9),
                   "Use a smaller one");
}

solid::Network read_block(const io::Table& t, double spacing) {
  const std::vector<std::int64_t> nodes = t.integers("nodes");
  if (nodes.size() != 3 || *std::min_element(nodes.begin(), nodes.end()) < 1 ||
      *std::max_element(nodes.begin(), nodes.end()) > max_nodes) {
    t.fail("nodes", "'nodes' is no size of a block", "a block has 1 or more nodes along x, y and its axis z",
           "Write for example nodes = [4, 4, 12]");
  }
  const solid::Block block{{nodes[0], nodes[1], nodes[2]}, spacing};
  require_room(t, static_cast<double>(block.node_count()));
  return solid::cubic_lattice(block);
}

solid::Network read_rod(const io::Table& t, double spacing) {
  const solid::Rod rod{read_size(t, "radius", 0.0), t.integer("sections", 1, max_nodes), spacing};
  const double across = 2.0 * rod.radius + 1.0;
  require_room(t, across * across * static_cast<double>(rod.sections));
  return solid::rod_lattice(rod);
}

solid::Network read_spheroid(const io::Table& t, bool sphere, double spacing) {
  const double radius = read_size(t, "radius", 1.0);
  const solid::Spheroid spheroid{radius, sphere ? radius : read_size(t, "half_length", 1.0), spacing};
  const double across = 2.0 * radius + 1.0;
  require_room(t, across * across * (2.0 * spheroid.half_length + 1.0));
  return solid::spheroid_lattice(spheroid);
}

solid::Network read_plate(const io::Table& t, double spacing) {
  const std::vector<double> sides = t.numbers("sides");
  if (sides.size() != 2 || !(sides[0] >= 2.0) || !(sides[1] >= 2.0) || sides[0] > largest_size ||
      sides[1] > largest_size) {
    t.fail("sides", "'sides' is no size of a plate",
           fmt::format("two sides along x and y, in spacings, from 2 to {}", largest_size),
           "Write for example sides = [20.0, 10.0]");
  }
  const double thickness = t.has("thickness") ? read_size(t, "thickness", 0.0) : 0.0;
  require_room(t, (sides[0] + 1.0) * (sides[1] + 1.0) * (thickness + 1.0));
  return solid::plate_lattice({{sides[0], sides[1]}, thickness, spacing});
}

solid::Network read_data_file(const io::Table& t) {
  const std::filesystem::path beside = std::filesystem::path(t.place().file).parent_path();
  const std::vector<std::int64_t> straight =
      t.has("straight_types") ? t.integers("straight_types") : std::vector<std::int64_t>{};
  return scene::network_of(io::read_lammps_data(beside / t.text("file")), straight);
}

/// "first section", "last section", "all" or a list. Sections lie across the body's own z axis, `along` being
/// its nodes' places on it.
std::vector<std::int32_t> read_nodes(const io::Table& table, const std::string& key,
                                     const Eigen::VectorXd& along, double spacing) {
  std::vector<std::int32_t> nodes;
  if (table.has_list(key)) {
    nodes = read_node_list(table, key, along.size());
    if (nodes.empty())
      table.fail(key, fmt::format("'{}' lists no node", key), "it would do nothing", "Leave it out");
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    return nodes;
  }
  const std::string which = table.choice(key, {"first section", "last section", "all"});
  if (which != "all") return scene::end_section(along, spacing, which == "last section");
  nodes.resize(static_cast<std::size_t>(along.size()));
  std::iota(nodes.begin(), nodes.end(), 0);
  return nodes;
}

/// `period` or `frequency`, its inverse  [T].
double read_period(const io::Table& t) {
  if (t.has("period") == t.has("frequency")) {
    throw InputError(t.place(),
                     t.has("period") ? "both period and frequency" : "neither period nor frequency",
                     "one follows from the other", "Give one");
  }
  const std::string key = t.has("period") ? "period" : "frequency";
  const double value = t.has("period") ? t.number("period") : t.number("frequency");
  engine::need_positive(t, key, value);
  const double period = key == "period" ? value : 1.0 / value;
  if (!(period >= 4.0) || period > 1e9) {
    t.fail(key, fmt::format("a period takes {} steps", period), "it takes from 4 to 1e9 of them",
           "Change it, or leave the motion out");
  }
  return period;
}

void read_drive(const io::Table& t, const Eigen::VectorXd& along, bool guided, scene::Body& body,
                CaseBody& said) {
  const double period = read_period(t);
  solid::Drive drive{.nodes = read_nodes(t, "nodes", along, body.network.spacing),
                     .axis = engine::read_axis(t, "direction"),
                     .amplitude = t.number("amplitude"),
                     .omega = 2.0 * std::numbers::pi / period,
                     .ramp = t.number("ramp", 0.0)};
  if (guided && drive.axis != body.axis) {
    t.fail("direction", "the body is guided along its axis, and driven across it", "it cannot be both",
           "Drive it along its axis, or leave 'guided' out");
  }
  if (drive.ramp < 0.0) {
    t.fail("ramp", fmt::format("'ramp' is {}", drive.ramp), "it lasts 0 steps or more", "0 starts abruptly");
  }
  said.stroke[drive.axis] = std::abs(drive.amplitude);
  said.period = period;
  body.conditions.drive = std::move(drive);
}

void read_load(const io::Table& t, const Eigen::VectorXd& along, scene::Body& body) {
  const Vec3 force = engine::read_vector(t, "force");
  if (body.conditions.load.size() == 0) body.conditions.load = Positions::Zero(along.size(), 3);
  for (const std::int32_t node : read_nodes(t, "nodes", along, body.network.spacing)) {
    body.conditions.load.row(node) += force.transpose();
  }
}

/// A motion across the body's own axis is none where it is guided along it.
void guide_along_axis(int axis, solid::FixedDofs& fixed) {
  for (int other = 0; other < 3; ++other) {
    if (other != axis) fixed.col(other).setConstant(true);
  }
}

/// The displacement and the velocity that the body has when the scene starts. `along` is each node's place on
/// the body's own axis.
void read_start(const io::Table& t, const Eigen::VectorXd& along, double bond_stiffness, scene::Body& body) {
  const solid::FixedDofs& fixed = body.conditions.fixed;
  Positions& u = body.start.displacement;
  u = Positions::Zero(along.size(), 3);
  const double strain = t.number("strain", 0.0);
  if (!(strain > -1.0)) {
    t.fail("strain", fmt::format("'strain' is {}", strain), "the body would start turned inside out",
           "Give more than -1");
  }
  u.col(body.axis) = strain * along;
  if (t.has("noise")) {
    const double amplitude = t.number("noise");
    engine::need_positive(t, "noise", amplitude);
    Positions moved =
        u + noise(along.size(), amplitude,
                  static_cast<std::uint64_t>(t.has("seed") ? t.integer("seed", 1, 1'000'000'000) : 1));
    if (fixed.size() > 0) moved = fixed.select(u, moved);
    u = std::move(moved);
  }
  if (!t.has("impact")) return;
  const io::Table impact = t.table("impact");
  const double spacing = body.network.spacing;
  const double wave_speed = spacing * std::sqrt(bond_stiffness / body.conditions.node_mass);
  Positions& v = body.start.velocity;
  v = Positions::Zero(along.size(), 3);
  const int axis = engine::read_axis(impact, "direction");
  const double speed = impact.number("strain") * wave_speed;
  bool moves = false;
  for (const std::int32_t node : read_nodes(impact, "nodes", along, spacing)) {
    if (fixed.size() > 0 && fixed(node, axis)) continue;
    v(node, axis) = speed;
    moves = true;
  }
  if (!moves) {
    impact.fail("nodes", "none of these nodes may move in that direction", "it would do nothing",
                "Strike others, or hold them less");
  }
}

/// Whether a part that the body does not need is kept.
bool keeps(const io::Table& body, const std::string& part) {
  const std::vector<std::string> kept = engine::read_kept(body, {"angles", "constraints", "loads"});
  return std::find(kept.begin(), kept.end(), part) != kept.end();
}

/// What a body that moves by its own forces has.
void read_elastic(const io::Table& t, const Eigen::VectorXd& along, double bond_stiffness, scene::Body& body,
                  CaseBody& said) {
  solid::Conditions& conditions = body.conditions;
  conditions.node_mass = t.number("node_mass", conditions.node_mass);
  engine::need_positive(t, "node_mass", conditions.node_mass);
  if (t.has("integrator")) {
    body.scheme = row_named(solid::schemes, t.choice("integrator", names_of(solid::schemes))).value;
  }
  if (t.has_text("substeps")) {
    t.choice("substeps", {"auto"});
    body.substeps.safety = automatic_safety;
  } else if (t.has("substeps")) {
    body.substeps.count = static_cast<int>(t.integer("substeps", 1, 10000));
  }
  if (t.has("max_substeps")) body.substeps.most = static_cast<int>(t.integer("max_substeps", 0, 1'000'000));
  if (body.scheme == solid::Scheme::ImplicitMidpoint &&
      (body.substeps.count > 1 || body.substeps.safety > 0.0 || body.substeps.most > 0)) {
    t.fail(body.substeps.most > 0 ? "max_substeps" : "substeps", "a step is to be divided",
           "the implicit midpoint rule makes it in one piece", "Leave it out, or take leap-frog");
  }
  if (t.has("clamped")) {
    conditions.fixed = solid::FixedDofs::Constant(along.size(), 3, false);
    for (const std::int32_t node : read_nodes(t, "clamped", along, body.network.spacing)) {
      conditions.fixed.row(node).setConstant(true);
    }
  }
  const bool guided = t.flag("guided", false);
  if (guided) {
    if (conditions.fixed.size() == 0) conditions.fixed = solid::FixedDofs::Constant(along.size(), 3, false);
    guide_along_axis(body.axis, conditions.fixed);
  }
  if (t.has("weight")) {
    conditions.load = engine::read_vector(t, "weight").transpose().replicate(along.size(), 1);
  }
  if (t.has("load")) read_load(t.table("load"), along, body);
  if (conditions.load.isZero(0.0) && !keeps(t, "loads")) conditions.load.resize(0, 3);
  if (conditions.load.size() == 0 && keeps(t, "loads")) conditions.load = Positions::Zero(along.size(), 3);
  if (conditions.fixed.size() == 0 && keeps(t, "constraints"))
    conditions.fixed = solid::FixedDofs::Constant(along.size(), 3, false);
  if (t.has("drive")) read_drive(t.table("drive"), along, guided, body, said);
  if (t.has("start")) read_start(t.table("start"), along, bond_stiffness, body);
}

/// A motion that is given leaves nothing to what the body is made of.
void read_given_motion(const io::Table& t, scene::Body& body, CaseBody& said) {
  for (const char* key : {"bond", "angle", "stiffness", "node_mass", "integrator", "substeps", "max_substeps",
                          "clamped", "guided", "weight", "load", "drive", "start", "keep"}) {
    if (t.has(key)) {
      t.fail(key, fmt::format("'{}' is set beside 'motion'", key), "the motion of that body is given",
             "Leave one of them out");
    }
  }
  const io::Table table = t.table("motion");
  scene::Motion motion;
  if (table.has("velocity")) motion.velocity = engine::read_vector(table, "velocity");
  if (table.has("amplitude")) {
    motion.amplitude = engine::read_vector(table, "amplitude");
    said.period = read_period(table);
    motion.omega = 2.0 * std::numbers::pi / *said.period;
    said.stroke = motion.amplitude.cwiseAbs();
  }
  body.motion = motion;
}

std::string read_name(const io::Table& t) {
  const std::string name = t.text("name");
  if (!is_plain_name(name) || name == "fluid" || name == "total" || name == "walls") {
    t.fail("name", fmt::format("'{}' is no name of a body", name),
           "columns of records are called after it; fluid, total and walls are taken",
           "Use letters, digits, _ and -");
  }
  return name;
}

}  // namespace

solid::Network read_shape(const io::Table& body, double rest_length) {
  const io::Table shape = body.table("shape");
  const std::vector<std::string> kinds{"chain", "block", "rod", "sphere", "spheroid", "plate", "lammps"};
  const std::vector<std::string> given = shape.keys();
  if (given.size() != 1 || std::find(kinds.begin(), kinds.end(), given.front()) == kinds.end()) {
    body.fail("shape",
              given.size() == 1 ? fmt::format("'{}' is no shape", given.front())
                                : fmt::format("{} shapes", given.size()),
              fmt::format("a body has one of: {}", fmt::join(kinds, ", ")),
              "Write for example shape = { sphere = { radius = 4.5 } }");
  }
  if (shape.has("lammps")) return read_data_file(shape.table("lammps"));
  const double spacing = body.number("spacing", rest_length);
  engine::need_positive(body, "spacing", spacing);
  if (shape.has("chain")) {
    const io::Table t = shape.table("chain");
    const solid::Block chain{{1, 1, t.integer("nodes", 2, max_nodes)}, spacing};
    require_room(t, static_cast<double>(chain.nodes[2]));
    return solid::cubic_lattice(chain);
  }
  if (shape.has("block")) return read_block(shape.table("block"), spacing);
  if (shape.has("rod")) return read_rod(shape.table("rod"), spacing);
  if (shape.has("sphere")) return read_spheroid(shape.table("sphere"), true, spacing);
  if (shape.has("spheroid")) return read_spheroid(shape.table("spheroid"), false, spacing);
  return read_plate(shape.table("plate"), spacing);
}

CaseBody read_body(const io::Table& t, bool in_fluid, scene::Body& body) {
  CaseBody said{.period = {}, .table = t};
  body.name = read_name(t);
  const bool given = t.has("motion");
  double rest_length = 1.0;  // of a body without bonds: the fluid's spacing
  double bond_stiffness = 0.0;
  if (!given) {
    const double factor = engine::read_stiffness_factor(t);
    body.material = {bond::rescaled(engine::read_law(t), factor, 1.0),
                     factor * engine::read_angle_stiffness(t), keeps(t, "angles")};
    const bond::Derivation derived = engine::read_derivation(t, body.material.law);
    rest_length = derived.rest_length;
    bond_stiffness = derived.stiffness;
  }
  body.network = read_shape(t, rest_length);
  if (!given && !bond::domain(body.material.law).contains(body.network.spacing)) {
    t.fail("spacing", fmt::format("the body's spacing is {}", body.network.spacing),
           fmt::format("the bond law {} is not defined there", bond::name_of(body.material.law)),
           "Choose one near the law's rest length");
  }
  const bool has_own_angles = !body.network.angles.empty();  // out of a data file
  if (given || !body.material.has_angles()) body.network.angles = {};
  if (!given && body.material.has_angles() && !has_own_angles) solid::add_angles(body.network);
  const Eigen::VectorXd along = body.network.rest.col(2);
  if (t.has("axis")) body.axis = engine::read_axis(t);
  body.network.rest = scene::turned(body.network.rest, body.axis);
  body.network.vectors = scene::turned(body.network.vectors, body.axis);
  if (given) {
    read_given_motion(t, body, said);
  } else {
    read_elastic(t, along, bond_stiffness, body, said);
  }
  if (t.has("place")) body.place = engine::read_vector(t, "place");
  if (!(body.place.cwiseAbs().maxCoeff() <= farthest_place)) {
    t.fail("place", "the body stands too far away",
           "a number no longer tells places within a node's spacing apart there", "Put it into the box");
  }
  if (!t.has("coupling")) return said;
  if (!in_fluid) {
    t.fail("coupling", fmt::format("{} is coupled, and the scene has no fluid", body.name),
           "there is nothing to couple it to", "Add [fluid], or leave it out");
  }
  if (!t.has("place"))
    t.fail("place", "'place' is missing", "a body in a fluid stands somewhere", "Give its place in the box");
  body.coupling = engine::read_coupling(t);
  try {
    scene::coupled_nodes(body);
  } catch (const BadParameter& bad) {
    t.table("coupling").fail("nodes", bad.problem, bad.why, bad.suggestion);
  }
  return said;
}

}  // namespace veriflex::measures
