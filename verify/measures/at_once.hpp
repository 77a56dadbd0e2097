/// What a study of several fluids needs of the machine.
#pragma once

#include <functional>
#include <vector>

#include "engine/read_scene.hpp"

namespace veriflex::measures {

/// What a run has beside its populations  [bytes].
using Beside = std::function<double(const fluid::Spec&)>;

/// The plan of a study whose runs are spread over the threads: it shows the run that needs most, with the
/// memory of as many of the largest as there are threads. `kept` is what outlives its run  [bytes]. A study
/// beyond the memory is reported at `nodes` of [fluid] or, where boxes are the driver's own, at [fluid].
scene::Plan plan_at_once(const io::Table& top, const std::vector<fluid::Spec>& runs,
                         const Beside& beside = {}, double kept = 0.0);

/// The plan of a study that makes one run after the other.
scene::Plan plan_in_turn(const io::Table& top, const std::vector<fluid::Spec>& runs, double kept = 0.0);

}  // namespace veriflex::measures
