/// The solid as a network: nodes on a cubic lattice and the bonds between nearest neighbours.   [wu-qi-2014,
/// Sec. 2.2]
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/vec.hpp"

namespace veriflex::solid {

/// A block of n x m x l lattice nodes; its axis is z. One chain of nodes stands for a cross-section of
/// spacing^2, so the section of the block is n m spacing^2 (not (n-1)(m-1) spacing^2).
struct Block {
  std::array<std::int64_t, 3> nodes;  // n, m, l
  double spacing;                     // r0  [L]

  std::int64_t node_count() const;  // saturates at the largest integer
  std::int64_t bond_count() const;
  double length() const { return static_cast<double>(nodes[2] - 1) * spacing; }
  double section() const { return static_cast<double>(nodes[0] * nodes[1]) * spacing * spacing; }
};

struct Bond {
  std::int32_t first, second;  // nodes
  Vec3 vector;                 // from first to second, undeformed  [L]
};

/// States of a network are displacements from `rest`: the length of a bond then carries the precision of a
/// displacement, not that of a coordinate.
struct Network {
  Positions rest;  // undeformed positions  [L]
  std::vector<Bond> bonds;
};

/// The nodes of the block, x fastest, the first at the origin, with one bond per pair of nearest neighbours.
Network cubic_lattice(const Block& block);

}  // namespace veriflex::solid
