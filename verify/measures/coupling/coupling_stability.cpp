#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.hpp"
#include "base/reduce.hpp"
#include "bond/derive.hpp"
#include "engine/check_place.hpp"
#include "engine/read_scene.hpp"
#include "measures/coupling/kicked_run.hpp"
#include "measures/drivers.hpp"
#include "measures/for_all.hpp"
#include "scene/coupling_stability.hpp"
#include "scene/markers.hpp"

// The node mass at which the coupling of a rod to the fluid becomes unstable: that of the linearised map,
// which leaves out the fluid's own motion, against that of real runs, which are kicked by minute forces.

namespace veriflex::measures {

namespace {

using observe::Observations;
using observe::Record;

/// A way of coupling whose boundary is searched.
struct Point {
  std::string name;
  scene::Coupled coupled;
  int substeps;
  bool subcycled;
  double stiffness;                 // factor of all stiffnesses
  double relaxation_time;           // of the fluid  [T]
  std::optional<double> node_mass;  // at which a run is made that may grow or not  [M]
};

struct CouplingStability {
  fluid::Spec fluid;
  solid::Rod rod;
  solid::Material material;
  std::vector<Point> points;
  std::int64_t steps;
  double resolution;  // of a boundary, relative
};

struct Boundary {
  double predicted;  // by the map  [M]
  double forgetful;  // by the map of a fluid that loses in each step what it was given in the one before  [M]
  double measured;   // middle of the largest mass that grew and the smallest that did not  [M]
  double growth;     // of the map at the measured mass  [1]
  double markers;    // coupled nodes
  bool grew = false;     // at Point::node_mass
  double growth_at = 0;  // of the map there
};

struct Scene {
  fluid::Spec fluid;
  scene::Body body;
};

Scene scene_of(const CouplingStability& study, const Point& point, double node_mass) {
  solid::Network network = solid::rod_lattice(study.rod);
  solid::Material material = study.material;
  material.law = bond::rescaled(material.law, point.stiffness, 1.0);
  material.angle_stiffness *= point.stiffness;
  if (material.angle_stiffness != 0.0) solid::add_angles(network);
  solid::Conditions conditions;
  conditions.node_mass = node_mass;
  conditions.load = kick_of(network.node_count(), 1);
  fluid::Spec fluid = study.fluid;
  fluid.relaxation_time = point.relaxation_time;
  Vec3 place;
  for (int axis = 0; axis < 3; ++axis) {
    const double middle = 0.5 * (network.rest.col(axis).minCoeff() + network.rest.col(axis).maxCoeff());
    place[axis] =
        std::floor(0.5 * static_cast<double>(fluid.grid.size[static_cast<std::size_t>(axis)]) - middle);
  }
  return {fluid,
          {.material = material,
           .network = std::move(network),
           .conditions = conditions,
           .substeps = {point.substeps, 0.0},
           .place = place,
           .coupling = scene::CouplingSpec{.coupled = point.coupled, .subcycled = point.subcycled}}};
}

bool grows(const CouplingStability& study, const Scene& scene) {
  return run_kicked({.fluid = scene.fluid, .bodies = {scene.body}}, study.steps).grows;
}

double measured_mass(const CouplingStability& study, const Point& point, double predicted) {
  return least_stable([&](double mass) { return grows(study, scene_of(study, point, mass)); }, predicted,
                      study.resolution, "point " + point.name);
}

Boundary boundary_of(const CouplingStability& study, const Point& point) {
  constexpr double accuracy = 1e-3;
  const Scene scene = scene_of(study, point, 1.0);
  Boundary found{};
  found.predicted = scene::critical_node_mass(scene.fluid, scene.body, accuracy);
  found.forgetful = scene::critical_node_mass(scene.fluid, scene.body, accuracy, scene::FluidMemory::Forgets);
  found.measured = measured_mass(study, point, found.predicted);
  const Scene at = scene_of(study, point, found.measured);
  found.growth = scene::coupling_growth(at.fluid, at.body).factor;
  found.markers = static_cast<double>(scene::coupled_nodes(scene.body).size());
  if (point.node_mass) {
    const Scene asked = scene_of(study, point, *point.node_mass);
    found.grew = grows(study, asked);
    found.growth_at = scene::coupling_growth(asked.fluid, asked.body).factor;
  }
  return found;
}

void run(const CouplingStability& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  std::vector<std::optional<Boundary>> found(study.points.size());
  std::exception_ptr broken;
  try {
    for_all(found.size(), "boundaries", progress,
            [&](std::size_t i) { found[i] = boundary_of(study, study.points[i]); });
  } catch (const NumericalFailure&) {
    broken = std::current_exception();
  }
  cost.finish("runs");

  Record record{"coupling_boundary",
                "Least stable node mass: the linearised exchange against runs",
                {{"point", "", "1", "number of the point", {}},
                 {"coupled", "", "1", "number of coupled nodes", {}},
                 {"substeps", "n", "1", "solid steps per fluid step", {}},
                 {"subcycled", "", "1", "1: F_int follows the sub-steps, 0: frozen", {}},
                 {"stiffness", "", "1", "factor of all stiffnesses", {}},
                 {"relaxation_time", "tau", "T", "of the fluid", {}},
                 {"predicted", "m", "M", "the map, the fluid keeps its momentum in place", {}},
                 {"forgetful", "m", "M", "the map, the fluid loses its momentum in each step", {}},
                 {"measured", "m", "M", "middle of the last mass that grew and the first that did not", {}},
                 {"ratio", "", "1", "measured over predicted", {}},
                 {"growth", "", "1", "of the map at the measured mass, per step", {}}}};
  double smallest = INFINITY, largest = 0.0, growth = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Point& p = study.points[i];
    if (!found[i]) continue;
    const Boundary& b = *found[i];
    const double ratio = b.measured / b.predicted;
    record.append({static_cast<double>(i), b.markers, static_cast<double>(p.substeps),
                   p.subcycled ? 1.0 : 0.0, p.stiffness, p.relaxation_time, b.predicted, b.forgetful,
                   b.measured, ratio, b.growth});
    smallest = lesser(smallest, ratio);
    largest = worse(largest, ratio);
    growth = worse(growth, b.growth);
    seen.metrics.push_back({"predicted_" + p.name, b.predicted, "M", "least stable node mass of the map"});
    seen.metrics.push_back({"measured_" + p.name, b.measured, "M", "least stable node mass of the runs"});
    seen.metrics.push_back({"ratio_" + p.name, ratio, "1", "measured over predicted"});
    if (p.node_mass) {
      const std::string at = fmt::format("at node mass {}", *p.node_mass);
      seen.metrics.push_back({"grew_" + p.name, b.grew ? 1.0 : 0.0, "1", "1: the run grew, " + at});
      seen.metrics.push_back({"growth_" + p.name, b.growth_at, "1", "of the map per step, " + at});
    }
  }
  seen.records.push_back(record);
  if (broken) std::rethrow_exception(broken);
  seen.metrics.push_back({"min_ratio", smallest, "1", "smallest measured over predicted"});
  seen.metrics.push_back({"max_ratio", largest, "1", "largest measured over predicted"});
  seen.metrics.push_back(
      {"growth_at_boundary", growth, "1",
       "largest growth of the map at a measured boundary: what the fluid's motion still stabilised"});
}

/// Refuses a rod that has no room in its box.
void check(const CouplingStability& study, const Place& box) {
  const double across = 2.0 * std::floor(study.rod.radius) * study.rod.spacing;
  const double along = static_cast<double>(study.rod.sections - 1) * study.rod.spacing;
  for (const Point& point : study.points) {
    engine::check_images(study.fluid, coupling::Delta::Cosine, {across, across, along}, Vec3::Zero(),
                         "the rod", box);
    const Scene scene = scene_of(study, point, 1.0);
    engine::check_supports(study.fluid, scene.body.coupling->delta, scene::markers_at_rest(scene.body),
                           Vec3::Zero(), "the rod", box);
  }
}

Point read_point(const io::Table& t, double relaxation_time) {
  const std::string nodes = t.choice("nodes", {"boundary", "ring", "all"});
  Point point{.name = t.text("name"),
              .coupled = nodes == "boundary" ? scene::Coupled::Boundary
                         : nodes == "ring"   ? scene::Coupled::Ring
                                             : scene::Coupled::All,
              .substeps = static_cast<int>(t.integer("substeps", 1, 1000)),
              .subcycled = t.flag("subcycled", false),
              .stiffness = t.number("stiffness", 1.0),
              .relaxation_time = t.has("relaxation_time") || t.has("viscosity")
                                     ? engine::read_relaxation_time(t)
                                     : relaxation_time,
              .node_mass = t.number_if("node_mass")};
  if (!(point.stiffness >= 1e-6) || point.stiffness > 1e6)
    t.fail("stiffness", fmt::format("'stiffness' is {}", point.stiffness), "it lies between 1e-6 and 1e6",
           "1 is the body's own");
  if (point.node_mass) engine::need_positive(t, "node_mass", *point.node_mass);
  return point;
}

}  // namespace

engine::Study read_coupling_stability(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const bond::Derivation derivation = engine::read_derivation(top, law);
  const scene::SolidSpec solid = engine::read_solid(top, law, derivation.rest_length);
  const auto* rod = std::get_if<solid::Rod>(&solid.shape);
  if (rod == nullptr) {
    top.table("solid").fail("shape", "the body is no rod", "'ring' means the surface without end caps",
                            "Use shape = \"rod\"");
  }
  const io::Table t = top.table("coupling_stability");
  CouplingStability study{.fluid = engine::read_fluid(top),
                          .rod = *rod,
                          .material = {law, solid.angle_stiffness},
                          .points = {},
                          .steps = t.integer("steps", shortest_kicked_run, 10'000'000),
                          .resolution = t.number("resolution")};
  if (!(study.resolution > 1e-6))
    t.fail("resolution", "'resolution' is too fine", "each halving is a run", "Use 0.005");
  std::vector<std::string> measures{"min_ratio",
                                    "max_ratio",
                                    "growth_at_boundary",
                                    "coupling_boundary.measured",
                                    "coupling_boundary.predicted",
                                    "coupling_boundary.ratio"};
  for (const io::Table& entry : t.tables("point")) {
    const Point point = read_point(entry, study.fluid.relaxation_time);
    for (const Point& before : study.points) {
      if (before.name == point.name) {
        entry.fail("name", fmt::format("two points are called '{}'", point.name),
                   "their metrics could not be told apart", "Give each a name of its own");
      }
    }
    study.points.push_back(point);
    for (const char* what : {"predicted_", "measured_", "ratio_"}) measures.push_back(what + point.name);
    if (!point.node_mass) continue;
    for (const char* what : {"grew_", "growth_"}) measures.push_back(what + point.name);
  }
  if (study.points.empty())
    t.fail("point", "no point is given", "each is a boundary to find", "Add a [[coupling_stability.point]]");
  scene::Plan plan = engine::read_plan(top, {.law = law,
                                             .solid = solid,
                                             .method = "leap-frog, free, kicked by minute forces",
                                             .by = {parts::Kind::LeapFrog, parts::Kind::Loads},
                                             .fluid = study.fluid,
                                             .coupling = scene::CouplingSpec{},
                                             .exchange = "nodes, force and sub-steps as each point says"});
  check(study, top.table("fluid").place("nodes"));
  return {.plan = std::move(plan),
          .measures = measures,
          .run = [study](Observations& seen, Progress& progress, engine::Cost& cost) {
            run(study, seen, progress, cost);
          }};
}

}  // namespace veriflex::measures
