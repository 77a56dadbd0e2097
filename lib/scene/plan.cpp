#include "scene/plan.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <numbers>

#include "base/error.hpp"

namespace veriflex::scene {

namespace {

double free_memory_bytes() {
  return static_cast<double>(sysconf(_SC_AVPHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

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

void plan_solid(const SolidSpec& spec, const Scene& scene, Plan& plan) {
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
  const double available = free_memory_bytes();
  if (network + state + solver > available || size.nodes * 3.0 > 2147483647.0) {
    throw BadParameter(
        "nodes", fmt::format("{} nodes are too many", size.shape),
        fmt::format("the solution would take about {:.3g} GB, {:.3g} GB are free; indices end at "
                    "715827882 nodes",
                    (network + state + solver) * 1e-9, available * 1e-9),
        "Use fewer nodes");
  }
  plan.built.push_back(
      {"solid", fmt::format("{} nodes, nearest-neighbour bonds ({})", size.shape, bond::name_of(scene.law)),
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

}  // namespace

Plan plan(const Scene& scene) {
  Plan plan;
  plan.built.push_back({"bond law", describe(scene.law), 0.0});
  if (scene.solid) {
    plan_solid(*scene.solid, scene, plan);
  } else {
    plan.left_out.push_back({"solid", "the case names none"});
  }
  plan.left_out.push_back({"fluid", "the case names none"});
  plan.left_out.push_back({"coupling", "needs a fluid and a solid"});
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
