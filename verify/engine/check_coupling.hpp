/// The look at a coupled scene before its first step.
#pragma once

#include <span>

#include "base/progress.hpp"
#include "io/document.hpp"
#include "scene/coupling_stability.hpp"

namespace veriflex::engine {

/// How a scene whose exchange is unstable is met.
enum class Unstable {
  Refused,  // beyond scene::growth_refused
  Warned    // always: that it breaks is an answer
};

/// coupling_growth() of the scene. Where something grows there is a warning with the growth, the node mass
/// that would be stable, and what else helps; beyond scene::growth_refused the scene is refused with an
/// InputError at `node_mass`, unless coupling.allow_unstable lets it run. `what` names the body. `growth`
/// becomes the larger of itself and what was found, before anything is refused.
void check_coupling(const fluid::Spec& fluid, const scene::Body& body, const std::string& what,
                    const Place& node_mass, double& growth, Progress& progress,
                    Unstable unstable = Unstable::Refused);

/// The same of bodies that share nodes of the fluid, which may grow together where each of them alone does
/// not. What is to be said of one of them alone is left to check_coupling().
void check_common_coupling(const fluid::Spec& fluid, std::span<const scene::Body> bodies, const Place& place,
                           double& growth, Progress& progress);

}  // namespace veriflex::engine
