#include "solid/network.hpp"

#include <cmath>
#include <limits>

#include "base/mutant.hpp"
#include "base/stop.hpp"

namespace veriflex::solid {

namespace {

std::int64_t saturated_product(std::int64_t a, std::int64_t b) {
  std::int64_t product = 0;
  return __builtin_mul_overflow(a, b, &product) ? std::numeric_limits<std::int64_t>::max() : product;
}

// Collects the nodes of a lattice body, given as integer coordinates, and bonds each to its next ones along
// +x, +y, +z.
class LatticeBuilder {
 public:
  LatticeBuilder(std::array<std::int32_t, 3> size, double spacing)
      : size_(size), spacing_(spacing), number_(cells(), -1) {}

  void add(std::array<std::int32_t, 3> cell) {
    number_[index(cell)] = static_cast<std::int32_t>(cells_.size());
    cells_.push_back(cell);
  }

  Network build(std::array<std::int32_t, 3> origin) const {
    Network network;
    network.spacing = spacing_;
    network.rest.resize(static_cast<Eigen::Index>(cells_.size()), 3);
    std::vector<int> axes;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      stop_if_asked("node of the body", static_cast<std::int64_t>(i));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        network.rest(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(axis)) =
            spacing_ * (cells_[i][axis] - origin[axis]);
        std::array<std::int32_t, 3> next = cells_[i];
        if (++next[axis] >= size_[axis] || number_[index(next)] < 0) continue;
        network.bonds.push_back({static_cast<std::int32_t>(i), number_[index(next)]});
        axes.push_back(static_cast<int>(axis));
      }
    }
    network.vectors = Positions::Zero(static_cast<Eigen::Index>(axes.size()), 3);
    for (std::size_t b = 0; b < axes.size(); ++b)
      network.vectors(static_cast<Eigen::Index>(b), axes[b]) = spacing_;
    return network;
  }

 private:
  std::size_t cells() const {
    return static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) *
           static_cast<std::size_t>(size_[2]);
  }
  std::size_t index(const std::array<std::int32_t, 3>& c) const {
    return static_cast<std::size_t>(c[0]) +
           static_cast<std::size_t>(size_[0]) *
               (static_cast<std::size_t>(c[1]) +
                static_cast<std::size_t>(size_[1]) * static_cast<std::size_t>(c[2]));
  }

  std::array<std::int32_t, 3> size_;
  double spacing_;
  std::vector<std::int32_t> number_;  // of the node in a cell; -1 where there is none
  std::vector<std::array<std::int32_t, 3>> cells_;
};

// One end of a bond, seen from a node.
struct End {
  std::int32_t bond;
  std::int8_t sign;
};

std::vector<std::vector<End>> ends_by_node(const Network& network) {
  std::vector<std::vector<End>> ends(static_cast<std::size_t>(network.node_count()));
  for (std::size_t b = 0; b < network.bonds.size(); ++b) {
    ends[static_cast<std::size_t>(network.bonds[b].first)].push_back({static_cast<std::int32_t>(b), 1});
    ends[static_cast<std::size_t>(network.bonds[b].second)].push_back({static_cast<std::int32_t>(b), -1});
  }
  return ends;
}

}  // namespace

std::int64_t Block::node_count() const {
  return saturated_product(saturated_product(nodes[0], nodes[1]), nodes[2]);
}

std::int64_t Block::bond_count() const {
  const auto [n, m, l] = nodes;
  const std::int64_t all = saturated_product(3, node_count());
  if (all == std::numeric_limits<std::int64_t>::max()) return all;
  return all - n * m - m * l - l * n;
}

Network cubic_lattice(const Block& block) {
  const auto n = static_cast<std::int32_t>(block.nodes[0]);
  const auto m = static_cast<std::int32_t>(block.nodes[1]);
  const auto l = static_cast<std::int32_t>(block.nodes[2]);
  LatticeBuilder builder({n, m, l}, block.spacing);
  for (std::int32_t z = 0; z < l; ++z) {
    stop_if_asked("layer of the body", z);
    for (std::int32_t y = 0; y < m; ++y) {
      for (std::int32_t x = 0; x < n; ++x) builder.add({x, y, z});
    }
  }
  return builder.build({0, 0, 0});
}

Network rod_lattice(const Rod& rod) {
  const auto reach = static_cast<std::int32_t>(std::floor(rod.radius));
  const auto sections =
      static_cast<std::int32_t>(rod.sections) - (planted(Mutant::rod_one_section_short) ? 1 : 0);
  LatticeBuilder builder({2 * reach + 1, 2 * reach + 1, sections}, rod.spacing);
  for (std::int32_t z = 0; z < sections; ++z) {
    stop_if_asked("layer of the body", z);
    for (std::int32_t y = -reach; y <= reach; ++y) {
      for (std::int32_t x = -reach; x <= reach; ++x) {
        if (x * x + y * y <= rod.radius * rod.radius) builder.add({x + reach, y + reach, z});
      }
    }
  }
  return builder.build({reach, reach, 0});
}

namespace {

/// The cells from -reach to reach that `inside` holds, with the middle one at the origin.
template <class Inside>
Network lattice_around_origin(const std::array<std::int32_t, 3>& reach, double spacing, Inside inside) {
  LatticeBuilder builder({2 * reach[0] + 1, 2 * reach[1] + 1, 2 * reach[2] + 1}, spacing);
  for (std::int32_t z = -reach[2]; z <= reach[2]; ++z) {
    stop_if_asked("layer of the body", z);
    for (std::int32_t y = -reach[1]; y <= reach[1]; ++y) {
      for (std::int32_t x = -reach[0]; x <= reach[0]; ++x) {
        if (inside(x, y, z)) builder.add({x + reach[0], y + reach[1], z + reach[2]});
      }
    }
  }
  return builder.build(reach);
}

}  // namespace

Network spheroid_lattice(const Spheroid& spheroid) {
  const auto across = static_cast<std::int32_t>(std::floor(spheroid.radius));
  const auto along = static_cast<std::int32_t>(std::floor(spheroid.half_length));
  const double a2 = spheroid.radius * spheroid.radius;
  const double c2 = spheroid.half_length * spheroid.half_length;
  return lattice_around_origin({across, across, along}, spheroid.spacing, [&](double x, double y, double z) {
    return c2 * (x * x + y * y) + a2 * z * z <= (planted(Mutant::spheroid_without_poles) ? 0.999 : 1.0) * a2 *
                                                    c2;  // no division: the poles are inside exactly
  });
}

Network plate_lattice(const Plate& plate) {
  const auto half = [](double size) { return static_cast<std::int32_t>(std::floor(0.5 * size)); };
  return lattice_around_origin({half(plate.sides[0]), half(plate.sides[1]), half(plate.thickness)},
                               plate.spacing, [](double, double, double) { return true; });
}

double bond_bytes(const Network& network) {
  return parts::array_bytes(network.rest, network.vectors, network.bonds, network.ids);
}

double angle_bytes(const Network& network) { return parts::array_bytes(network.angles); }

NetworkParts parts_of(const Network& network) {
  NetworkParts held{{parts::Kind::Bonds, bond_bytes(network), &network}, {}};
  if (network.angles.capacity() > 0)
    held.angles = parts::Built(parts::Kind::Angles, angle_bytes(network), &network);
  return held;
}

void add_angles(Network& network) {
  const std::vector<std::vector<End>> ends_of_nodes = ends_by_node(network);
  std::size_t count = 0;
  for (const std::vector<End>& ends : ends_of_nodes) count += ends.size() * (ends.size() - 1) / 2;
  network.angles.reserve(count);
  for (const std::vector<End>& ends : ends_of_nodes) {
    stop_if_asked("angles of a node", static_cast<std::int64_t>(network.angles.size()));
    for (std::size_t p = 0; p < ends.size(); ++p) {
      for (std::size_t q = p + 1; q < ends.size(); ++q) {
        const double along = ends[p].sign * ends[q].sign *
                             network.vectors.row(ends[p].bond).dot(network.vectors.row(ends[q].bond));
        network.angles.push_back({ends[p].bond, ends[q].bond, ends[p].sign, ends[q].sign,
                                  (along < -0.5 * network.spacing * network.spacing) !=
                                      planted(Mutant::straight_and_right_swapped)});
      }
    }
  }
}

std::vector<std::int32_t> boundary_nodes(const Network& network) {
  std::vector<std::int32_t> boundary;
  const std::vector<std::vector<End>> ends = ends_by_node(network);
  for (std::size_t i = 0; i < ends.size(); ++i) {
    if (ends[i].size() < (planted(Mutant::boundary_of_edges_only) ? 5 : 6))
      boundary.push_back(static_cast<std::int32_t>(i));
  }
  return boundary;
}

}  // namespace veriflex::solid
