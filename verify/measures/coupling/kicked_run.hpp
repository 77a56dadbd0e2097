/// Whether a scene is stable, by running it: bodies are kicked by minute forces without pattern, and the
/// change of their velocities from step to step is followed. Changes, because what is kicked may drift for
/// ever.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "scene/scene.hpp"

namespace veriflex::measures {

/// Steps of the shortest run that tells growth from a swing.
constexpr std::int64_t shortest_kicked_run = 160;

/// Forces on so many nodes without sum, small enough that everything stays linear  [M L T^-2].
Positions kick_of(Eigen::Index nodes, std::uint64_t seed);

struct KickedRun {
  bool grows;     // the changes do, by more than a factor of 2 in the second half, and are no rounding
  double growth;  // factor a step over that half; says something of a scene that grows
};

/// Of a scene whose bodies are loaded by kick_of(). A run that breaks off grew.
KickedRun run_kicked(const scene::Scene& scene, std::int64_t steps);

/// The node mass below which runs grow, by bisection to a relative resolution from where it is predicted.
/// Throws NumericalFailure, which names `what`, when it is not within a factor of ten of that.
double least_stable(const std::function<bool(double mass)>& grows_at, double predicted, double resolution,
                    const std::string& what);

}  // namespace veriflex::measures
