/// A chain of nodes in a fluid whose every node is a marker, in the middle of a periodic box along x: a
/// filament whose drag is exactly known.
#pragma once

#include "io/document.hpp"
#include "scene/scene.hpp"

namespace veriflex::measures {

/// With the case's [bond], which rests at 1, and its [coupling], of the 4-point kernel; and with `nodes`,
/// `node_mass` and `substeps` of the driver's own table. Its angles are there and have no stiffness yet.
scene::Body read_marker_chain(const io::Table& top, const io::Table& own, const fluid::Spec& fluid);

/// Refuses a box that is not that of the theory: periodic, without obstacle and without force.
void check_empty_box(const io::Table& top, const fluid::Spec& fluid);

}  // namespace veriflex::measures
