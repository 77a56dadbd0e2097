// Forces on and energies of the nodes of a displaced network.

#include <fmt/format.h>

#include "base/error.hpp"
#include "drivers/compare/body.hpp"
#include "drivers/compare/kinds.hpp"

namespace veriflex::drivers::compare {

namespace {

using observe::Observations;
using observe::Record;

struct NodeParts {
  Positions bond_force, angle_force, force;
  std::vector<double> bond_energy, angle_energy;  // half of each bond's to its nodes, a third of each angle's
};

NodeParts node_parts(const Body& body, const Positions& u) {
  const auto& [law, angle_stiffness] = body.material;
  const solid::Network& network = body.network;
  const auto nodes = static_cast<std::size_t>(network.node_count());
  NodeParts parts{{}, {}, {}, std::vector<double>(nodes, 0.0), std::vector<double>(nodes, 0.0)};
  Positions gradient;
  evaluate({law, 0.0}, network, u, gradient);
  parts.bond_force = -gradient;
  evaluate({slack, angle_stiffness}, network, u, gradient);
  parts.angle_force = -gradient;
  evaluate(body.material, network, u, gradient);
  parts.force = -gradient;

  const auto deformed = [&](std::int32_t b) -> Vec3 {
    const solid::Bond& bond = network.bonds[static_cast<std::size_t>(b)];
    return (network.vectors.row(b) + (u.row(bond.second) - u.row(bond.first))).transpose();
  };
  for (std::size_t b = 0; b < network.bonds.size(); ++b) {
    const double share = 0.5 * bond::energy(law, deformed(static_cast<std::int32_t>(b)).norm());
    parts.bond_energy[static_cast<std::size_t>(network.bonds[b].first)] += share;
    parts.bond_energy[static_cast<std::size_t>(network.bonds[b].second)] += share;
  }
  for (const solid::Angle& t : network.angles) {
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

void compare_nodes(const Body& body, const Table& table, const std::vector<Eigen::Index>& node_of_row,
                   Observations& seen) {
  const Eigen::Index nodes = body.network.node_count();
  const auto peer = [&](const std::string& prefix, const std::string& suffix) {
    return by_node(table.vectors(prefix, suffix), node_of_row, 0, nodes);
  };
  const NodeParts ours = node_parts(body, peer("", "") - body.network.rest);
  const auto force_errors = [&](const Positions& mine, const Positions& theirs) {
    return relative_errors(lengths(mine - theirs), lengths(theirs), table);
  };
  const Positions peer_force = peer("f", "");
  const Errors bond_error = force_errors(ours.bond_force, peer("f", "_bond"));
  const Errors angle_error = force_errors(ours.angle_force, peer("f", "_angle"));
  const Errors force_error = force_errors(ours.force, peer_force);
  const std::vector<double> peer_bond_energy = by_node(table["e_bond"], node_of_row);
  const std::vector<double> peer_angle_energy = by_node(table["e_angle"], node_of_row);
  const Errors bond_energy_error =
      relative_errors(minus(ours.bond_energy, peer_bond_energy), peer_bond_energy, table);
  const Errors angle_energy_error =
      relative_errors(minus(ours.angle_energy, peer_angle_energy), peer_angle_energy, table);

  Record record{"node_forces",
                "Force on each node of the displaced network: this program and its peer",
                {{"node", "", "1", "number of the node", {}},
                 {"force", "", "M L T^-2", "magnitude of the force", {}},
                 {"peer_force", "", "M L T^-2", "the same of the peer", {}},
                 {"force_error", "", "1", "error of the force vector over the largest force", {}},
                 {"bond_force_error", "", "1", "the same of the bonds' part", {}},
                 {"angle_force_error", "", "1", "the same of the angles' part", {}},
                 {"bond_energy_error", "", "1", "error of the bonds' energy over the largest", {}},
                 {"angle_energy_error", "", "1", "error of the angles' energy over the largest", {}}}};
  for (std::size_t i = 0; i < static_cast<std::size_t>(nodes); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    record.append({static_cast<double>(i), ours.force.row(row).norm(), peer_force.row(row).norm(),
                   force_error.by_row[i], bond_error.by_row[i], angle_error.by_row[i],
                   bond_energy_error.by_row[i], angle_energy_error.by_row[i]});
  }
  seen.records.push_back(record);
  seen.metrics.push_back({"force_error", force_error.largest, "1", of_the_largest});
  seen.metrics.push_back({"bond_force_error", bond_error.largest, "1", of_the_largest});
  seen.metrics.push_back({"angle_force_error", angle_error.largest, "1", of_the_largest});
  seen.metrics.push_back({"bond_energy_error", bond_energy_error.largest, "1", of_the_largest});
  seen.metrics.push_back({"angle_energy_error", angle_energy_error.largest, "1", of_the_largest});
  count_rows(table, seen);
}

}  // namespace

engine::Study read_node_forces(const io::Section& top, const io::Section& compare) {
  const Body body = read_body(top, compare);
  const Table table(compare, "table", compare.text("table"));
  table.need(joined({"id", "e_bond", "e_angle"},
                    {xyz("", ""), xyz("f", ""), xyz("f", "_bond"), xyz("f", "_angle")}));
  const std::vector<Eigen::Index> node_of_row = nodes_of_rows(body, table, compare);
  if (static_cast<Eigen::Index>(node_of_row.size()) != body.network.node_count()) {
    compare.fail("table", fmt::format("the table has {} rows", node_of_row.size()),
                 fmt::format("it needs one for each of the {} atoms", body.network.node_count()),
                 "Give one configuration");
  }
  if (body.material.angle_stiffness == 0.0)
    throw InputError(top.place(), "the case lacks [angle]", "the table has forces of angles",
                     "Write [angle] and its stiffness");
  return {.plan = plan_of(body, "", false),
          .measures = {"force_error", "bond_force_error", "angle_force_error", "bond_energy_error",
                       "angle_energy_error", "rows", "clamped_rows"},
          .run = [=](Observations& seen, Progress&, engine::Cost&) {
            compare_nodes(body, table, node_of_row, seen);
          }};
}

}  // namespace veriflex::drivers::compare
