// Forces on and energies of the nodes of a displaced network.

#include <fmt/format.h>

#include "base/error.hpp"
#include "measures/peer/body.hpp"
#include "measures/peer/kinds.hpp"

namespace veriflex::measures::peer {

namespace {

using observe::Observations;

struct NodeParts {
  Positions bond_force, angle_force, force;       // of angles: empty where they have no stiffness
  std::vector<double> bond_energy, angle_energy;  // half of each bond's to its nodes, a third of each angle's
};

NodeParts node_parts(const Body& body, const Positions& u) {
  const bond::AnyLaw& law = body.material.law;
  const double angle_stiffness = body.material.angle_stiffness;
  const solid::Network& network = body.network;
  const auto nodes = static_cast<std::size_t>(network.node_count());
  NodeParts parts{{}, {}, {}, std::vector<double>(nodes, 0.0), std::vector<double>(nodes, 0.0)};
  Positions gradient;
  evaluate({law, 0.0}, network, u, gradient);
  parts.bond_force = -gradient;
  if (!body.has_angles()) {
    parts.force = parts.bond_force;
  } else {
    evaluate({slack, angle_stiffness}, network, u, gradient);
    parts.angle_force = -gradient;
    evaluate(body.material, network, u, gradient);
    parts.force = -gradient;
  }

  const auto deformed = [&](std::int32_t b) -> Vec3 {
    const solid::Bond& bond = network.bonds[static_cast<std::size_t>(b)];
    return (network.vectors.row(b) + (u.row(bond.second) - u.row(bond.first))).transpose();
  };
  for (std::size_t b = 0; b < network.bonds.size(); ++b) {
    const double share = 0.5 * bond::energy(law, deformed(static_cast<std::int32_t>(b)).norm());
    parts.bond_energy[static_cast<std::size_t>(network.bonds[b].first)] += share;
    parts.bond_energy[static_cast<std::size_t>(network.bonds[b].second)] += share;
  }
  for (const solid::Angle& t : body.has_angles() ? network.angles : std::vector<solid::Angle>{}) {
    const solid::Bond& a = network.bonds[static_cast<std::size_t>(t.bond_a)];
    const solid::Bond& b = network.bonds[static_cast<std::size_t>(t.bond_b)];
    const double deviation =
        solid::angle_state(t.sign_a * deformed(t.bond_a), t.sign_b * deformed(t.bond_b), t.straight)
            .deviation;
    const double share = 0.5 * angle_stiffness * deviation * deviation / 3.0;
    const std::int32_t apex = t.sign_a > 0 ? a.first : a.second;
    const std::int32_t end_a = t.sign_a > 0 ? a.second : a.first;
    const std::int32_t end_b = t.sign_b > 0 ? b.second : b.first;
    for (const std::int32_t node : {apex, end_a, end_b})
      parts.angle_energy[static_cast<std::size_t>(node)] += share;
  }
  return parts;
}

/// What is compared node by node, and what its error is.
std::vector<observe::Metric> parts_of(const Body& body) {
  std::vector<observe::Metric> parts{
      {"force_error", {}, "1", "error of the force vector over the largest force"},
      {"bond_force_error", {}, "1", "the same of the bonds' part"},
      {"bond_energy_error", {}, "1", "error of the bonds' energy over the largest"}};
  if (body.has_angles()) {
    parts.push_back({"angle_force_error", {}, "1", "the same of the angles' part"});
    parts.push_back({"angle_energy_error", {}, "1", "error of the angles' energy over the largest"});
  }
  return parts;
}

Observations node_forces_observations(const Body& body) {
  Observations all;
  all.records = {{"node_forces",
                  "Force on each node of the displaced network: this program and its peer",
                  {{"node", "", "1", "the atom's id in the data file", {}},
                   {"force", "", "M L T^-2", "magnitude of the force", {}},
                   {"peer_force", "", "M L T^-2", "the same of the peer", {}}}}};
  for (const observe::Metric& part : parts_of(body)) {
    all.records.front().columns.push_back({part.name, "", part.dimension, part.meaning, {}});
    all.metrics.push_back({part.name, {}, part.dimension, of_the_largest});
  }
  declare_rows(all);
  return all;
}

void compare_nodes(const Body& body, const PeerTable& table, const std::vector<Eigen::Index>& node_of_row,
                   Observations& seen) {
  const Eigen::Index nodes = body.network.node_count();
  const auto peer = [&](const std::string& prefix, const std::string& suffix) {
    return by_node(table.vectors(prefix, suffix), node_of_row, 0, nodes);
  };
  const NodeParts ours = node_parts(body, peer("", "") - body.network.rest);
  // Flags stand by row, errors by node.
  std::vector<bool> clamped(static_cast<std::size_t>(nodes));
  for (std::size_t row = 0; row < table.rows(); ++row)
    clamped[static_cast<std::size_t>(node_of_row[row])] = table.clamped(row);
  const auto force_errors = [&](const Positions& mine, const Positions& theirs) {
    return relative_errors(lengths(mine - theirs), lengths(theirs), clamped);
  };
  const auto energy_errors = [&](const std::vector<double>& mine, const std::string& column) {
    const std::vector<double> theirs = by_node(table[column], node_of_row);
    return relative_errors(minus(mine, theirs), theirs, clamped);
  };
  const Positions peer_force = peer("f", "");
  std::vector<Errors> parts{force_errors(ours.force, peer_force),
                            force_errors(ours.bond_force, peer("f", "_bond")),
                            energy_errors(ours.bond_energy, "e_bond")};
  if (body.has_angles()) {
    parts.push_back(force_errors(ours.angle_force, peer("f", "_angle")));
    parts.push_back(energy_errors(ours.angle_energy, "e_angle"));
  }
  const std::vector<observe::Metric> named = parts_of(body);
  observe::Record& record = seen.open("node_forces");
  for (std::size_t i = 0; i < static_cast<std::size_t>(nodes); ++i) {
    const auto node = static_cast<Eigen::Index>(i);
    std::vector<double> row{static_cast<double>(body.network.id_of(static_cast<std::int32_t>(i))),
                            ours.force.row(node).norm(), peer_force.row(node).norm()};
    for (const Errors& part : parts) row.push_back(part.by_row[i]);
    record.append(row);
  }
  for (std::size_t k = 0; k < parts.size(); ++k) seen.set(named[k].name, parts[k].largest);
  count_rows(table, seen);
}

}  // namespace

engine::Study read_node_forces(const io::Table& top, const io::Table& peer) {
  const Body body = read_body(top, peer);
  const PeerTable table(peer, "table", peer.text("table"));
  table.need(joined({"id", "e_bond"}, {xyz("", ""), xyz("f", ""), xyz("f", "_bond")}));
  if (body.has_angles()) table.need(joined({"e_angle"}, {xyz("f", "_angle")}));
  const std::vector<Eigen::Index> node_of_row = nodes_of_rows(body, table, peer);
  if (static_cast<Eigen::Index>(node_of_row.size()) != body.network.node_count()) {
    peer.fail("table", fmt::format("the table has {} rows", node_of_row.size()),
              fmt::format("it needs one for each of the {} atoms", body.network.node_count()),
              "Give one configuration");
  }
  return {.plan = plan_of(body, "", {}),
          .declares = node_forces_observations(body),
          .run = [=](Observations& seen, Progress& progress, engine::Cost&) {
            warn(body, progress);
            compare_nodes(body, table, node_of_row, seen);
          }};
}

}  // namespace veriflex::measures::peer
