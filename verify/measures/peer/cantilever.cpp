// A bar whose first layers are clamped, with a transverse force along x on each node of the last.

#include <algorithm>
#include <cmath>

#include "measures/peer/body.hpp"
#include "measures/peer/kinds.hpp"
#include "measures/peer/layers.hpp"

namespace veriflex::measures::peer {

namespace {

using observe::Observations;

Observations cantilever_observations() {
  Observations all;
  all.records = {{"cantilever",
                  "Clamped bar under a transverse load: this program and its peer",
                  {{"load", "", "M L T^-2", "force along x on each node of the last layer", {}},
                   {"deflection", "", "L", "mean displacement of the last layer along x", {}},
                   {"peer_deflection", "", "L", "the same of the peer", {}},
                   {"tip_error",
                    "",
                    "1",
                    "distance of the two tips over the peer's deflection, or the largest where there is none",
                    {}},
                   {"reaction_error", "", "1", "error of the force on the clamp over the largest", {}},
                   {"energy_error", "", "1", "error of the elastic energy over the largest", {}}}}};
  all.metrics = {{"tip_error", {}, "1", "largest distance of the two tips over the peer's deflection"},
                 {"reaction_error", {}, "1", of_the_largest},
                 {"energy_error", {}, "1", of_the_largest},
                 {"max_residual", {}, "1", of_all_states}};
  declare_rows(all);
  return all;
}

// The rows that are compared, by their loads away from zero: first the negative ones, then the others.
std::vector<std::size_t> by_rising_load(const PeerTable& table) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (!table.clamped(i)) order.push_back(i);
  }
  const std::vector<double>& force = table["force_per_node"];
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const bool a_is_positive = force[a] > 0.0, b_is_positive = force[b] > 0.0;
    return a_is_positive != b_is_positive ? b_is_positive : std::abs(force[a]) < std::abs(force[b]);
  });
  return order;
}

void compare_cantilever(const Body& body, const PeerTable& table, std::size_t clamped_layers,
                        Progress& progress, Observations& seen) {
  const solid::Network& network = body.network;
  const auto layers = layers_of(network);
  const std::vector<Eigen::Index>& last = layers.back();
  solid::FixedDofs held = solid::FixedDofs::Constant(network.node_count(), 3, false);
  for (std::size_t i = 0; i < clamped_layers; ++i) hold(held, layers[i], {x_axis, y_axis, z_axis});
  const auto nodes = static_cast<double>(last.size());
  const double rest_x = sum_over(network.rest, last, x_axis) / nodes;
  const double rest_z = sum_over(network.rest, last, z_axis) / nodes;

  std::vector<double> peer_deflection;
  Largest deflected;  // of the peer
  for (std::size_t i = 0; i < table.rows(); ++i) {
    peer_deflection.push_back(table["tip_x"][i] - rest_x);
    if (!table.clamped(i)) deflected.add(peer_deflection.back());
  }
  // Where the peer does not deflect there is nothing to be relative to but the largest deflection of the
  // table or, without any, a bond.
  const double unbent = 1e-9 * network.spacing;
  const double otherwise = deflected.value > unbent ? deflected.value : network.spacing;

  std::vector<double> deflection(table.rows(), unanswered);
  std::vector<double> off = deflection;  // distance of the tips over the peer's deflection
  std::vector<double> reaction = deflection;
  std::vector<double> energy = deflection;
  Largest residual;
  Positions unused;
  // Whatever the order of the table, each load starts from the state of the next smaller one of its sign.
  Positions u = Positions::Zero(network.node_count(), 3);
  std::size_t done = 0;
  bool positive = false;
  for (const std::size_t i : by_rising_load(table)) {
    progress.show("loads", done++, table.rows());
    if (table["force_per_node"][i] > 0.0 && !positive) u.setZero();
    positive = table["force_per_node"][i] > 0.0;
    Positions load = Positions::Zero(u.rows(), 3);
    for (const Eigen::Index node : last) load(node, x_axis) = table["force_per_node"][i];
    const solid::Equilibrium e = solid::equilibrium(body.material, network, u, held, load);
    u = e.u;
    const double tip_x = rest_x + sum_over(u, last, x_axis) / nodes;
    const double tip_z = rest_z + sum_over(u, last, z_axis) / nodes;
    deflection[i] = tip_x - rest_x;
    const double bent = std::abs(peer_deflection[i]);
    off[i] =
        std::hypot(tip_x - table["tip_x"][i], tip_z - table["tip_z"][i]) / (bent > unbent ? bent : otherwise);
    double on_clamp = 0.0;
    for (std::size_t layer = 0; layer < clamped_layers; ++layer)
      on_clamp -= sum_over(e.reaction, layers[layer], x_axis);
    reaction[i] = on_clamp;
    energy[i] = evaluate(body.material, network, u, unused);
    residual.add(e.residual);
  }
  const std::vector<double> peer_energy = plus(table["e_bond"], table["e_angle"]);
  const Errors energy_error = relative_errors(minus(energy, peer_energy), peer_energy, table.clamped());
  const Errors reaction_error = table.errors(reaction, "clamp_reaction_x");
  observe::Record& record = seen.open("cantilever");
  Largest tip;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (!table.clamped(i)) tip.add(off[i]);
    record.append({table["force_per_node"][i], deflection[i], peer_deflection[i], off[i],
                   reaction_error.by_row[i], energy_error.by_row[i]});
  }
  seen.set("tip_error", tip.value);
  seen.set("reaction_error", reaction_error.largest);
  seen.set("energy_error", energy_error.largest);
  seen.set("max_residual", residual.value);
  count_rows(table, seen);
}

}  // namespace

engine::Study read_cantilever(const io::Table& top, const io::Table& peer) {
  const Body body = read_body(top, peer);
  const PeerTable table(peer, "table", peer.text("table"));
  table.need({"force_per_node", "tip_x", "tip_z", "e_bond", "e_angle", "clamp_reaction_x"});
  const auto layers = static_cast<std::int64_t>(layers_of(body.network).size());
  const auto clamped =
      static_cast<std::size_t>(peer.integer("clamped_layers", 1, std::max<std::int64_t>(1, layers - 1)));
  require_statics(body.network, clamped, false, peer);
  return {.plan = plan_of(body, newton, {parts::Kind::Statics}),
          .declares = cantilever_observations(),
          .run = [=](Observations& seen, Progress& progress, engine::Cost&) {
            warn(body, progress);
            compare_cantilever(body, table, clamped, progress, seen);
          }};
}

}  // namespace veriflex::measures::peer
