/// How far small states of a scene may grow before they decay: the largest amplification of energies by some
/// steps, over all states.                                                     [trefethen-embree-2005, Ch. 14]
///
/// The spectrum says what comes of a state in the long run, this what it may become meanwhile: a step is no
/// normal operator where body and fluid exchange momentum, and a scene whose spectrum is stable may carry a
/// kick to a multiple of its size first. The steps are the simulation's own, made into a sparse matrix.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scene/scene.hpp"

namespace veriflex::scene {

/// The largest |G^n x| over |x| = 1 for each number of steps n, lengths being roots of energies (see
/// SimulatedStep), without known invariants  [1]. Throws BadParameter ("fluid.nodes") beyond 30000 numbers in
/// a state, and as exact_growth() does.
std::vector<double> transient_growth(const Scene& scene, std::span<const std::int64_t> steps);

}  // namespace veriflex::scene
