#include "scene/markers.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "base/mutant.hpp"

namespace veriflex::scene {

namespace {

std::vector<std::int32_t> listed_nodes(const solid::Network& network, std::vector<std::int32_t> nodes) {
  std::sort(nodes.begin(), nodes.end());
  const auto fail = [](const std::string& problem, const std::string& why) {
    throw BadParameter("coupling.nodes", problem, why, "List each coupled node once, counted from 0");
  };
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i] < 0 || nodes[i] >= network.node_count()) {
      fail(fmt::format("'nodes' lists node {}", nodes[i]),
           fmt::format("the body has nodes 0 to {}", network.node_count() - 1));
    }
    if (i > 0 && nodes[i] == nodes[i - 1]) {
      fail(fmt::format("'nodes' lists node {} twice", nodes[i]), "a node exchanges momentum once a step");
    }
  }
  return nodes;
}

}  // namespace

Positions turned(const Positions& body, int axis) {
  Positions box(body.rows(), 3);
  for (int i = 0; i < 3; ++i)
    box.col((i + axis + (planted(Mutant::axes_turned_wrong) ? 2 : 1)) % 3) =
        body.col(i);  // z, the last, goes to `axis`
  return box;
}

std::vector<std::int32_t> coupled_nodes(const Body& body) {
  if (!body.coupling) return {};
  const solid::Network& network = body.network;
  if (body.coupling->coupled == Coupled::Boundary) return solid::boundary_nodes(network);
  if (body.coupling->coupled == Coupled::Listed) return listed_nodes(network, body.coupling->listed);
  std::vector<int> across(static_cast<std::size_t>(network.node_count()));
  for (std::size_t b = 0; b < network.bonds.size(); ++b) {
    if (network.vectors(static_cast<Eigen::Index>(b), body.axis) != 0.0) continue;
    ++across[static_cast<std::size_t>(network.bonds[b].first)];
    ++across[static_cast<std::size_t>(network.bonds[b].second)];
  }
  std::vector<std::int32_t> nodes;
  for (std::size_t i = 0; i < across.size(); ++i) {
    if (body.coupling->coupled == Coupled::All || across[i] < 4)
      nodes.push_back(static_cast<std::int32_t>(i));
  }
  return nodes;
}

Positions markers_at_rest(const Body& body) {
  const std::vector<std::int32_t> nodes = coupled_nodes(body);
  Positions X(static_cast<Eigen::Index>(nodes.size()), 3);
  for (std::size_t m = 0; m < nodes.size(); ++m) {
    X.row(static_cast<Eigen::Index>(m)) = body.network.rest.row(nodes[m]) + body.place.transpose();
  }
  return X;
}

std::vector<std::int32_t> end_section(const Eigen::VectorXd& along, double spacing, bool last) {
  const double lowest = along.minCoeff(), highest = along.maxCoeff();
  std::vector<std::int32_t> nodes;
  for (Eigen::Index i = 0; i < along.size(); ++i) {
    if (last ? along[i] > highest - 0.5 * spacing : along[i] < lowest + 0.5 * spacing)
      nodes.push_back(static_cast<std::int32_t>(i));
  }
  return nodes;
}

}  // namespace veriflex::scene
