/// The kinds of comparison, one per question that another program can answer, each in a file of its own. Each
/// measures how far this program is off, over the largest of what is compared.
#pragma once

#include "engine/study.hpp"

namespace veriflex::measures::peer {

/// `top` is the case, `peer` its table of that name.
engine::Study read_bond_table(const io::Table& top, const io::Table& peer);
engine::Study read_angle_table(const io::Table& top, const io::Table& peer);
engine::Study read_node_forces(const io::Table& top, const io::Table& peer);
engine::Study read_tensile_table(const io::Table& top, const io::Table& peer);
engine::Study read_cantilever(const io::Table& top, const io::Table& peer);
engine::Study read_trajectory(const io::Table& top, const io::Table& peer);

}  // namespace veriflex::measures::peer
