// A bar whose first layers are clamped, with a transverse force along x on each node of the last.

#include <cmath>

#include "drivers/compare/body.hpp"
#include "drivers/compare/kinds.hpp"
#include "drivers/compare/layers.hpp"

namespace veriflex::drivers::compare {

namespace {

using observe::Observations;
using observe::Record;

void compare_cantilever(const Body& body, const Table& table, std::size_t clamped_layers, Progress& progress,
                        Observations& seen) {
  const solid::Network& network = body.network;
  const auto layers = layers_of(network);
  const std::vector<Eigen::Index>& last = layers.back();
  solid::Held held = solid::Held::Constant(network.node_count(), 3, false);
  for (std::size_t i = 0; i < clamped_layers; ++i) hold(held, layers[i], {x_axis, y_axis, z_axis});
  const auto nodes = static_cast<double>(last.size());
  const double rest_x = sum_over(network.rest, last, x_axis) / nodes;
  const double rest_z = sum_over(network.rest, last, z_axis) / nodes;

  Positions u =
      Positions::Zero(network.node_count(), 3);  // each load starts from the state of the one before
  std::vector<double> deflection;
  std::vector<double> peer_deflection;
  std::vector<double> off;  // distance of the tips over the peer's deflection
  std::vector<double> reaction;
  std::vector<double> energy;
  Largest residual;
  Positions unused;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    progress.show("loads", i, table.rows());
    Positions load = Positions::Zero(u.rows(), 3);
    for (const Eigen::Index node : last) load(node, x_axis) = table["force_per_node"][i];
    const solid::Equilibrium e = solid::equilibrium(body.material, network, u, held, load);
    u = e.u;
    const double tip_x = rest_x + sum_over(u, last, x_axis) / nodes;
    const double tip_z = rest_z + sum_over(u, last, z_axis) / nodes;
    deflection.push_back(tip_x - rest_x);
    peer_deflection.push_back(table["tip_x"][i] - rest_x);
    off.push_back(std::hypot(tip_x - table["tip_x"][i], tip_z - table["tip_z"][i]) /
                  std::abs(peer_deflection.back()));
    double on_clamp = 0.0;
    for (std::size_t layer = 0; layer < clamped_layers; ++layer)
      on_clamp -= sum_over(e.reaction, layers[layer], x_axis);
    reaction.push_back(on_clamp);
    energy.push_back(evaluate(body.material, network, u, unused));
    residual.add(e.residual);
  }
  const std::vector<double> peer_energy = plus(table["e_bond"], table["e_angle"]);
  const Errors energy_error = relative_errors(minus(energy, peer_energy), peer_energy, table);
  const Errors reaction_error =
      relative_errors(minus(reaction, table["clamp_reaction_x"]), table["clamp_reaction_x"], table);
  Record record{"cantilever",
                "Clamped bar under a transverse load: this program and its peer",
                {{"load", "", "M L T^-2", "force along x on each node of the last layer", {}},
                 {"deflection", "", "L", "mean displacement of the last layer along x", {}},
                 {"peer_deflection", "", "L", "the same of the peer", {}},
                 {"tip_error", "", "1", "distance of the two tips over the deflection", {}},
                 {"reaction_error", "", "1", "error of the force on the clamp over the largest", {}},
                 {"energy_error", "", "1", "error of the elastic energy over the largest", {}}}};
  Largest tip;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (!table.clamped(i)) tip.add(off[i]);
    record.append({table["force_per_node"][i], deflection[i], peer_deflection[i], off[i],
                   reaction_error.by_row[i], energy_error.by_row[i]});
  }
  seen.records.push_back(record);
  seen.metrics.push_back(
      {"tip_error", tip.value, "1", "largest distance of the two tips over the deflection"});
  seen.metrics.push_back({"reaction_error", reaction_error.largest, "1", of_the_largest});
  seen.metrics.push_back({"energy_error", energy_error.largest, "1", of_the_largest});
  seen.metrics.push_back({"largest_residual", residual.value, "1",
                          "largest out-of-balance force over the largest tension, all states"});
  count_rows(table, seen);
}

}  // namespace

engine::Study read_cantilever(const io::Section& top, const io::Section& compare) {
  const Body body = read_body(top, compare);
  const Table table(compare, "table", compare.text("table"));
  table.need({"force_per_node", "tip_x", "tip_z", "e_bond", "e_angle", "clamp_reaction_x"});
  const auto layers = static_cast<std::int64_t>(layers_of(body.network).size());
  if (layers < 2)
    compare.fail("data", "all nodes have the same z", "the bar is clamped at its lowest layers",
                 "Turn the body");
  const auto clamped = static_cast<std::size_t>(compare.integer("clamped_layers", 1, layers - 1));
  return {
      .plan = plan_of(body, newton, false),
      .measures = {"tip_error", "reaction_error", "energy_error", "largest_residual", "rows", "clamped_rows"},
      .run = [=](Observations& seen, Progress& progress, engine::Cost&) {
        compare_cantilever(body, table, clamped, progress, seen);
      }};
}

}  // namespace veriflex::drivers::compare
