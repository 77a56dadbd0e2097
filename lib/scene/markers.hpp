/// Which nodes of a body exchange momentum with the fluid or are its ends, and where they stand.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/scene.hpp"

namespace veriflex::scene {

/// Rows of the body's coordinates turned such that its z axis points along `axis`; a rotation, no reflection.
Positions turned(const Positions& body, int axis);

/// The nodes that exchange momentum, in ascending order; none without a coupling. Throws BadParameter
/// ("coupling.nodes") when a listed node is not in the network or listed twice.
std::vector<std::int32_t> coupled_nodes(const Body& body);

/// Where these nodes of the undeformed body stand in the box, one row each  [L].
Positions markers_at_rest(const Body& body);

/// Nodes of the first or of the last section of a body, in rising order: those nearer than half a spacing to
/// the least or the largest of their places along its axis.
std::vector<std::int32_t> end_section(const Eigen::VectorXd& along, double spacing, bool last);

}  // namespace veriflex::scene
