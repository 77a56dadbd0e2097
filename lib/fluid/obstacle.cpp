#include "fluid/obstacle.hpp"

#include <cmath>

namespace veriflex::fluid {

std::vector<std::int64_t> voxels(const Grid& grid, const Shape& shape) {
  const auto* cylinder = std::get_if<Cylinder>(&shape);
  const Vec3& centre = cylinder != nullptr ? cylinder->centre : std::get<Sphere>(shape).centre;
  const double radius = cylinder != nullptr ? cylinder->radius : std::get<Sphere>(shape).radius;
  std::vector<std::int64_t> inside;
  for (std::int64_t node = 0; node < grid.count(); ++node) {
    const auto at = grid.node(node);
    double square = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (cylinder != nullptr && axis == cylinder->axis) continue;
      const auto length = static_cast<double>(grid.size[axis]);
      const double d =
          std::remainder(static_cast<double>(at[axis]) - centre[static_cast<Eigen::Index>(axis)], length);
      square += d * d;
    }
    if (square < radius * radius) inside.push_back(node);
  }
  return inside;
}

}  // namespace veriflex::fluid
