#include "fluid/obstacle.hpp"

#include <cmath>

#include "base/mutant.hpp"

namespace veriflex::fluid {

std::vector<std::int64_t> voxels(const Grid& grid, const Shape& shape, const std::array<bool, 3>& closed) {
  const auto* cylinder = std::get_if<Cylinder>(&shape);
  const Vec3& centre = cylinder != nullptr ? cylinder->centre : std::get<Sphere>(shape).centre;
  const double radius = cylinder != nullptr ? cylinder->radius : std::get<Sphere>(shape).radius;
  std::array<std::vector<double>, 3> square;  // of the distance along each axis, by coordinate
  for (std::size_t axis = 0; axis < 3; ++axis) {
    square[axis].resize(static_cast<std::size_t>(grid.size[axis]), 0.0);
    if (cylinder != nullptr && axis == cylinder->axis) continue;
    for (std::int64_t at = 0; at < grid.size[axis]; ++at) {
      const double straight = static_cast<double>(at) - centre[static_cast<Eigen::Index>(axis)];
      const double d = closed[axis] || planted(Mutant::obstacle_without_images)
                           ? straight
                           : std::remainder(straight, static_cast<double>(grid.size[axis]));
      square[axis][static_cast<std::size_t>(at)] = d * d;
    }
  }
  std::vector<std::int64_t> inside;
  for (std::int64_t node = 0; node < grid.count(); ++node) {
    const auto at = grid.node(node);
    double sum = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) sum += square[axis][static_cast<std::size_t>(at[axis])];
    if (sum < radius * radius) inside.push_back(node);
  }
  return inside;
}

}  // namespace veriflex::fluid
