#include "solid/tension_test.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace veriflex::solid {

namespace {

constexpr int x_axis = 0, y_axis = 1, z_axis = 2;

// Everything but the axial coordinate of the last section, which displacement control holds too.
FixedDofs holds(const Block& block, bool lateral_held) {
  FixedDofs held = FixedDofs::Constant(block.node_count(), 3, false);
  const std::int64_t section = block.nodes[0] * block.nodes[1];
  held.col(z_axis).head(section).setConstant(true);
  if (lateral_held) {
    held.leftCols(2).setConstant(true);
    return held;
  }
  // The first section cannot leave its plane; what is left is a shift and a turn in it.
  held(0, x_axis) = held(0, y_axis) = true;
  if (block.nodes[0] > 1) {
    held(block.nodes[0] - 1, y_axis) = true;
  } else if (block.nodes[1] > 1) {
    held(block.nodes[1] - 1, x_axis) = true;
  }
  return held;
}

}  // namespace

Pulled pull_to_strain(const bond::AnyLaw& law, const Block& block, bool lateral_held, double strain,
                      const Statics& how) {
  const Network network = cubic_lattice(block);
  const std::int64_t section = block.nodes[0] * block.nodes[1];
  FixedDofs held = holds(block, lateral_held);
  held.col(z_axis).tail(section).setConstant(true);
  // The start is deliberately not the uniform stretch that solves the problem: its bonds are strained up to 5
  // % less and further than that, but not nearer to a limit of the law than half of what the uniform one
  // leaves.
  const Interval domain = bond::domain(law);
  const double stretched = block.spacing * (1.0 + strain);
  const double room = std::min(domain.hi - stretched, stretched - domain.lo) / block.spacing;
  const double unevenness = strain == 0.0 ? 0.0 : std::min(0.05, 0.5 * room / std::abs(strain));
  Positions u = Positions::Zero(block.node_count(), 3);
  const double length = block.length();
  for (Eigen::Index i = 0; i < u.rows(); ++i) {
    const double z = network.rest(i, z_axis);
    u(i, z_axis) =
        strain * (z + unevenness * length / std::numbers::pi * std::sin(std::numbers::pi * z / length));
  }
  u.col(z_axis).tail(section).setConstant(strain * length);
  const Equilibrium e = relax(how, {law, 0.0}, network, u, held, Positions::Zero(u.rows(), 3));
  refuse_turned_bonds(network, e.u);
  return {strain, e.reaction.col(z_axis).tail(section).sum() / block.section(), e.iterations, e.residual};
}

Pulled pull_with_stress(const bond::AnyLaw& law, const Block& block, bool lateral_held, double stress,
                        const Statics& how) {
  const Network network = cubic_lattice(block);
  const std::int64_t section = block.nodes[0] * block.nodes[1];
  Positions load = Positions::Zero(network.node_count(), 3);
  load.col(z_axis).tail(section).setConstant(stress * block.spacing * block.spacing);
  const Equilibrium e =
      relax(how, {law, 0.0}, network, Positions::Zero(load.rows(), 3), holds(block, lateral_held), load);
  refuse_turned_bonds(network, e.u);
  return {e.u.col(z_axis).tail(section).mean() / block.length(), stress, e.iterations, e.residual};
}

}  // namespace veriflex::solid
