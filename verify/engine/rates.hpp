/// How fast this machine is, for estimates of what a run will take. Measured once, in a second or two, and
/// kept.
#pragma once

#include <array>

#include "scene/plan.hpp"

namespace veriflex::engine {

/// Per second, with the threads they were measured with.
struct Rates {
  /// Lattice nodes updated, by Representation (populations, moments), Storage (double, float) and size of the
  /// box: one that stays in the caches, and one that does not.
  std::array<std::array<std::array<double, 2>, 2>, 2> nodes{};
  /// Of populations alone, by Storage, in a box that no cache holds: several steps at once.
  std::array<double, 2> at_once{};
  double bonds = 0.0, angles = 0.0;  // gradients
  double markers = 0.0;              // coupled, all that is done for one included
  double checked_nodes = 0.0;        // of a body whose coupling is looked at before the first step
};

/// Of this machine with so many threads, from a file in $XDG_CACHE_HOME/veriflex or .cache/veriflex of the
/// home directory; measured where there is none, which is kept where it can be written.
Rates rates(int threads);

/// What that work will take  [s].
double seconds_of(const scene::ExpectedWork& work, const Rates& rates);

}  // namespace veriflex::engine
