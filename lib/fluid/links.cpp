#include "fluid/links.hpp"

#include <algorithm>

namespace veriflex::fluid {

int crossed_wall(const Spec& spec, const std::array<std::int64_t, 3>& at, int q, int sign) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t to = at[axis] + sign * velocity(q)[axis];
    if (spec.walls[axis] && (to < 0 || to >= spec.grid.size[axis])) return static_cast<int>(axis);
  }
  return -1;
}

std::int64_t neighbour(const Grid& grid, const std::array<std::int64_t, 3>& at, int q, int sign) {
  const auto v = velocity(q);
  return grid.index(grid.wrap(at[0] + sign * v[0], 0), grid.wrap(at[1] + sign * v[1], 1),
                    grid.wrap(at[2] + sign * v[2], 2));
}

namespace {

void add_gains_of(const Spec& spec, std::int64_t node, std::vector<Gain>& gains) {
  const auto at = spec.grid.node(node);
  for (int q = 1; q < Q; ++q) {
    const int axis = crossed_wall(spec, at, q);
    if (axis < 0) continue;
    const auto a = static_cast<std::size_t>(axis);
    const Walls& walls = *spec.walls[a];
    const bool high = velocity(q)[a] > 0;
    const Vec3& u = high ? walls.high_velocity : walls.low_velocity;
    const double speed = along(opposite(q), u);
    if (speed != 0.0) gains.push_back({node, opposite(q), 6.0 * w(q) * speed});
  }
}

}  // namespace

std::vector<Gain> gains_of(const Spec& spec) {
  const Grid& grid = spec.grid;
  std::vector<std::int64_t> near;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::optional<Walls>& walls = spec.walls[axis];
    if (!walls || (walls->low_velocity.isZero(0.0) && walls->high_velocity.isZero(0.0))) continue;
    const std::size_t a = axis == 0 ? 1 : 0;
    const std::size_t b = axis == 2 ? 1 : 2;
    for (std::int64_t j = 0; j < grid.size[b]; ++j) {
      for (std::int64_t i = 0; i < grid.size[a]; ++i) {
        std::array<std::int64_t, 3> at{};
        at[a] = i;
        at[b] = j;
        near.push_back(grid.index(at[0], at[1], at[2]));
        at[axis] = grid.size[axis] - 1;
        near.push_back(grid.index(at[0], at[1], at[2]));
      }
    }
  }
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  std::vector<Gain> gains;
  for (const std::int64_t node : near) add_gains_of(spec, node, gains);
  return gains;
}

std::vector<bool> inside_of(const Spec& spec) {
  std::vector<bool> is_obstacle;
  if (spec.has_obstacle()) is_obstacle.resize(static_cast<std::size_t>(spec.grid.count()));
  for (const std::int64_t node : spec.obstacle) is_obstacle[static_cast<std::size_t>(node)] = true;
  return is_obstacle;
}

std::vector<std::int64_t> outside_of_obstacle(const Spec& spec) {
  const std::vector<bool> is_obstacle = inside_of(spec);
  std::vector<std::int64_t> nodes;
  for (std::int64_t node = 0; node < spec.grid.count(); ++node) {
    if (is_obstacle.empty() || !is_obstacle[static_cast<std::size_t>(node)]) nodes.push_back(node);
  }
  return nodes;
}

std::vector<CutLink> links_of(const Spec& spec, const std::vector<bool>& is_obstacle) {
  std::vector<CutLink> links;
  for (const std::int64_t node : spec.obstacle) {
    const auto at = spec.grid.node(node);
    for (int q = 1; q < Q; ++q) {
      if (crossed_wall(spec, at, q) >= 0) continue;
      const std::int64_t beyond = neighbour(spec.grid, at, q);
      if (is_obstacle[static_cast<std::size_t>(beyond)]) continue;
      const bool first_of_pair = q % 2 == 1;
      links.push_back(first_of_pair ? CutLink{node, beyond, q} : CutLink{beyond, node, opposite(q)});
    }
  }
  return links;
}

}  // namespace veriflex::fluid
