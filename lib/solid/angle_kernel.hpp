/// The gradient of all angles of a network: the hottest loop of the solid, compiled for the machine's own
/// vector instructions.
///
/// The angles of a node share its arms (its bonds, seen from the node), six in a cubic lattice for fifteen
/// angles. So angles are arranged in stars, a few arms and the angles between them; stars of the same shape
/// stand side by side, and one vector instruction works on as many stars as it has lanes. Arms are loaded and
/// their gradients handed back once per star, not once per angle.
///
/// This header and its source know no Eigen: types whose layout depends on the instruction set must not
/// cross.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace veriflex::solid {

/// The angle at a node between two of its bonds; its rest value is 180 or 90 degrees. Each unordered pair of
/// bonds of a node is one angle (departure D1: the paper's Eq. 14, read literally, would count each twice). A
/// sign is -1 where the bond's vector points to the node.
struct Angle {
  std::int32_t bond_a, bond_b;
  std::int8_t sign_a, sign_b;
  bool straight;  // 180 degrees at rest, else 90
};

/// Angles of a network, arranged.
struct AngleStars {
  static constexpr std::size_t max_arms = 6;
  /// Large bodies are worked on piece by piece, shape after shape in each: what a piece reads and adds to,
  /// some 300 kB, stays in the second-level cache from one shape to the next.
  static constexpr std::size_t max_stars = 2048;

  /// Two arms of a star by their numbers in it.
  struct Pair {
    std::uint8_t a, b;
    bool straight;
    auto operator<=>(const Pair&) const = default;
  };

  /// Stars of a piece with the same pairs. Arm k of star i is arms[k * lanes + i], as 2 * bond, + 1 where the
  /// bond's vector points to the node. The last star is repeated up to a whole number of vectors.
  struct Group {
    std::vector<Pair> pairs;
    std::size_t stars, lanes;
    std::vector<std::int32_t> arms;
  };

  std::vector<Group> groups;
  std::size_t angle_count = 0;

  double bytes() const;
};

/// Any list of angles between `bonds` bonds can be arranged; only how full the vectors get depends on how
/// many nodes look alike. Angles that share an arm go into the same star, as far as it has room.
AngleStars arrange(const std::vector<Angle>& angles, std::size_t bonds);

/// Adds stiffness times the gradient of 1/2 (theta - theta0)^2, summed over the angles, by the bonds' vectors
/// to g. `d` and `g` hold three columns (x, y, z) of `bonds` values. Same formulas as angle.hpp; the order of
/// summation is that of the arrangement, whatever the vector length. Returns whether every angle is defined
/// (see is_defined(); false for NaN).
bool add_angle_gradients(const AngleStars& stars, const double* d, std::size_t bonds, double stiffness,
                         double* g);

}  // namespace veriflex::solid
