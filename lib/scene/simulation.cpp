#include "scene/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>

#include "base/error.hpp"

namespace veriflex::scene {

namespace {

class Stopwatch {
 public:
  /// Adds the time since the last lap.
  void lap(Simulation::Spent& to) {
    const auto wall = std::chrono::steady_clock::now();
    const std::clock_t cpu = std::clock();
    to.wall += std::chrono::duration<double>(wall - wall_).count();
    to.cpu += static_cast<double>(cpu - cpu_) / CLOCKS_PER_SEC;
    wall_ = wall;
    cpu_ = cpu;
  }

 private:
  std::chrono::steady_clock::time_point wall_ = std::chrono::steady_clock::now();
  std::clock_t cpu_ = std::clock();
};

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
  for (int i = 0; i < 3; ++i) box.col((i + axis + 1) % 3) = body.col(i);  // z, the last, goes to `axis`
  return box;
}

std::vector<std::int32_t> coupled_nodes(const solid::Network& network, const CouplingSpec& coupling) {
  if (coupling.coupled == Coupled::Boundary) return solid::boundary_nodes(network);
  if (coupling.coupled == Coupled::Listed) return listed_nodes(network, coupling.listed);
  std::vector<int> across(static_cast<std::size_t>(network.node_count()));
  for (std::size_t b = 0; b < network.bonds.size(); ++b) {
    if (network.vectors(static_cast<Eigen::Index>(b), coupling.axis) != 0.0) continue;
    ++across[static_cast<std::size_t>(network.bonds[b].first)];
    ++across[static_cast<std::size_t>(network.bonds[b].second)];
  }
  std::vector<std::int32_t> nodes;
  for (std::size_t i = 0; i < across.size(); ++i) {
    if (coupling.coupled == Coupled::All || across[i] < 4) nodes.push_back(static_cast<std::int32_t>(i));
  }
  return nodes;
}

Positions markers_at_rest(const solid::Network& network, const CouplingSpec& coupling) {
  const std::vector<std::int32_t> nodes = coupled_nodes(network, coupling);
  Positions X(static_cast<Eigen::Index>(nodes.size()), 3);
  for (std::size_t m = 0; m < nodes.size(); ++m) {
    X.row(static_cast<Eigen::Index>(m)) = network.rest.row(nodes[m]) + coupling.origin.transpose();
  }
  return X;
}

Simulation::Simulation(const fluid::Spec& fluid, Body body, const CouplingSpec& coupling)
    : coupling_(coupling),
      body_(std::move(body)),
      coupled_(coupled_nodes(body_.network, coupling)),
      transfer_(fluid.grid, closed(fluid), coupling.delta, fluid.obstacle),
      fluid_(fluid::make_fluid(fluid)),
      motion_(body_.material, body_.network, body_.conditions, 1.0, body_.substeps,
              Positions::Zero(body_.network.node_count(), 3), Positions::Zero(body_.network.node_count(), 3)),
      markers_(static_cast<Eigen::Index>(coupled_.size()), 3),
      slip_(markers_.rows(), 3) {}

void Simulation::advance() {
  Stopwatch watch;
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < coupled_.size(); ++i) {
      markers_(static_cast<Eigen::Index>(i), axis) = coupling_.origin[axis] +
                                                     body_.network.rest(coupled_[i], axis) +
                                                     motion_.displacement()(coupled_[i], axis);
    }
  }
  try {
    transfer_.locate(markers_);
  } catch (const NumericalFailure& failure) {
    throw NumericalFailure(fmt::format("step {}: {}", fluid_->steps() + 1, failure.what()), failure.mode);
  }
  fluid_->velocities(transfer_.nodes(), at_nodes_);
  transfer_.interpolate(at_nodes_, wanted_);
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < coupled_.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      slip_(row, axis) = wanted_(row, axis) - motion_.half_velocity()(coupled_[i], axis);
    }
  }
  coupling::add_further_rounds(transfer_, slip_, coupling_.marker_volume, coupling_.iterations, wanted_);
  watch.lap(seconds_.coupling);

  motion_.step({coupled_, wanted_, coupling_.marker_volume, coupling_.live}, exchanged_);
  watch.lap(seconds_.solid);

  transfer_.spread(-exchanged_, spread_);
  watch.lap(seconds_.coupling);

  fluid_->collide_and_stream({transfer_.nodes(), &spread_});
  watch.lap(seconds_.fluid);
}

Positions Simulation::positions() const {
  return (body_.network.rest + motion_.displacement()).rowwise() + coupling_.origin.transpose();
}

Vec3 Simulation::momentum() const { return fluid_->totals().momentum + motion_.momentum(); }

}  // namespace veriflex::scene
