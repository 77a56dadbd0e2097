// A bar whose end layers are fixed along z at each strain of the table, free across it.

#include <algorithm>

#include "measures/peer/body.hpp"
#include "measures/peer/kinds.hpp"
#include "measures/peer/layers.hpp"

namespace veriflex::measures::peer {

namespace {

using observe::Observations;

Observations tensile_table_observations() {
  Observations all;
  all.records = {{"end_force",
                  "Force of the pulled bar on its ends: this program and its peer",
                  {{"strain", "", "1", "change of length over undeformed length", {}},
                   {"force", "", "M L T^-2", "force of bonds and angles on the first layer along z", {}},
                   {"peer_force", "", "M L T^-2", "the same of the peer", {}},
                   {"force_error", "", "1", "error over the largest force, first layer", {}},
                   {"last_layer_error", "", "1", "the same of the last layer", {}},
                   {"energy", "U", "M L^2 T^-2", "elastic energy", {}},
                   {"peer_energy", "", "M L^2 T^-2", "the same of the peer", {}},
                   {"energy_error", "", "1", "error over the largest energy", {}}}}};
  all.metrics = {{"force_error", {}, "1", "largest error over the largest force, both ends"},
                 {"energy_error", {}, "1", of_the_largest},
                 {"max_residual", {}, "1", of_all_states}};
  declare_rows(all);
  return all;
}

// Holds what else could shift across z and turn about it; no force is needed for that.
void hold_in_plane(solid::FixedDofs& held, const solid::Network& network) {
  const Eigen::VectorXd dx = (network.rest.col(x_axis).array() - network.rest(0, x_axis)).matrix();
  const Eigen::VectorXd dy = (network.rest.col(y_axis).array() - network.rest(0, y_axis)).matrix();
  Eigen::Index far = 0;
  (dx.cwiseAbs2() + dy.cwiseAbs2()).maxCoeff(&far);
  held(0, x_axis) = held(0, y_axis) = true;
  if (far != 0) held(far, std::abs(dx[far]) >= std::abs(dy[far]) ? y_axis : x_axis) = true;
}

void compare_tensile(const Body& body, const PeerTable& table, Progress& progress, Observations& seen) {
  const solid::Network& network = body.network;
  const auto layers = layers_of(network);
  const double bottom = network.rest(layers.front().front(), z_axis);
  const double length = network.rest(layers.back().front(), z_axis) - bottom;
  solid::FixedDofs held = solid::FixedDofs::Constant(network.node_count(), 3, false);
  hold(held, layers.front(), {z_axis});
  hold(held, layers.back(), {z_axis});
  hold_in_plane(held, network);

  std::vector<double> force_bottom(table.rows(), unanswered);
  std::vector<double> force_top = force_bottom;
  std::vector<double> energy = force_bottom;
  Largest residual;
  Positions unused;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (table.clamped(i)) continue;
    const double strain = table["strain"][i];
    progress.show("strains", i, table.rows());
    Positions u = Positions::Zero(network.node_count(), 3);
    u.col(z_axis) = strain * (network.rest.col(z_axis).array() - bottom);
    for (const Eigen::Index node : layers.back()) u(node, z_axis) = strain * length;
    const solid::Equilibrium e =
        solid::equilibrium(body.material, network, u, held, Positions::Zero(u.rows(), 3));
    solid::refuse_turned_bonds(network, e.u);
    // The peer's force is that of the network on the layer, ours that of the hold on the network.
    force_bottom[i] = -sum_over(e.reaction, layers.front(), z_axis);
    force_top[i] = -sum_over(e.reaction, layers.back(), z_axis);
    energy[i] = evaluate(body.material, network, e.u, unused);
    residual.add(e.residual);
  }
  const std::vector<double> peer_energy = plus(table["e_bond"], table["e_angle"]);
  const Errors bottom_error = table.errors(force_bottom, "force_bottom");
  const Errors top_error = table.errors(force_top, "force_top");
  const Errors energy_error = relative_errors(minus(energy, peer_energy), peer_energy, table.clamped());
  observe::Record& record = seen.open("end_force");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    record.append({table["strain"][i], force_bottom[i], table["force_bottom"][i], bottom_error.by_row[i],
                   top_error.by_row[i], energy[i], peer_energy[i], energy_error.by_row[i]});
  }
  seen.set("force_error", worse(bottom_error.largest, top_error.largest));
  seen.set("energy_error", energy_error.largest);
  seen.set("max_residual", residual.value);
  count_rows(table, seen);
}

}  // namespace

engine::Study read_tensile_table(const io::Table& top, const io::Table& peer) {
  const Body body = read_body(top, peer);
  const PeerTable table(peer, "table", peer.text("table"));
  table.need({"strain", "force_bottom", "force_top", "e_bond", "e_angle"});
  require_statics(body.network, 1, true, peer);
  return {.plan = plan_of(body, newton, {parts::Kind::Statics}),
          .declares = tensile_table_observations(),
          .run = [=](Observations& seen, Progress& progress, engine::Cost&) {
            warn(body, progress);
            compare_tensile(body, table, progress, seen);
          }};
}

}  // namespace veriflex::measures::peer
