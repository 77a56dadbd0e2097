/// Shapes that are cut out of the fluid node by node, as a staircase of half-way bounce-back.
#pragma once

#include <array>
#include <cstdint>
#include <variant>
#include <vector>

#include "base/grid.hpp"
#include "base/vec.hpp"

namespace veriflex::fluid {

struct Sphere {
  Vec3 centre;    // [L]
  double radius;  // [L]
};

/// Along a whole axis of the box.
struct Cylinder {
  Vec3 centre;    // the coordinate along the axis means nothing  [L]
  double radius;  // [L]
  std::size_t axis;
};

using Shape = std::variant<Sphere, Cylinder>;

/// Nodes nearer to the centre than the radius, in the order of the grid. Along an axis that is not `closed`
/// by walls the nearest periodic image counts too.
std::vector<std::int64_t> voxels(const Grid& grid, const Shape& shape, const std::array<bool, 3>& closed);

}  // namespace veriflex::fluid
