/// Bodies without ends: what leaves a periodic box on one side enters on the other, bonds too.
#pragma once

#include "solid/network.hpp"

namespace veriflex::scene {

/// Bonds the nodes at the low end of `axis` to those at the high end of the same row, as if the lattice went
/// on there: its period is its extent and one spacing. Meant for a block, before its angles are added.
void bond_across(solid::Network& network, int axis);

}  // namespace veriflex::scene
