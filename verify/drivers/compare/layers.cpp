#include "drivers/compare/layers.hpp"

#include <algorithm>

#include "drivers/compare/body.hpp"

namespace veriflex::drivers::compare {

std::vector<std::vector<Eigen::Index>> layers_of(const solid::Network& network) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(network.node_count()));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Eigen::Index>(i);
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return network.rest(a, z_axis) < network.rest(b, z_axis);
  });
  std::vector<std::vector<Eigen::Index>> layers;
  for (const Eigen::Index node : order) {
    const bool same =
        !layers.empty() &&
        network.rest(node, z_axis) - network.rest(layers.back().front(), z_axis) < 1e-6 * network.spacing;
    if (!same) layers.emplace_back();
    layers.back().push_back(node);
  }
  return layers;
}

void hold(solid::Held& held, const std::vector<Eigen::Index>& nodes, const std::vector<int>& axes) {
  for (const Eigen::Index node : nodes) {
    for (const int axis : axes) held(node, axis) = true;
  }
}

double sum_over(const Positions& reaction, const std::vector<Eigen::Index>& nodes, int axis) {
  double sum = 0.0;
  for (const Eigen::Index node : nodes) sum += reaction(node, axis);
  return sum;
}

}  // namespace veriflex::drivers::compare
