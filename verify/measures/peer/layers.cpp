#include "measures/peer/layers.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "measures/peer/body.hpp"

namespace veriflex::measures::peer {

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

namespace {

// For each node whether bonds tie it to one of `anchors`, however far away.
std::vector<bool> tied_to(const solid::Network& network, const std::vector<Eigen::Index>& anchors) {
  std::vector<std::vector<std::int32_t>> neighbours(static_cast<std::size_t>(network.node_count()));
  for (const solid::Bond& bond : network.bonds) {
    neighbours[static_cast<std::size_t>(bond.first)].push_back(bond.second);
    neighbours[static_cast<std::size_t>(bond.second)].push_back(bond.first);
  }
  std::vector<bool> tied(neighbours.size(), false);
  std::vector<std::int32_t> to_visit;
  for (const Eigen::Index node : anchors) {
    const auto at = static_cast<std::size_t>(node);
    if (!neighbours[at].empty()) to_visit.push_back(static_cast<std::int32_t>(node));
  }
  while (!to_visit.empty()) {
    const auto node = static_cast<std::size_t>(to_visit.back());
    to_visit.pop_back();
    if (tied[node]) continue;
    tied[node] = true;
    to_visit.insert(to_visit.end(), neighbours[node].begin(), neighbours[node].end());
  }
  return tied;
}

}  // namespace

void require_statics(const solid::Network& network, std::size_t held, bool last_held, const io::Table& peer) {
  const auto layers = layers_of(network);
  if (layers.size() < 2)
    peer.fail("data", "all nodes have the same z", "the body is fixed by layers across z", "Turn the body");
  for (std::size_t i = 1; i < layers.size(); ++i) {
    const Eigen::Index below = layers[i - 1].front();
    const Eigen::Index above = layers[i].front();
    const double apart = network.rest(above, z_axis) - network.rest(below, z_axis);
    if (apart >= 0.01 * network.spacing) continue;
    peer.fail(
        "data",
        fmt::format("atoms {} and {} are {:.3g} apart along z",
                    network.id_of(static_cast<std::int32_t>(below)),
                    network.id_of(static_cast<std::int32_t>(above)), apart),
        "nodes of one layer have the same z, or one that differs by less than 1e-6 of a bond; this looks "
        "like rounding, and would hold only a part of a layer",
        "Write positions with all their digits");
  }
  std::vector<Eigen::Index> anchors;
  for (std::size_t i = 0; i < std::min(held, layers.size()); ++i)
    anchors.insert(anchors.end(), layers[i].begin(), layers[i].end());
  if (last_held) anchors.insert(anchors.end(), layers.back().begin(), layers.back().end());
  const std::vector<bool> tied = tied_to(network, anchors);
  const auto loose = std::find(tied.begin(), tied.end(), false);
  if (loose == tied.end()) return;
  peer.fail("data",
            fmt::format("{} atoms are loose, the first is {}", std::count(loose, tied.end(), false),
                        network.id_of(static_cast<std::int32_t>(loose - tied.begin()))),
            "no bonds tie them to the layers that are fixed, so that nothing keeps them in place",
            "Leave them out, or add their bonds");
}

void hold(solid::FixedDofs& held, const std::vector<Eigen::Index>& nodes, const std::vector<int>& axes) {
  for (const Eigen::Index node : nodes) {
    for (const int axis : axes) held(node, axis) = true;
  }
}

double sum_over(const Positions& reaction, const std::vector<Eigen::Index>& nodes, int axis) {
  double sum = 0.0;
  for (const Eigen::Index node : nodes) sum += reaction(node, axis);
  return sum;
}

}  // namespace veriflex::measures::peer
