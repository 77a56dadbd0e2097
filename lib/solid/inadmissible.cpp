#include "solid/inadmissible.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace veriflex::solid {

namespace {

Vec3 deformed(const Network& network, const Positions& u, std::int32_t b) {
  const Bond& bond = network.bonds[static_cast<std::size_t>(b)];
  return (network.vectors.row(b) + (u.row(bond.second) - u.row(bond.first))).transpose();
}

std::string describe(const Network& network, const Angle& t, const Vec3& a, const Vec3& b) {
  const Bond& bond_a = network.bonds[static_cast<std::size_t>(t.bond_a)];
  const Bond& bond_b = network.bonds[static_cast<std::size_t>(t.bond_b)];
  const auto [apex, end_a] =
      t.sign_a > 0 ? std::pair(bond_a.first, bond_a.second) : std::pair(bond_a.second, bond_a.first);
  const std::int32_t end_b = t.sign_b > 0 ? bond_b.second : bond_b.first;
  const double opening = std::atan2(precise_cross(a, b).norm(), a.dot(b)) * 180.0 / std::numbers::pi;
  return fmt::format(
      "angle of nodes {}, {} and {} is {} ({:.6g} degrees, {} at rest), where its force does not exist",
      network.id_of(end_a), network.id_of(apex), network.id_of(end_b),
      opening < 90.0 ? "folded back" : "flat", opening, t.straight ? 180 : 90);
}

}  // namespace

std::string what_is_inadmissible(const Material& material, const Network& network, const Positions& u) {
  const Interval domain = bond::domain(material.law);
  for (std::size_t i = 0; i < network.bonds.size(); ++i) {
    const Bond& bond = network.bonds[i];
    const double r = deformed(network, u, static_cast<std::int32_t>(i)).norm();
    const std::int64_t first = network.id_of(bond.first), second = network.id_of(bond.second);
    if (r == 0.0) return fmt::format("nodes {} and {} of a bond coincide", first, second);
    if (!domain.contains(r)) {
      return fmt::format("bond of nodes {} and {} has length {}, {} is defined between {} and {}", first,
                         second, r, bond::name_of(material.law), domain.lo, domain.hi);
    }
  }
  for (const Angle& t : network.angles) {
    if (!material.has_angles()) break;
    const Vec3 a = t.sign_a * deformed(network, u, t.bond_a);
    const Vec3 b = t.sign_b * deformed(network, u, t.bond_b);
    if (!is_defined(a, b, t.straight)) return describe(network, t, a, b);
  }
  return "a bond or an angle is within rounding of where its force does not exist";
}

}  // namespace veriflex::solid
