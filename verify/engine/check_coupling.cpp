#include "engine/check_coupling.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/error.hpp"

namespace veriflex::engine {

namespace {

constexpr double accuracy = 0.01;  // of the mass that is suggested

std::string remedy(const scene::Body& body, double mass) {
  return fmt::format(
      "Use a node mass above {:.3g} (it is {:.3g}), softer bonds, live = true with more sub-steps, or couple "
      "fewer nodes",
      mass, body.conditions.node_mass);
}

}  // namespace

double check_coupling(const fluid::Spec& fluid, const scene::Body& body, const scene::CouplingSpec& coupling,
                      const std::string& what, const Place& node_mass, Progress& progress) {
  const double growth = scene::coupling_growth(fluid, body, coupling);
  if (growth <= 1.0 + scene::growth_resolution) return growth;
  const std::string problem =
      fmt::format("the exchange of {} with the fluid grows by {:.4g} a step, {:.2g} times in a hundred steps",
                  what, growth, std::pow(growth, 100.0));
  const std::string what_helps = remedy(body, scene::critical_node_mass(fluid, body, coupling, accuracy));
  if (growth <= scene::growth_refused || coupling.force) {
    progress.warn(
        fmt::format("{} (without the fluid's own motion, which may just hold it). {}", problem, what_helps));
    return growth;
  }
  throw InputError(
      node_mass, problem,
      fmt::format("no scene that grew by more than {} without the fluid's own motion was held by it",
                  scene::growth_refused),
      what_helps + ". To see it break, set force = true in [coupling]");
}

}  // namespace veriflex::engine
