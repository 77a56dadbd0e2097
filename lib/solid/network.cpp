#include "solid/network.hpp"

#include <limits>

namespace veriflex::solid {

namespace {

std::int64_t saturated_product(std::int64_t a, std::int64_t b) {
  std::int64_t product = 0;
  return __builtin_mul_overflow(a, b, &product) ? std::numeric_limits<std::int64_t>::max() : product;
}

}  // namespace

std::int64_t Block::node_count() const {
  return saturated_product(saturated_product(nodes[0], nodes[1]), nodes[2]);
}

std::int64_t Block::bond_count() const {
  const auto [n, m, l] = nodes;
  const std::int64_t all = saturated_product(3, node_count());
  if (all == std::numeric_limits<std::int64_t>::max()) return all;
  return all - n * m - m * l - l * n;
}

Network cubic_lattice(const Block& block) {
  const auto n = static_cast<std::int32_t>(block.nodes[0]);
  const auto m = static_cast<std::int32_t>(block.nodes[1]);
  const auto l = static_cast<std::int32_t>(block.nodes[2]);
  Network network;
  network.rest.resize(3, block.node_count());
  network.bonds.reserve(static_cast<std::size_t>(block.bond_count()));
  std::int32_t node = 0;
  for (std::int32_t z = 0; z < l; ++z) {
    for (std::int32_t y = 0; y < m; ++y) {
      for (std::int32_t x = 0; x < n; ++x, ++node) {
        network.rest.col(node) = block.spacing * Vec3(x, y, z);
        if (x + 1 < n) network.bonds.push_back({node, node + 1, block.spacing * Vec3::UnitX()});
        if (y + 1 < m) network.bonds.push_back({node, node + n, block.spacing * Vec3::UnitY()});
        if (z + 1 < l) network.bonds.push_back({node, node + n * m, block.spacing * Vec3::UnitZ()});
      }
    }
  }
  return network;
}

}  // namespace veriflex::solid
