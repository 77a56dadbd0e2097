#include "scene/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "base/error.hpp"
#include "base/memory.hpp"

namespace veriflex::scene {

namespace {

std::string describe(const bond::AnyLaw& law) {
  std::string text = bond::name_of(law) + ":";
  for (const bond::NamedValue& p : bond::parameters_of(law)) text += fmt::format(" {} = {}", p.name, p.value);
  return text;
}

struct Size {
  double nodes, bonds, section;  // section: nodes in one, which is how far the Cholesky factor fills in
  std::string shape;
};

Size size_of(const solid::Block& block) {
  const auto [n, m, l] = block.nodes;
  return {static_cast<double>(block.node_count()), static_cast<double>(block.bond_count()),
          static_cast<double>(n) * static_cast<double>(m), fmt::format("{} x {} x {}", n, m, l)};
}

Size size_of(const solid::Rod& rod) {
  const double section = std::numbers::pi * (rod.radius + 0.5) * (rod.radius + 0.5);
  const double nodes = section * static_cast<double>(rod.sections);
  return {nodes, 3.0 * nodes, section,
          fmt::format("rod of radius {}, {} sections,", rod.radius, rod.sections)};
}

void plan_solid(const SolidSpec& spec, const Outline& scene, Plan& plan) {
  const Size size = std::visit([](const auto& shape) { return size_of(shape); }, spec.shape);
  const bool angles = spec.angle_stiffness != 0.0;
  const double angle_count = angles ? 15.0 * size.nodes : 0.0;
  const double network = size.nodes * 24.0 + size.bonds * 32.0 + angle_count * sizeof(solid::Angle);
  // Displacement, gradient, load, reaction; bond vectors and their gradients; for a static solution the
  // Hessian's triplets and entries and its factor, for a moving one the velocities.
  const double state = size.nodes * 4.0 * 24.0 + size.bonds * 48.0;
  const double factor = size.nodes * 9.0 * std::min(size.section, 4096.0) * 12.0;
  const double solver =
      scene.moves ? size.nodes * 24.0 : (size.bonds * 36.0 + angle_count * 144.0) * 32.0 + factor;
  const double available = available_memory_bytes();
  if (network + state + solver > available || size.nodes * 3.0 > 2147483647.0) {
    throw BadParameter(
        "solid.nodes", fmt::format("{} nodes are too many", size.shape),
        fmt::format("the solution would take about {:.3g} GB, {:.3g} GB are available; indices end at "
                    "715827882 nodes",
                    (network + state + solver) * 1e-9, available * 1e-9),
        "Use fewer nodes");
  }
  plan.built.push_back(
      {"solid", fmt::format("{} nodes, nearest-neighbour bonds ({})", size.shape, bond::name_of(*scene.law)),
       network + state});
  if (angles) {
    plan.built.push_back(
        {"angles",
         fmt::format("right and straight, each pair of bonds of a node once, k_a = {}", spec.angle_stiffness),
         0.0});
  } else {
    plan.left_out.push_back(
        {"angles", "k_a = 0: no angle list, no angle loop; bonds alone have no shear stiffness"});
  }
  plan.built.push_back({scene.moves ? "motion" : "statics", scene.method, solver});
  if (!scene.moves) plan.left_out.push_back({"velocities", "a static study needs none"});
  if (scene.is_free) {
    plan.left_out.push_back({"constraints", "the body is free: no pass over held or driven coordinates"});
  }
}

std::string describe_walls(const fluid::Spec& spec) {
  std::string closed;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (spec.walls[axis])
      closed += closed.empty() ? fmt::format("{}", "xyz"[axis]) : fmt::format(", {}", "xyz"[axis]);
  }
  return closed;
}

void plan_fluid(const fluid::Spec& spec, Plan& plan) {
  fluid::require_memory(spec);
  const auto [nx, ny, nz] = spec.grid.size;
  const bool moments = fluid::representation_of(spec) == fluid::Representation::Moments;
  plan.built.push_back({"fluid",
                        fmt::format("{} x {} x {} nodes, D3Q15 BGK {}, tau = {}, {} {}", nx, ny, nz,
                                    moments ? "in two copies" : "in place", spec.relaxation_time,
                                    row_of(fluid::storages, spec.storage).name,
                                    moments ? "density and momentum" : "populations"),
                        fluid::memory_bytes(spec)});
  if (moments) {
    plan.left_out.push_back({"populations",
                             "at tau = 1 a collision keeps density and momentum alone; where an observation "
                             "asks for populations they are made from the step before"});
  }
  const std::string closed = describe_walls(spec);
  if (closed.empty()) {
    plan.left_out.push_back({"walls", "the box is periodic: no list of cut links"});
  } else {
    plan.built.push_back({"walls", fmt::format("half-way bounce-back at both ends of {}", closed), 0.0});
  }
  if (spec.obstacle.empty()) {
    plan.left_out.push_back({"obstacle", "the case names none"});
  } else {
    plan.built.push_back({"obstacle",
                          fmt::format("{} nodes, half-way bounce-back around them", spec.obstacle.size()),
                          static_cast<double>(spec.grid.count()) / 8.0});
  }
  if (spec.body_force.isZero(0.0)) {
    plan.left_out.push_back({"body force", "zero: the sweep is compiled without it"});
  } else {
    plan.built.push_back(
        {"body force", spec.scheme == fluid::Scheme::FirstOrder ? "first order" : "second order (Guo)", 0.0});
  }
  plan.left_out.push_back(
      {"fields", "density, velocity and stress exist only where an observation asks for them"});
}

std::string words_of(const CouplingSpec& coupling, const std::string& exchange) {
  const std::string nodes = coupling.coupled == Coupled::Boundary ? "boundary nodes"
                            : coupling.coupled == Coupled::Ring   ? "the surface's nodes without end caps"
                            : coupling.coupled == Coupled::All    ? "all nodes"
                                                                  : "listed nodes";
  const std::string delta =
      coupling::visit(coupling.delta, [](auto kernel) { return std::string(kernel.name); });
  if (!exchange.empty()) return fmt::format("{}, {} delta", exchange, delta);
  return fmt::format("{}, {} delta, force {}", nodes, delta,
                     coupling.subcycled ? "following the sub-steps" : "frozen over the sub-steps");
}

}  // namespace

Plan plan(const Outline& scene) {
  Plan plan;
  if (scene.law) plan.built.push_back({"bond law", describe(*scene.law), 0.0});
  if (scene.solid) {
    plan_solid(*scene.solid, scene, plan);
  } else {
    plan.left_out.push_back({"solid", "the case names none"});
  }
  if (scene.fluid) {
    plan_fluid(*scene.fluid, plan);
  } else {
    plan.left_out.push_back({"fluid", "the case names none"});
  }
  if (scene.coupling) {
    plan.built.push_back({"coupling", words_of(*scene.coupling, scene.exchange), 0.0});
  } else {
    plan.left_out.push_back({"coupling", "no body meets a fluid"});
  }
  return plan;
}

namespace {

double memory_of(const Body& body) {
  const auto nodes = static_cast<double>(body.network.node_count());
  const auto bonds = static_cast<double>(body.network.bonds.size());
  const double network =
      nodes * 24.0 + bonds * 32.0 + static_cast<double>(body.network.angles.size()) * sizeof(solid::Angle);
  return body.motion ? network : network + nodes * 4.0 * 24.0 + bonds * 48.0;
}

void plan_body(const Body& body, bool in_fluid, Plan& plan) {
  std::string how = "rigid, its motion is given";
  if (!body.motion) {
    how = fmt::format("{}; leap-frog, {}", describe(body.material.law),
                      body.substeps.safety > 0.0 ? std::string("sub-steps as the stiffest bond needs")
                                                 : fmt::format("{} sub-steps", body.substeps.count));
  }
  plan.built.push_back({"body " + body.name,
                        fmt::format("{} nodes, {} bonds, {} angles; {}", body.network.node_count(),
                                    body.network.bonds.size(), body.network.angles.size(), how),
                        memory_of(body)});
  if (in_fluid && body.coupling) {
    plan.built.push_back({"coupling of " + body.name, words_of(*body.coupling, ""), 0.0});
  } else {
    plan.left_out.push_back({"coupling of " + body.name, "it meets no fluid"});
  }
  if (body.motion) return;
  if (body.network.angles.empty())
    plan.left_out.push_back({"angles of " + body.name, "k_a = 0: no list, no loop"});
  const solid::Conditions& conditions = body.conditions;
  if (conditions.fixed.size() == 0 && !conditions.drive) {
    plan.left_out.push_back({"constraints of " + body.name, "no pass over held or driven coordinates"});
  }
  if (conditions.load.size() == 0) plan.left_out.push_back({"loads of " + body.name, "no pass over them"});
}

}  // namespace

Plan plan_scene(const Scene& scene) {
  Plan plan;
  if (scene.fluid) {
    plan_fluid(*scene.fluid, plan);
    if (const double bytes = fluid::start_bytes(*scene.fluid); scene.initial_flow && bytes > 0.0) {
      plan.built.push_back({"initial flow", "its populations, until the first step", bytes});
    }
  } else {
    plan.left_out.push_back({"fluid", "the case names none"});
  }
  for (const Body& body : scene.bodies) plan_body(body, scene.fluid.has_value(), plan);
  if (scene.bodies.empty()) plan.left_out.push_back({"bodies", "the case names none"});
  return plan;
}

solid::Network build(const SolidSpec& spec) {
  solid::Network network = std::holds_alternative<solid::Block>(spec.shape)
                               ? solid::cubic_lattice(std::get<solid::Block>(spec.shape))
                               : solid::rod_lattice(std::get<solid::Rod>(spec.shape));
  if (spec.angle_stiffness != 0.0) solid::add_angles(network);
  return network;
}

}  // namespace veriflex::scene
