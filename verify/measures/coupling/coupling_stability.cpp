#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <optional>

#include "bond/derive.hpp"
#include "engine/check_place.hpp"
#include "engine/read_scene.hpp"
#include "measures/coupling/kicked_run.hpp"
#include "measures/drivers.hpp"
#include "scene/coupling_stability.hpp"
#include "scene/markers.hpp"

// The node mass at which the coupling of a rod to the fluid becomes unstable: that of the linearised map,
// which leaves out the fluid's own motion, against that of real runs, which are kicked by minute forces.

namespace veriflex::measures {

namespace {

using observe::Observations;

struct CouplingStability {
  fluid::Spec fluid;
  solid::Rod rod;
  solid::Material material;  // with the factor of its stiffnesses
  scene::CouplingSpec coupling;
  int substeps;
  std::optional<double> node_mass;  // at which a run is made that may grow or not  [M]
  std::int64_t steps;
  double resolution;  // of the boundary, relative
};

Observations coupling_stability_observations(const CouplingStability& study) {
  Observations all;
  all.metrics = {
      {"coupled", {}, "1", "number of coupled nodes"},
      {"predicted",
       {},
       "M",
       "least stable node mass of the map, where the fluid keeps its momentum in place"},
      {"forgetful", {}, "M", "the same, where the fluid loses its momentum in each step"},
      {"measured", {}, "M", "middle of the largest mass that grew in runs and the smallest that did not"},
      {"ratio", {}, "1", "measured over predicted"},
      {"growth",
       {},
       "1",
       "of the map per step at the measured mass: what the fluid's motion still stabilised"}};
  if (study.node_mass) {
    const std::string at = fmt::format("at node mass {}", *study.node_mass);
    all.metrics.push_back({"grew", {}, "1", "1: the run grew, " + at});
    all.metrics.push_back({"growth_at", {}, "1", "of the map per step, " + at});
  }
  return all;
}

scene::Body body_of(const CouplingStability& study, double node_mass) {
  solid::Network network = solid::rod_lattice(study.rod);
  if (study.material.angle_stiffness != 0.0) solid::add_angles(network);
  solid::Conditions conditions;
  conditions.node_mass = node_mass;
  conditions.load = kick_of(network.node_count(), 1);
  Vec3 place;
  for (int axis = 0; axis < 3; ++axis) {
    const double middle = 0.5 * (network.rest.col(axis).minCoeff() + network.rest.col(axis).maxCoeff());
    place[axis] =
        std::floor(0.5 * static_cast<double>(study.fluid.grid.size[static_cast<std::size_t>(axis)]) - middle);
  }
  return {.material = study.material,
          .network = std::move(network),
          .conditions = conditions,
          .substeps = {study.substeps, 0.0},
          .place = place,
          .coupling = study.coupling};
}

void run_coupling_stability(const CouplingStability& study, Observations& seen, Progress& progress,
                            engine::Cost& cost) {
  constexpr double accuracy = 1e-3;
  const auto grows = [&](double mass) {
    return run_kicked({.fluid = study.fluid, .bodies = {body_of(study, mass)}}, study.steps).grows;
  };
  const auto growth_of_map = [&](double mass) {
    return scene::coupling_growth(study.fluid, body_of(study, mass)).factor;
  };
  progress.show("boundary", 0, 2);
  const scene::Body body = body_of(study, 1.0);
  const double predicted = scene::critical_node_mass(study.fluid, body, accuracy);
  seen.set("coupled", static_cast<double>(scene::coupled_nodes(body).size()));
  seen.set("predicted", predicted);
  seen.set("forgetful", scene::critical_node_mass(study.fluid, body, accuracy, scene::FluidMemory::Forgets));
  cost.finish("map");
  progress.show("boundary", 1, 2);
  const double measured = least_stable(grows, predicted, study.resolution, "kicked runs");
  seen.set("measured", measured);
  seen.set("ratio", measured / predicted);
  seen.set("growth", growth_of_map(measured));
  if (study.node_mass) {
    seen.set("grew", grows(*study.node_mass) ? 1.0 : 0.0);
    seen.set("growth_at", growth_of_map(*study.node_mass));
  }
  cost.finish("runs");
}

/// Refuses a rod that has no room in its box.
void check(const CouplingStability& study, const Place& box) {
  const double across = 2.0 * std::floor(study.rod.radius) * study.rod.spacing;
  const double along = static_cast<double>(study.rod.sections - 1) * study.rod.spacing;
  engine::check_images(study.fluid, study.coupling.delta, {across, across, along}, Vec3::Zero(), "the rod",
                       box);
  engine::check_supports(study.fluid, study.coupling.delta, scene::markers_at_rest(body_of(study, 1.0)),
                         Vec3::Zero(), "the rod", box);
}

/// All stiffnesses of the body times `stiffness` of the table.
solid::Material read_material(const io::Table& t, const bond::AnyLaw& law, double angle_stiffness) {
  const double factor = engine::read_stiffness_factor(t);
  return {bond::rescaled(law, factor, 1.0), angle_stiffness * factor};
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
  const CouplingStability study{.fluid = engine::read_fluid(top),
                                .rod = *rod,
                                .material = read_material(t, law, solid.angle_stiffness),
                                .coupling = engine::read_coupling(top),
                                .substeps = static_cast<int>(t.integer("substeps", 1, 1000)),
                                .node_mass = t.number_if("node_mass"),
                                .steps = t.integer("steps", shortest_kicked_run, 10'000'000),
                                .resolution = t.number("resolution")};
  if (study.node_mass) engine::need_positive(t, "node_mass", *study.node_mass);
  if (!(study.resolution > 1e-6))
    t.fail("resolution", "'resolution' is too fine", "each halving is a run", "Use 0.005");
  scene::Plan plan = engine::read_plan(top, {.law = law,
                                             .solid = solid,
                                             .method = "leap-frog, free, kicked by minute forces",
                                             .by = {parts::Kind::LeapFrog, parts::Kind::Loads},
                                             .fluid = study.fluid,
                                             .coupling = study.coupling});
  check(study, top.table("fluid").place("nodes"));
  return {.plan = std::move(plan),
          .declares = coupling_stability_observations(study),
          .run = std::bind_front(run_coupling_stability, study)};
}

}  // namespace veriflex::measures
