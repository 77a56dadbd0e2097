// One angle at the positions of its three nodes in the table's rows, the second the apex.

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "base/error.hpp"
#include "engine/read_scene.hpp"
#include "measures/peer/body.hpp"
#include "measures/peer/kinds.hpp"

namespace veriflex::measures::peer {

namespace {

using observe::Observations;

Observations angle_table_observations(const PeerTable& table) {
  Observations all;
  all.records = {
      {"angle_table",
       "One angle: this program and its peer",
       {{"theta", "", "1", "opening in degrees", {}},
        {"force", "", "M L T^-2", "largest of the nine components of force", {}},
        {"peer_force", "", "M L T^-2", "the same of the peer", {}},
        {"energy", "U", "M L^2 T^-2", "energy", {}},
        {"peer_energy", "", "M L^2 T^-2", "the same of the peer", {}},
        {"force_error", "", "1", "largest error of a component over the largest component of the table", {}},
        {"energy_error", "", "1", "error over the largest energy of the table", {}},
        {"clamped", "", "1", "1 where the peer does not compute the stated potential", {}}}}};
  all.metrics = {{"force_error", {}, "1", of_the_largest}, {"energy_error", {}, "1", of_the_largest}};
  if (table.has_clamped()) {
    all.metrics.push_back(
        {"clamped_force_error",
         {},
         "1",
         "over the rows left out that have an answer, relative to each row's own largest component"});
  }
  declare_rows(all);
  return all;
}

void compare_angle(double stiffness, bool straight, const PeerTable& table, Observations& seen) {
  const auto rows = static_cast<Eigen::Index>(table.rows());
  const std::array<Positions, 3> at{table.vectors("", "1"), table.vectors("", "2"), table.vectors("", "3")};
  const std::array<Positions, 3> peer{table.vectors("f", "1"), table.vectors("f", "2"),
                                      table.vectors("f", "3")};
  std::vector<double> energy;
  std::vector<double> off(table.rows(), 0.0);  // largest difference of a component
  std::vector<double> force;                   // largest component
  std::vector<double> peer_force;
  for (Eigen::Index i = 0; i < rows; ++i) {
    solid::Network network;
    network.rest.resize(3, 3);
    for (int node = 0; node < 3; ++node) network.rest.row(node) = at[static_cast<std::size_t>(node)].row(i);
    network.bonds = {{0, 1}, {1, 2}};
    network.vectors.resize(2, 3);
    network.vectors.row(0) = network.rest.row(1) - network.rest.row(0);
    network.vectors.row(1) = network.rest.row(2) - network.rest.row(1);
    network.angles = {{0, 1, -1, 1, straight}};
    network.spacing = network.vectors.row(0).norm();
    const auto row = static_cast<std::size_t>(i);
    Positions gradient = Positions::Constant(3, 3, unanswered);
    try {
      energy.push_back(evaluate({slack, stiffness}, network, Positions::Zero(3, 3), gradient));
    } catch (const NumericalFailure& failure) {
      if (!table.clamped(row)) throw failure.at(fmt::format("row {}", i + 1));
      energy.push_back(unanswered);
      gradient.setConstant(unanswered);
    }
    Largest ours;
    Largest theirs;
    Largest difference;
    for (int node = 0; node < 3; ++node) {
      for (int axis = 0; axis < 3; ++axis) {
        const double wanted = peer[static_cast<std::size_t>(node)](i, axis);
        ours.add(gradient(node, axis));
        theirs.add(wanted);
        difference.add(-gradient(node, axis) - wanted);
      }
    }
    force.push_back(ours.value);
    peer_force.push_back(theirs.value);
    off[row] = difference.value;
  }
  const Errors energy_error = table.errors(energy, "energy");
  const Errors force_error = relative_errors(off, peer_force, table.clamped());
  observe::Record& record = seen.open("angle_table");
  double clamped_relative = unanswered;  // of rows left out that have an answer
  for (std::size_t i = 0; i < table.rows(); ++i) {
    record.append({table["theta"][i], force[i], peer_force[i], energy[i], table["energy"][i],
                   force_error.by_row[i], energy_error.by_row[i], table.clamped(i) ? 1.0 : 0.0});
    if (table.clamped(i) && !std::isnan(off[i]))
      clamped_relative =
          worse(std::isnan(clamped_relative) ? 0.0 : clamped_relative, relative_to(off[i], force[i]));
  }
  seen.set("force_error", force_error.largest);
  seen.set("energy_error", energy_error.largest);
  if (table.has_clamped()) seen.set("clamped_force_error", clamped_relative);
  count_rows(table, seen);
}

}  // namespace

engine::Study read_angle_table(const io::Table& top, const io::Table& peer) {
  const double stiffness = engine::read_angle_stiffness(top);
  if (stiffness == 0.0)
    throw InputError(top.place(), "the case lacks [angle]", "its stiffness decides the forces",
                     "Write [angle] and stiffness = 1.0");
  const std::int64_t rest_angle = peer.integer("rest_angle", 90, 180);
  if (rest_angle != 90 && rest_angle != 180) {
    peer.fail("rest_angle", fmt::format("'rest_angle' is {}", rest_angle), "angles rest at 90 or 180 degrees",
              "Choose one of these");
  }
  const PeerTable table(peer, "table", peer.text("table"));
  table.need(joined({"theta", "energy"},
                    {xyz("", "1"), xyz("", "2"), xyz("", "3"), xyz("f", "1"), xyz("f", "2"), xyz("f", "3")}));
  return {.plan = {.built = {{"angle",
                              fmt::format("one angle of stiffness {}, at rest at {} degrees", stiffness,
                                          rest_angle),
                              0.0,
                              {parts::Kind::Bonds, parts::Kind::Angles}}},
                   .left_out = {{"forces of bonds", "the table is about one angle alone"}}},
          .declares = angle_table_observations(table),
          .run = [=](Observations& seen, Progress&, engine::Cost&) {
            compare_angle(stiffness, rest_angle == 180, table, seen);
          }};
}

}  // namespace veriflex::measures::peer
