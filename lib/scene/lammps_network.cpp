#include "scene/lammps_network.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "solid/angle.hpp"

namespace veriflex::scene {

namespace {

using Pair = std::pair<std::int32_t, std::int32_t>;

Pair ordered(std::int32_t a, std::int32_t b) { return {std::min(a, b), std::max(a, b)}; }

std::int32_t node_of(const io::LammpsData& data, std::int64_t id) {
  const auto at =
      std::lower_bound(data.atoms.begin(), data.atoms.end(), id,
                       [](const io::LammpsAtom& a, std::int64_t wanted) { return a.id < wanted; });
  return static_cast<std::int32_t>(at - data.atoms.begin());
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

solid::Network network_of(const io::LammpsData& data, const std::vector<std::int64_t>& straight_types) {
  if (data.bonds.empty()) {
    throw InputError({data.file}, "the file has no bonds", "a network of single nodes has no forces",
                     "Add a section 'Bonds'");
  }
  solid::Network network;
  network.rest.resize(static_cast<Eigen::Index>(data.atoms.size()), 3);
  for (std::size_t i = 0; i < data.atoms.size(); ++i) {
    network.ids.push_back(data.atoms[i].id);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      network.rest(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(axis)) =
          data.atoms[i].position[axis];
    }
  }

  std::map<Pair, std::int32_t> bond_between;
  std::vector<double> lengths;
  network.vectors.resize(static_cast<Eigen::Index>(data.bonds.size()), 3);
  for (const io::LammpsBond& b : data.bonds) {
    const auto number = static_cast<std::int32_t>(network.bonds.size());
    const solid::Bond bond{node_of(data, b.atoms[0]), node_of(data, b.atoms[1])};
    const auto [known, is_new] = bond_between.emplace(ordered(bond.first, bond.second), number);
    if (!is_new) {
      throw InputError({data.file, b.line, 1},
                       fmt::format("bond {} joins the same atoms as bond {}", b.id,
                                   data.bonds[static_cast<std::size_t>(known->second)].id),
                       "an angle could not tell them apart", "Keep one");
    }
    network.vectors.row(number) = network.rest.row(bond.second) - network.rest.row(bond.first);
    lengths.push_back(network.vectors.row(number).norm());
    if (!(lengths.back() > 0.0)) {
      throw InputError({data.file, b.line, 1}, fmt::format("bond {} has length zero", b.id),
                       "atoms at the same place have no direction", "Move one of its atoms");
    }
    network.bonds.push_back(bond);
  }
  network.spacing = median(lengths);

  // The bond from an angle's apex to one of its other atoms, and whether its vector points away from the
  // apex.
  struct Arm {
    std::int32_t bond;
    std::int8_t sign;
  };
  const auto arm = [&](const io::LammpsAngle& angle, std::int64_t other_id) -> Arm {
    const std::int32_t apex = node_of(data, angle.atoms[1]);
    const auto found = bond_between.find(ordered(apex, node_of(data, other_id)));
    if (found == bond_between.end()) {
      throw InputError(
          {data.file, angle.line, 1},
          fmt::format("angle {} needs a bond between atoms {} and {}", angle.id, angle.atoms[1], other_id),
          "an angle lies between two bonds that share its apex, the atom in the middle",
          "Add the bond, or correct the order of the angle's atoms");
    }
    const bool away = network.bonds[static_cast<std::size_t>(found->second)].first == apex;
    return {found->second, static_cast<std::int8_t>(away || planted(Mutant::lammps_bond_reversed) ? 1 : -1)};
  };
  for (const io::LammpsAngle& angle : data.angles) {
    const Arm a = arm(angle, angle.atoms[0]);
    const Arm b = arm(angle, angle.atoms[2]);
    const bool straight =
        std::find(straight_types.begin(), straight_types.end(), angle.type) != straight_types.end();
    const Vec3 along_a = a.sign * network.vectors.row(a.bond).transpose();
    const Vec3 along_b = b.sign * network.vectors.row(b.bond).transpose();
    if (!solid::is_defined(along_a, along_b, straight)) {
      const bool flat = along_a.dot(along_b) < 0.0;
      throw InputError(
          {data.file, angle.line, 1}, fmt::format("angle {} is {}", angle.id, flat ? "flat" : "folded back"),
          fmt::format("its type rests at {} degrees and has no force there", straight ? 180 : 90),
          flat ? fmt::format("Name type {} in straight_types, or move an atom", angle.type)
               : "Move an atom, or leave the angle out");
    }
    network.angles.push_back({a.bond, b.bond, a.sign, b.sign, straight});
  }
  return network;
}

}  // namespace veriflex::scene
