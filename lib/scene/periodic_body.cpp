#include "scene/periodic_body.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/mutant.hpp"

namespace veriflex::scene {

void bond_across(solid::Network& network, int axis) {
  using Row = std::pair<std::int64_t, std::int64_t>;
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  const double low = network.rest.col(axis).minCoeff(), high = network.rest.col(axis).maxCoeff();
  std::map<Row, std::pair<std::int32_t, std::int32_t>> ends;  // of each row: its lowest and highest node
  for (Eigen::Index i = 0; i < network.node_count(); ++i) {
    const double x = network.rest(i, axis);
    const bool is_low = x < low + 0.5 * network.spacing;
    const bool is_high = x > high - 0.5 * network.spacing;
    if (!is_low && !is_high) continue;
    const Row row{std::llround(network.rest(i, a) / network.spacing),
                  std::llround(network.rest(i, b) / network.spacing)};
    auto& end = ends.try_emplace(row, -1, -1).first->second;
    (is_low ? end.first : end.second) = static_cast<std::int32_t>(i);
  }
  std::vector<Vec3> vectors;
  for (const auto& [row, end] : ends) {
    if (end.first < 0 || end.second < 0) continue;
    const auto [first, second] = std::minmax(end.first, end.second);
    Vec3 vector = Vec3::Zero();
    vector[axis] = (first == end.first) != planted(Mutant::bonds_across_reversed)
                       ? -network.spacing
                       : network.spacing;  // away from the body
    network.bonds.push_back({first, second});
    vectors.push_back(vector);
  }
  const Eigen::Index before = network.vectors.rows();
  network.vectors.conservativeResize(static_cast<Eigen::Index>(network.bonds.size()), 3);
  for (std::size_t i = 0; i < vectors.size(); ++i)
    network.vectors.row(before + static_cast<Eigen::Index>(i)) = vectors[i].transpose();
}

}  // namespace veriflex::scene
