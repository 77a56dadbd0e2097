/// How fast this machine is, for estimates of what a run will take. Measured once, in a second or two, and
/// kept.
#pragma once

#include <array>
#include <filesystem>

#include "scene/plan.hpp"

namespace veriflex::engine {

/// Per second, with the threads they were measured with.
struct Rates {
  /// Lattice nodes updated, by Representation (populations, moments), Storage (double, float) and size of the
  /// box: one that stays in the caches, and one that does not.
  std::array<std::array<std::array<double, 2>, 2>, 2> nodes{};
  double bonds = 0.0, angles = 0.0;  // gradients
  double markers = 0.0;              // coupled, all that is done for one included
  double checked_nodes = 0.0;        // of a body whose coupling is looked at before the first step
};

/// Of this machine, from the file where they are kept; measured where there is none. `cache`: that file's
/// folder; nothing is kept where it cannot be written.
Rates rates(int threads, const std::filesystem::path& cache);

/// $XDG_CACHE_HOME/veriflex, or .cache/veriflex of the home directory.
std::filesystem::path cache_folder();

/// What that work will take  [s].
double seconds_of(const scene::ExpectedWork& work, const Rates& rates);

}  // namespace veriflex::engine
