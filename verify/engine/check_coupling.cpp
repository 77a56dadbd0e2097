#include "engine/check_coupling.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/reduce.hpp"

namespace veriflex::engine {

namespace {

constexpr double accuracy = 0.01;  // of the mass that is suggested

std::string remedy(const fluid::Spec& fluid, const scene::Body& body) {
  try {
    const double answered = scene::answered_slip(fluid, body);
    if (answered >= 2.0) {
      return fmt::format(
          "No node mass is stable with it: V S = {:.4g}, the marker volume times the largest eigenvalue of "
          "interpolate and spread, must stay below 2. Use a marker volume below {:.3g} or couple fewer nodes",
          answered, 2.0 * body.coupling->marker_volume / answered);
    }
    return fmt::format(
        "Use a node mass above {:.3g} (it is {:.3g}), softer bonds, subcycled = true with more sub-steps, or "
        "couple fewer nodes",
        scene::critical_node_mass(fluid, body, accuracy), body.conditions.node_mass);
  } catch (const NumericalFailure& failure) {
    return fmt::format("No stable node mass was found ({}). Use softer bonds or couple fewer nodes",
                       failure.what());
  }
}

/// A coupling that grows by `factor` a step: a warning where that is allowed or may be stabilised, else an
/// error at `place`.
void report_unstable(double factor, const std::string& whose, const std::string& what_helps, bool is_allowed,
                     const std::string& table, const Place& place, Progress& progress) {
  const std::string problem = fmt::format(
      "the coupling of {} is unstable: perturbations grow by {:.4g} a step, {:.2g} times in a hundred steps",
      whose, factor, std::pow(factor, 100.0));
  if (factor <= scene::growth_refused || is_allowed) {
    progress.warn(fmt::format("{} (without the fluid's own motion, which may just stabilise it). {}", problem,
                              what_helps));
    return;
  }
  throw InputError(
      place, problem,
      fmt::format("no scene that grew by more than {} without the fluid's own motion was stabilised by it",
                  scene::growth_refused),
      fmt::format("{}. To see it break, set allow_unstable = true in {}", what_helps, table));
}

}  // namespace

void check_coupling(const fluid::Spec& fluid, const scene::Body& body, const std::string& what,
                    const Place& node_mass, double& growth, Progress& progress, Unstable unstable) {
  const scene::Growth found = scene::coupling_growth(fluid, body);
  growth = worse(growth, found.factor);
  if (!found.grows()) return;
  report_unstable(found.factor, what + " to the fluid", remedy(fluid, body),
                  body.coupling->allow_unstable || unstable == Unstable::Warned, "[coupling]", node_mass,
                  progress);
}

void check_common_coupling(const fluid::Spec& fluid, std::span<const scene::Body> bodies, const Place& place,
                           double& growth, Progress& progress) {
  const scene::Growth found = scene::coupling_growth(fluid, bodies);
  const bool is_worse = found.factor > growth + scene::growth_resolution;
  growth = worse(growth, found.factor);
  if (!found.grows() || !is_worse) return;
  std::vector<std::string> names;
  for (const scene::Body& body : bodies) names.push_back(body.name);
  const double answered = scene::answered_slip(fluid, bodies);
  const std::string what_helps =
      answered >= 2.0 ? fmt::format(
                            "No node mass is stable with it: V S = {:.4g} of all of them together must "
                            "stay below 2. Use smaller marker volumes, or move them apart",
                            answered)
                      : "Use more node mass, or move them apart";
  const bool is_allowed = std::any_of(bodies.begin(), bodies.end(),
                                      [](const scene::Body& body) { return body.coupling->allow_unstable; });
  report_unstable(found.factor,
                  fmt::format("{} to the fluid, whose nodes they share,", fmt::join(names, ", ")), what_helps,
                  is_allowed, "a [body.coupling]", place, progress);
}

}  // namespace veriflex::engine
