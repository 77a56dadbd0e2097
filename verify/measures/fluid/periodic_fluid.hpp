/// What the studies of decaying flows share: a fluid alone in a periodic box.
#pragma once

#include <algorithm>
#include <array>
#include <numbers>
#include <numeric>
#include <span>
#include <vector>

#include "analytic/decaying_flow.hpp"
#include "engine/read_scene.hpp"
#include "scene/scene.hpp"

namespace veriflex::measures {

/// [fluid] without walls and without a force, which these flows do not have.
fluid::Spec read_periodic_fluid(const io::Table& top);

/// `nodes`: along a side, from `min` to 4096.
std::int64_t read_nodes(const io::Table& table, std::int64_t min);

/// Refuses at `relaxation_time` a run of more than 10^9 steps.
void require_steps(const io::Table& fluid, double steps);

/// `plane`: "xy" (the default), "yz" or "zx", as its two axes.
std::array<int, 2> read_plane(const io::Table& table);

/// The box of n x n nodes in that plane, one thick.
Grid plane_box(std::int64_t n, const std::array<int, 2>& plane);

/// How a fluid starts from an exact solution at time 0.
enum class Start {
  Balanced,         // with its viscous stress, and with the swelling that its changing pressure asks for
  WithoutSwelling,  // with its viscous stress; what swelling lacks rings as sound
  Equilibrium       // with neither: the velocity lags some tau behind
};
scene::Scene starting(const fluid::Spec& fluid, const analytic::DecayingFlow& flow, Start how);

/// 2 pi/n  [L^-1]
inline double wavenumber(std::int64_t n) { return 2.0 * std::numbers::pi / static_cast<double>(n); }

/// Where a node stands  [L].
inline Vec3 position(const Grid& grid, std::int64_t node) {
  const auto [x, y, z] = grid.node(node);
  return {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
}

}  // namespace veriflex::measures
