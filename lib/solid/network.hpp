/// The solid as a network: nodes, bonds between them, and angles between the bonds of a node.
/// [wu-qi-2014, Sec. 2.II]
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/mutant.hpp"
#include "base/parts.hpp"
#include "base/vec.hpp"
#include "solid/angle_kernel.hpp"
#include "solid/bond_kernel.hpp"

namespace veriflex::solid {

/// States of a network are displacements from `rest`: the length of a bond then carries the precision of a
/// displacement, not that of a coordinate.
struct Network {
  Positions rest;                      // undeformed positions  [L]
  std::vector<Bond> bonds;             // first < second in a lattice
  Positions vectors;                   // undeformed vector of each bond, from first to second  [L]
  std::vector<Angle> angles;           // empty for a scene without angles: no list is built
  double spacing;                      // r0  [L]
  std::vector<std::int64_t> ids = {};  // what messages call the nodes; empty: by their numbers

  std::int64_t id_of(std::int32_t node) const {
    return ids.empty() ? node : ids[static_cast<std::size_t>(node)];
  }
  Eigen::Index node_count() const { return rest.rows(); }
};

/// Memory of its nodes and bonds, and of its list of angles  [bytes].
double bond_bytes(const Network& network);
double angle_bytes(const Network& network);

/// What whoever computes with a network holds, so that the network counts among the parts of the scene.
struct NetworkParts {
  parts::Built bonds, angles;
};
NetworkParts parts_of(const Network& network);

/// A block of n x m x l lattice nodes; its axis is z. One chain of nodes stands for a cross-section of
/// spacing^2, so the section of the block is n m spacing^2 (not (n-1)(m-1) spacing^2).
struct Block {
  std::array<std::int64_t, 3> nodes;  // n, m, l
  double spacing;                     // r0  [L]

  std::int64_t node_count() const;  // saturates at the largest integer
  std::int64_t bond_count() const;
  double length() const { return static_cast<double>(nodes[2] - 1) * spacing; }
  double section() const {
    return static_cast<double>((nodes[0] - (planted(Mutant::section_between_nodes) ? 1 : 0)) *
                               (nodes[1] - (planted(Mutant::section_between_nodes) ? 1 : 0))) *
           spacing * spacing;
  }
};

/// A rod of circular section along z: the lattice nodes with x^2 + y^2 <= (radius spacing)^2, axis on a node.
struct Rod {
  double radius;          // in spacings; 2.5 gives the paper's section of 21 nodes
  std::int64_t sections;  // along z
  double spacing;         // r0  [L]
};

/// Lattice nodes inside a spheroid around the z axis, its centre on a node: (x^2 + y^2)/radius^2 + z^2/half^2
/// <= 1. A sphere is one with both alike.
struct Spheroid {
  double radius;       // across the axis, in spacings
  double half_length;  // along the axis, in spacings
  double spacing;      // r0  [L]
};

/// Lattice nodes inside a plate across the z axis, its centre on a node: |x| <= sides[0]/2, |y| <=
/// sides[1]/2, |z| <= thickness/2. Without thickness it is one layer of nodes.
struct Plate {
  std::array<double, 2> sides;  // along x and y, in spacings
  double thickness;             // along z, in spacings
  double spacing;               // r0  [L]
};

/// The nodes of the block, x fastest, the first at the origin, with one bond per pair of nearest neighbours,
/// without angles.
Network cubic_lattice(const Block& block);

/// The nodes of the rod, section by section, the axis' first node at the origin; bonds as above, without
/// angles.
Network rod_lattice(const Rod& rod);

/// The nodes of the spheroid or plate, x fastest, the centre at the origin; bonds as above, without angles.
Network spheroid_lattice(const Spheroid& spheroid);
Network plate_lattice(const Plate& plate);

/// Fills network.angles: every unordered pair of bonds of each node, opposite ones straight, all others
/// right. Meant for a cubic lattice, where bonds are parallel to the axes.
void add_angles(Network& network);

/// Nodes with fewer than six bonds, in rising order: the surface of a lattice body.
std::vector<std::int32_t> boundary_nodes(const Network& network);

}  // namespace veriflex::solid
