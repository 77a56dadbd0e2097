/// How fast this machine is, for estimates of what a run will take. Measured once, in a second or two, and
/// kept.
#pragma once

#include <array>
#include <optional>

#include "scene/plan.hpp"

namespace veriflex::engine {

/// Per second, with the threads they were measured with.
struct Rates {
  /// Lattice nodes updated, by Representation (populations, moments), Storage (double, float) and size of the
  /// box: one that stays in the caches, and one that does not.
  std::array<std::array<std::array<double, 2>, 2>, 2> nodes{};
  /// Of populations alone, by Storage, in a box that no cache holds: several steps at once.
  std::array<double, 2> at_once{};
  /// Seconds of a step of the smallest box, by Representation: what threads wait for each other.
  std::array<double, 2> step{};
  double bonds = 0.0, angles = 0.0;  // gradients
  std::array<double, 2> markers{};   // by Representation: coupled, all that is done for one included
  double checked_nodes = 0.0;        // of a body whose coupling is looked at before the first step, and
  double checked_substeps = 0.0;     // nodes times sub-steps where the force follows them
  std::optional<double> of_box{};    // lattice nodes of the box in question
};

/// Of this machine with so many threads, from a file in $XDG_CACHE_HOME/veriflex or .cache/veriflex of the
/// home directory; measured where there is none, which is kept where it can be written: for ten minutes where
/// other programs kept the machine busy meanwhile, which is told.
Rates rates(int threads);

/// The same with the rate of the work's own box, or of a part of it that no cache holds, where that work
/// would take 0.05 s or more: the length of its rows, their vectors and its caches make up to
/// a factor of two. Measured in half a second at most, and kept as the others.
Rates rates_for(const scene::ExpectedWork& work, int threads);

/// What that work will take  [s].
double seconds_of(const scene::ExpectedWork& work, const Rates& rates);

}  // namespace veriflex::engine
