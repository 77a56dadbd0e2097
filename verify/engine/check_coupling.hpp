/// The look at a coupled scene before its first step.
#pragma once

#include "base/progress.hpp"
#include "io/document.hpp"
#include "scene/coupling_stability.hpp"

namespace veriflex::engine {

/// coupling_growth() of the scene. Beyond scene::growth_resolution above 1 the run is warned of, with the
/// growth, the node mass that would be stable, and what else helps; beyond scene::growth_refused it is
/// refused with an InputError at `node_mass`, unless coupling.force lets it run. `what` names the body.
double check_coupling(const fluid::Spec& fluid, const scene::Body& body, const scene::CouplingSpec& coupling,
                      const std::string& what, const Place& node_mass, Progress& progress);

}  // namespace veriflex::engine
