// Free motion from the first frame of the table on.

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "drivers/compare/body.hpp"
#include "drivers/compare/kinds.hpp"
#include "solid/leapfrog.hpp"
#include "solid/modes.hpp"

namespace veriflex::drivers::compare {

namespace {

using observe::Observations;
using observe::Record;

struct Motion {
  double time_step;    // [T]
  double node_mass;    // [M]
  std::int64_t early;  // the steps up to which `early_position_error` is measured
};

void compare_trajectory(const Body& body, const Table& table, const Table& energies,
                        const std::vector<Eigen::Index>& node_of_row, const Motion& motion,
                        Progress& progress, Observations& seen) {
  const solid::Network& network = body.network;
  const Eigen::Index nodes = network.node_count();
  const Positions peer_x = table.vectors("", "");
  const Positions peer_v = table.vectors("v", "");
  const auto frame = [&](const Positions& rows, std::size_t from) {
    return by_node(rows, node_of_row, from, nodes);
  };
  std::map<std::int64_t, std::size_t> frames;  // step and its first row
  for (std::size_t row = 0; row < table.rows(); row += static_cast<std::size_t>(nodes))
    frames[static_cast<std::int64_t>(table["step"][row])] = row;
  std::map<std::int64_t, std::size_t> energy_rows;
  for (std::size_t row = 0; row < energies.rows(); ++row)
    energy_rows[static_cast<std::int64_t>(energies["step"][row])] = row;
  const double largest_velocity = peer_v.rowwise().norm().maxCoeff();
  const double energy_scale = std::abs(energies["total"].front());

  Record record{
      "trajectory",
      "Free motion from the same start: this program and its peer",
      {{"step", "", "1", "time over the time step", {}},
       {"position_error", "", "1", "largest distance of a node's two positions over the spacing", {}},
       {"velocity_error",
        "",
        "1",
        "largest difference of a node's velocities over the largest velocity",
        {}}}};
  Record energy_record{
      "energy",
      "Energy of the free motion: this program and its peer",
      {{"step", "", "1", "time over the time step", {}},
       {"change", "", "1", "total energy over that at the start, less 1", {}},
       {"peer_change", "", "1", "the same of the peer", {}},
       {"energy_error", "", "1", "difference of the total energies over that at the start", {}}}};
  Largest position;
  Largest early;
  Largest velocity;
  Largest energy;
  Largest change;
  Largest peer_change;
  solid::Conditions conditions;
  conditions.node_mass = motion.node_mass;
  solid::Leapfrog run(body.material, network, conditions, motion.time_step, {},
                      frame(peer_x, 0) - network.rest, frame(peer_v, 0));
  const double energy_at_start = run.kinetic_energy() + run.potential_energy();
  const std::int64_t last = std::max(frames.rbegin()->first, energy_rows.rbegin()->first);
  for (;; run.step()) {
    const std::int64_t step = run.steps();
    if (const auto at = frames.find(step); at != frames.end()) {
      const Positions x = network.rest + run.displacement();
      const double off =
          (x - frame(peer_x, at->second)).rowwise().norm().maxCoeff<Eigen::PropagateNaN>() / network.spacing;
      const double off_v =
          (run.velocity() - frame(peer_v, at->second)).rowwise().norm().maxCoeff<Eigen::PropagateNaN>() /
          largest_velocity;
      position.add(off);
      if (step <= motion.early) early.add(off);
      velocity.add(off_v);
      record.append({static_cast<double>(step), off, off_v});
      progress.show("steps", static_cast<std::size_t>(step), static_cast<std::size_t>(last));
    }
    if (const auto at = energy_rows.find(step); at != energy_rows.end()) {
      const double total = run.kinetic_energy() + run.potential_energy();
      const double peer_total = energies["total"][at->second];
      energy.add((total - peer_total) / energy_scale);
      change.add((total - energy_at_start) / energy_scale);
      peer_change.add((peer_total - energies["total"].front()) / energy_scale);
      energy_record.append({static_cast<double>(step), (total - energy_at_start) / energy_scale,
                            (peer_total - energies["total"].front()) / energy_scale,
                            (total - peer_total) / energy_scale});
    }
    if (step == last) break;
  }
  seen.records.push_back(record);
  seen.records.push_back(energy_record);
  seen.metrics.push_back(
      {"early_position_error", early.value, "1",
       fmt::format("largest distance of a node's two positions over the spacing, up to step {}",
                   motion.early)});
  seen.metrics.push_back({"position_error", position.value, "1", "the same over all frames"});
  seen.metrics.push_back({"velocity_error", velocity.value, "1",
                          "largest difference of a node's velocities over the largest velocity, all frames"});
  seen.metrics.push_back(
      {"energy_error", energy.value, "1", "largest difference of the total energies over that at the start"});
  seen.metrics.push_back(
      {"energy_change", change.value, "1", "largest change of the total energy over that at the start"});
  seen.metrics.push_back({"peer_energy_change", peer_change.value, "1", "the same of the peer"});
  const double omega = solid::largest_frequency(body.material, network, Positions::Zero(nodes, 3),
                                                solid::Held::Constant(nodes, 3, false), motion.node_mass);
  seen.metrics.push_back({"dt_over_limit", 0.5 * omega * motion.time_step, "1",
                          "time step over the linear limit 2/omega_max at rest"});
  seen.metrics.push_back({"energy_rows", static_cast<double>(energy_record.columns.front().values.size()),
                          "1", "rows of the table of energies that were compared"});
  count_rows(table, seen);
}

}  // namespace

engine::Study read_trajectory(const io::Section& top, const io::Section& compare) {
  const Body body = read_body(top, compare);
  const Table table(compare, "table", compare.text("table"));
  table.need(joined({"step", "id"}, {xyz("", ""), xyz("v", "")}));
  const Table energies(compare, "energies", compare.text("energies"));
  energies.need({"step", "total"});
  const std::vector<Eigen::Index> node_of_row = nodes_of_rows(body, table, compare);
  const Motion motion{compare.number("time_step"), compare.number("node_mass", 1.0),
                      compare.has("early_steps") ? compare.integer("early_steps", 0, 1'000'000'000) : 10};
  const auto need_positive = [&](const std::string& key, double value) {
    if (value > 0.0) return;
    compare.fail(key, fmt::format("'{}' is {}", key, value), "it must be positive", "Give a positive number");
  };
  need_positive("time_step", motion.time_step);
  need_positive("node_mass", motion.node_mass);
  if (table["step"].front() != 0.0)
    compare.fail("table", fmt::format("the table begins at step {}", table["step"].front()),
                 "the motion starts from its first frame, step 0", "Keep the first frame");
  if (energies["step"].front() != 0.0)
    compare.fail("energies", fmt::format("the table begins at step {}", energies["step"].front()),
                 "energies are compared with that at step 0", "Keep the first row");
  return {.plan = plan_of(
              body, fmt::format("leap-frog, time step {}, node mass {}", motion.time_step, motion.node_mass),
              true),
          .measures = {"early_position_error", "position_error", "velocity_error", "energy_error",
                       "energy_change", "peer_energy_change", "dt_over_limit", "energy_rows", "rows",
                       "clamped_rows"},
          .run = [=](Observations& seen, Progress& progress, engine::Cost&) {
            compare_trajectory(body, table, energies, node_of_row, motion, progress, seen);
          }};
}

}  // namespace veriflex::drivers::compare
