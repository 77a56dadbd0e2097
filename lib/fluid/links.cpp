#include "fluid/links.hpp"

#include <algorithm>

#include "base/mutant.hpp"

namespace veriflex::fluid {

int crossed_wall(const Spec& spec, const std::array<std::int64_t, 3>& at, int q, int sign) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t axis = planted(Mutant::corner_link_to_other_wall) ? 2 - i : i;
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

const Inflow* inflow_at(const Walls& walls, bool high) {
  return std::get_if<Inflow>(&walls.openings[high ? 1 : 0]);
}

const Outflow* outflow_at(const Walls& walls, bool high) {
  return std::get_if<Outflow>(&walls.openings[high ? 1 : 0]);
}

/// Of the velocity that flows in at a node beside an end of `axis`.
double share_of(const Inflow& inflow, const Spec& spec, std::size_t axis,
                const std::array<std::int64_t, 3>& at) {
  double share = 1.0;
  for (std::size_t other = 0; inflow.parabolic && other < 3; ++other) {
    if (other == axis || !spec.walls[other]) continue;
    const double s =
        (static_cast<double>(at[other]) + (planted(Mutant::parabola_off_by_half_a_node) ? 0.0 : 0.5)) /
        static_cast<double>(spec.grid.size[other]);
    share = (planted(Mutant::parabola_of_last_walls) ? 1.0 : share) * (4.0 * s * (1.0 - s));
  }
  return share;
}

void add_gains_of(const Spec& spec, std::int64_t node, std::vector<Gain>& gains) {
  const auto at = spec.grid.node(node);
  for (int q = 1; q < Q; ++q) {
    const int axis = crossed_wall(spec, at, q);
    if (axis < 0) continue;
    const auto a = static_cast<std::size_t>(axis);
    const Walls& walls = *spec.walls[a];
    const bool high = velocity(q)[a] > 0;
    if (outflow_at(walls, high) != nullptr) continue;
    const Inflow* const inflow = inflow_at(walls, high);
    const Vec3 u = inflow != nullptr ? Vec3(share_of(*inflow, spec, a, at) * inflow->velocity)
                   : high            ? walls.high_velocity
                                     : walls.low_velocity;
    const double speed = along(opposite(q), u);
    if (speed != 0.0)
      gains.push_back(
          {node, opposite(q), (planted(Mutant::wall_gain_halved) ? 3.0 : 6.0) * w(q) * speed, inflow});
  }
}

/// Nodes beside one end of an axis.
std::vector<std::int64_t> nodes_beside(const Grid& grid, std::size_t axis, bool high) {
  std::vector<std::int64_t> nodes;
  const std::size_t a = axis == 0 ? 1 : 0;
  const std::size_t b = axis == 2 ? 1 : 2;
  std::array<std::int64_t, 3> at{};
  at[axis] = high ? grid.size[axis] - 1 : 0;
  for (at[b] = 0; at[b] < grid.size[b]; ++at[b]) {
    for (at[a] = 0; at[a] < grid.size[a]; ++at[a]) nodes.push_back(grid.index(at[0], at[1], at[2]));
  }
  return nodes;
}

/// Nodes beside the ends for which `wanted(walls, high)`, in their order.
template <class Wanted>
std::vector<std::int64_t> nodes_beside(const Spec& spec, const Wanted& wanted) {
  std::vector<std::int64_t> nodes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const bool high : {false, true}) {
      if (!spec.walls[axis] || !wanted(*spec.walls[axis], high)) continue;
      const std::vector<std::int64_t> more = nodes_beside(spec.grid, axis, high);
      nodes.insert(nodes.end(), more.begin(), more.end());
    }
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

}  // namespace

std::vector<Gain> gains_of(const Spec& spec) {
  std::vector<Gain> gains;
  for (const std::int64_t node : nodes_beside(spec, [](const Walls&walls, bool high) {
         return inflow_at(walls, high) != nullptr ||
                !(high ? walls.high_velocity : walls.low_velocity).isZero(0.0);
       })) {
    add_gains_of(spec, node, gains);
  }
  return gains;
}

std::vector<Outlet> outlets_of(const Spec& spec, const std::vector<bool>& is_obstacle) {
  std::vector<Outlet> outlets;
  for (const std::int64_t node :
       nodes_beside(spec, [&](const Walls&walls, bool high) { return outflow_at(walls, high) != nullptr; })) {
    if (!is_obstacle.empty() && is_obstacle[static_cast<std::size_t>(node)]) continue;
    const auto at = spec.grid.node(node);
    Outlet outlet{node, node, 0U, 1.0};
    for (int q = 1; q < Q; ++q) {
      const int axis = crossed_wall(spec, at, q);
      if (axis < 0) continue;
      const auto a = static_cast<std::size_t>(axis);
      const Outflow* const outflow = outflow_at(*spec.walls[a], velocity(q)[a] > 0);
      if (outflow == nullptr) continue;
      outlet.out |= 1U << q;
      outlet.density = planted(Mutant::outflow_density_ignored) ? 1.0 : outflow->density;
      auto inner = at;
      inner[a] -= velocity(q)[a];
      if (inner[a] < 0 || inner[a] >= spec.grid.size[a]) continue;
      const std::int64_t next = spec.grid.index(inner[0], inner[1], inner[2]);
      if (is_obstacle.empty() || !is_obstacle[static_cast<std::size_t>(next)]) outlet.inner = next;
    }
    if (outlet.out != 0) outlets.push_back(outlet);
  }
  return outlets;
}

Populations returned_at(const Outlet& outlet, const Populations& here, const Populations& inside) {
  Populations mean;
  for (std::size_t q = 0; q < mean.size(); ++q) {
    mean[q] = 0.5 * (here[q] + (planted(Mutant::outflow_of_last_node) ? here[q] : inside[q]));
  }
  const double density = 1.0 + density_deviation(mean);
  if (planted(Mutant::outflow_without_shear)) mean = equilibrium(density, momentum(mean) / density);
  Populations returned{};
  for (int q = 1; q < Q; ++q) {
    if ((outlet.out >> q & 1U) == 0) continue;
    returned[static_cast<std::size_t>(q)] =
        mean[static_cast<std::size_t>(opposite(q))] + w(q) * (outlet.density - density);
  }
  return returned;
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
      if (crossed_wall(spec, at, q) >= 0 || (q == Q - 1 && planted(Mutant::obstacle_link_lost))) continue;
      const std::int64_t beyond = neighbour(spec.grid, at, q);
      if (is_obstacle[static_cast<std::size_t>(beyond)]) continue;
      const bool first_of_pair = q % 2 == 1;
      links.push_back(first_of_pair ? CutLink{node, beyond, q} : CutLink{beyond, node, opposite(q)});
    }
  }
  return links;
}

std::vector<Shore> shores_of(const Spec& spec, const std::vector<bool>& is_obstacle) {
  std::vector<Shore> links;
  for (const CutLink& link : links_of(spec, is_obstacle)) {
    const bool from_inside = is_obstacle[static_cast<std::size_t>(link.node)];
    links.push_back(from_inside ? Shore{link.beyond, 1U << opposite(link.q)}
                                : Shore{link.node, 1U << link.q});
  }
  std::sort(links.begin(), links.end(), [](const Shore& a, const Shore& b) { return a.node < b.node; });
  std::vector<Shore> shores;
  for (const Shore& link : links) {
    if (!shores.empty() && shores.back().node == link.node) {
      shores.back().cut |= link.cut;
    } else {
      shores.push_back(link);
    }
  }
  return shores;
}

Vec3 force_on_obstacle(const Fluid& fluid, std::span<const Shore> shores) {
  std::vector<std::int64_t> nodes;
  for (const Shore& shore : shores) nodes.push_back(shore.node);
  std::vector<Populations> h(nodes.size());
  fluid.populations(nodes, h);
  Vec3 force = Vec3::Zero();
  for (std::size_t i = 0; i < shores.size(); ++i) {
    for (int q = 1; q < Q; ++q) {
      if ((shores[i].cut >> q & 1U) == 0) continue;
      const auto& v = c[static_cast<std::size_t>(q)];
      force += (planted(Mutant::obstacle_force_once) ? 1.0 : 2.0) *
               h[i][static_cast<std::size_t>(opposite(q))] * Vec3(v[0], v[1], v[2]);
    }
  }
  return force;
}

}  // namespace veriflex::fluid
