/// A network out of a LAMMPS data file.
#pragma once

#include "io/lammps_data.hpp"
#include "solid/network.hpp"

namespace veriflex::scene {

/// Node i is the atom with the i-th smallest id, bond and angle i the ones with the i-th smallest ids. Angles
/// whose type is in `straight_types` rest at 180 degrees, all others at 90: LAMMPS keeps that in its
/// coefficients, not in the data file. The network's spacing is the median length of its bonds. Throws
/// InputError with the row's line: no bonds, a bond of length zero, two bonds between the same atoms, an
/// angle whose apex has no bond to one of its other atoms, an angle that is folded back or flat against its
/// type.
solid::Network network_of(const io::LammpsData& data, const std::vector<std::int64_t>& straight_types);

}  // namespace veriflex::scene
