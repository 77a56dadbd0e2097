/// Bodies that come too near to each other for the coupling to tell them apart.
#pragma once

#include <optional>

#include "base/grid.hpp"
#include "base/vec.hpp"

namespace veriflex::scene {

/// Two markers of different bodies, and how far apart they are.
struct Encounter {
  Eigen::Index first, second;  // rows
  double distance;             // [L]
};

/// The nearest two markers of two bodies, if they are nearer to each other than a distance of at most one
/// spacing; along axes that are not closed through the edges of the box, too. Positions that are no numbers
/// meet nobody.
std::optional<Encounter> nearest_within(double distance, const Positions& a, const Positions& b,
                                        const Grid& grid, const std::array<bool, 3>& closed);

}  // namespace veriflex::scene
