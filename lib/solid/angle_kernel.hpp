/// The gradient of all angles of a network: the hottest loop of the solid, compiled for the machine's own
/// vector instructions.
///
/// This header and its source know no Eigen: types whose layout depends on the instruction set must not
/// cross.
#pragma once

#include <cstddef>
#include <cstdint>

namespace veriflex::solid {

/// The angle at a node between two of its bonds; its rest value is 180 or 90 degrees. Each unordered pair of
/// bonds of a node is one angle (departure D1: the paper's Eq. 14, read literally, would count each twice). A
/// sign is -1 where the bond's vector points to the node.
struct Angle {
  std::int32_t bond_a, bond_b;
  std::int8_t sign_a, sign_b;
  bool straight;  // 180 degrees at rest, else 90
};

/// Adds stiffness times the gradient of 1/2 (theta - theta0)^2, summed over the angles, by the bonds' vectors
/// to g. `d` and `g` hold three columns (x, y, z) of `bonds` values. Same formulas as angle.hpp, with its own
/// arc tangent (relative error below 3e-16); the order of summation is that of the list, whatever the vector
/// length. Returns whether every angle is defined (see is_defined(); false for NaN).
bool add_angle_gradients(const Angle* angles, std::size_t count, const double* d, std::size_t bonds,
                         double stiffness, double* g);

}  // namespace veriflex::solid
