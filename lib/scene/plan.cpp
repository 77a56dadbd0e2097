#include "scene/plan.hpp"

#include <fmt/format.h>
#include <unistd.h>

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

void plan_solid(const SolidSpec& spec, const bond::AnyLaw& law, Plan& plan) {
  const auto [n, m, l] = spec.block.nodes;
  const auto nodes = static_cast<double>(spec.block.node_count());
  const auto bonds = static_cast<double>(spec.block.bond_count());
  // Positions, gradient, load and reaction; per bond two indices and, in the Hessian and its triplets, 36 +
  // 36 entries; the Cholesky factor fills in with the section's width.
  const double network = nodes * 24.0 + bonds * 8.0;
  const double fill = nodes * 9.0 * static_cast<double>(std::min(n * m, std::int64_t{4096})) * 12.0;
  const double statics = nodes * 3.0 * 24.0 + bonds * (36.0 * 16.0 + 36.0 * 16.0) + fill;
  const double available = free_memory_bytes();
  if (network + statics > available || nodes * 3.0 > 2147483647.0) {
    throw BadParameter(
        "nodes", fmt::format("{} x {} x {} nodes are too many", n, m, l),
        fmt::format("a static solution would take about {:.3g} GB, {:.3g} GB are free; indices end at "
                    "715827882 nodes",
                    (network + statics) * 1e-9, available * 1e-9),
        "Use fewer nodes");
  }
  plan.built.push_back({"solid",
                        fmt::format("{} x {} x {} nodes, {} nearest-neighbour bonds ({}), spacing {}", n, m,
                                    l, spec.block.bond_count(), bond::name_of(law), spec.block.spacing),
                        network});
  plan.built.push_back(
      {"statics",
       fmt::format("Newton with line search, sparse Cholesky; ends held axially, lateral displacements {}",
                   spec.lateral == Lateral::held ? "held (exact: C12 = 0)" : "free"),
       statics});
  plan.left_out.push_back({"angles", "not implemented yet: bonds alone have no shear stiffness"});
  plan.left_out.push_back({"velocities", "a static study needs none"});
}

}  // namespace

Plan plan(const Scene& scene) {
  Plan plan;
  plan.built.push_back({"bond law", describe(scene.law), 0.0});
  if (scene.solid) {
    plan_solid(*scene.solid, scene.law, plan);
  } else {
    plan.left_out.push_back({"solid", "the case names none"});
  }
  plan.left_out.push_back({"fluid", "the case names none"});
  plan.left_out.push_back({"coupling", "needs a fluid and a solid"});
  return plan;
}

}  // namespace veriflex::scene
