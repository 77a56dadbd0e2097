/// Links between neighbouring nodes, and what walls and obstacles do to them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fluid/fluid.hpp"
#include "fluid/sweep.hpp"

namespace veriflex::fluid {

constexpr std::array<std::int64_t, 3> velocity(int q) {
  const auto& v = c[static_cast<std::size_t>(q)];
  return {v[0], v[1], v[2]};
}

/// What a sweep is told of a fluid, whatever stands for its nodes: size, lanes, force, walls.
template <class Real, class Lattice>
void describe(const Spec& spec, Lattice& lattice) {
  lattice.nx = spec.grid.size[0];
  lattice.ny = spec.grid.size[1];
  lattice.nz = spec.grid.size[2];
  lattice.lanes = lanes_for<Real>(lattice.nx);
  lattice.forced = spec.is_forced();
  lattice.scheme = spec.scheme;
  for (std::size_t axis = 0; axis < 3; ++axis) lattice.closed[axis] = spec.walls[axis].has_value();
}

/// c(q).v
inline double along(int q, const Vec3& v) {
  const auto& direction = c[static_cast<std::size_t>(q)];
  return direction[0] * v[0] + direction[1] * v[1] + direction[2] * v[2];
}

/// The first axis whose wall the link from `at` along sign c(q) crosses, or -1.
int crossed_wall(const Spec& spec, const std::array<std::int64_t, 3>& at, int q, int sign = 1);

/// The node at the other end of the link from `at` along sign c(q), round the box's edges.
std::int64_t neighbour(const Grid& grid, const std::array<std::int64_t, 3>& at, int q, int sign = 1);

/// A link that an obstacle cuts: from `node` along c(q), a first-of-pair direction, to `beyond`.
struct CutLink {
  std::int64_t node, beyond;
  int q;
};

/// Nodes inside of the obstacle; empty without one.
std::vector<bool> inside_of(const Spec& spec);

/// All other nodes, in the order of the grid.
std::vector<std::int64_t> outside_of_obstacle(const Spec& spec);

/// Links between the obstacle and the fluid; those that cross a wall are the sweep's own matter.
std::vector<CutLink> links_of(const Spec& spec, const std::vector<bool>& is_obstacle);

/// 6 w c.u, what a moving wall or an inflow adds to the population q that comes back to `node`.
struct Gain {
  std::int64_t node;
  int q;
  double value;
  const Inflow* inflow;  // whose share has risen, or none; of the Spec that the gains are of
};

/// Of all walls that move and all inflows, in the order of the nodes.
std::vector<Gain> gains_of(const Spec& spec);

/// Links of a node that lead out of the box; bit q of `out`: along c(q).
struct Outlet {
  std::int64_t node, inner;  // and the next one inwards, or the node itself
  unsigned out;
  double density;
  Populations returned{};  // in the place of what left along each c(q), in the last step
};

/// All nodes beside an outflow, outside of the obstacle, in their order.
std::vector<Outlet> outlets_of(const Spec& spec, const std::vector<bool>& is_obstacle);

/// What comes back in the place of the populations that leave along each c(q) of `out`: the mean of what the
/// node and the inner one were given from there before the step, as if carried out at half a spacing per
/// step, about the speed of sound, and a share of the density that is missing. A steady flow that does not
/// change along the axis goes on to the end as it is, with its fall of density. Minus what leaves
/// (anti-bounce-back [ginzburg-2008]) lets waves grow on a stream of small viscosity; the inner node's alone
/// keeps a momentum that changes its sign from node to node and from step to step.
Populations returned_at(const Outlet& outlet, const Populations& here, const Populations& inside);

/// What all outlets return in the step to come. `arriving(node)` may still ask for what they returned in the
/// last one.
template <class Arriving>
void prepare(std::vector<Outlet>& outlets, const Arriving& arriving) {
  std::vector<Populations> returned;
  for (const Outlet& outlet : outlets) {
    returned.push_back(returned_at(outlet, arriving(outlet.node), arriving(outlet.inner)));
  }
  for (std::size_t i = 0; i < outlets.size(); ++i) outlets[i].returned = returned[i];
}

/// A fluid node beside the obstacle; bit q of `cut`: the link along c(q) leads into it.
struct Shore {
  std::int64_t node;
  unsigned cut;
};

/// All of them, in their order.
std::vector<Shore> shores_of(const Spec& spec, const std::vector<bool>& is_obstacle);

/// Force of the fluid on its obstacle in the last step, from what its `shores` turned back, less the pressure
/// of fluid at rest. [ladd-1994]  [M L T^-2]
Vec3 force_on_obstacle(const Fluid& fluid, std::span<const Shore> shores);

}  // namespace veriflex::fluid
