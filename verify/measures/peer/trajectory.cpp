// Free motion from the first frame of the table on.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "base/error.hpp"
#include "engine/read_scene.hpp"
#include "measures/peer/body.hpp"
#include "measures/peer/kinds.hpp"
#include "solid/leapfrog.hpp"
#include "solid/modes.hpp"

namespace veriflex::measures::peer {

namespace {

using observe::Observations;

struct Motion {
  double time_step;    // [T]
  double node_mass;    // [M]
  std::int64_t early;  // the steps up to which `early_position_error` is measured
};

Observations trajectory_observations(const Motion& motion) {
  Observations all;
  all.records = {
      {"trajectory",
       "Free motion from the same start: this program and its peer",
       {{"step", "", "1", "time over the time step", {}},
        {"position_error", "", "1", "largest distance of a node's two positions over the spacing", {}},
        {"velocity_error",
         "",
         "1",
         "largest difference of a node's velocities over the largest velocity",
         {}}}},
      {"energy",
       "Energy of the free motion: this program and its peer",
       {{"step", "", "1", "time over the time step", {}},
        {"change", "", "1", "total energy over that at the start, less 1", {}},
        {"peer_change", "", "1", "the same of the peer", {}},
        {"energy_error", "", "1", "difference of the total energies over that at the start", {}}}}};
  all.metrics = {
      {"early_position_error",
       {},
       "1",
       fmt::format("largest distance of a node's two positions over the spacing, up to step {}",
                   motion.early)},
      {"position_error", {}, "1", "the same over all frames"},
      {"velocity_error",
       {},
       "1",
       "largest difference of a node's velocities over the largest velocity, all frames"},
      {"energy_error", {}, "1", "largest difference of the total energies over that at the start"},
      {"energy_change", {}, "1", "largest change of the total energy over that at the start"},
      {"peer_energy_change", {}, "1", "the same of the peer"},
      {"energy_rows", {}, "1", "rows of the table of energies that were compared"},
      {"dt_over_limit", {}, "1", "time step over the linear limit 2/omega_max of the data file's positions"}};
  declare_rows(all);
  return all;
}

void compare_trajectory(const Body& body, const PeerTable& table, const PeerTable& energies,
                        const std::vector<Eigen::Index>& node_of_row, const Motion& motion,
                        Progress& progress, Observations& seen) {
  const solid::Network& network = body.network;
  const Eigen::Index nodes = network.node_count();
  const Positions peer_x = table.vectors("", "");
  const Positions peer_v = table.vectors("v", "");
  const auto frame = [&](const Positions& rows, std::size_t from) {
    return by_node(rows, node_of_row, from, nodes);
  };
  const std::vector<std::int64_t> steps = table.counts("step");
  std::map<std::int64_t, std::size_t> frames;  // step and its first row
  for (std::size_t row = 0; row < table.rows(); row += static_cast<std::size_t>(nodes))
    frames[steps[row]] = row;
  const std::vector<std::int64_t> energy_steps = energies.counts("step");
  std::map<std::int64_t, std::size_t> energy_rows;
  for (std::size_t row = 0; row < energies.rows(); ++row) {
    if (!energies.clamped(row)) energy_rows[energy_steps[row]] = row;
  }
  Largest largest_velocity;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (!table.clamped(row)) largest_velocity.add(peer_v.row(static_cast<Eigen::Index>(row)).norm());
  }
  const double energy_scale = std::abs(energies["total"].front());

  observe::Record& record = seen.open("trajectory");
  observe::Record& energy_record = seen.open("energy");
  Largest position;
  Largest early;
  Largest velocity;
  Largest energy;
  Largest change;
  Largest peer_change;
  solid::Conditions conditions;
  conditions.node_mass = motion.node_mass;
  const double omega =
      solid::largest_frequency(body.material, network, Positions::Zero(nodes, 3),
                               solid::FixedDofs::Constant(nodes, 3, false), motion.node_mass);
  const double over_limit = 0.5 * omega * motion.time_step;
  seen.set("dt_over_limit", over_limit);
  if (over_limit >= 1.0) {
    progress.warn(fmt::format(
        "leap-frog is unstable: the time step is {:.4g} times the linear limit 2/omega_max", over_limit));
  }
  solid::Leapfrog run(body.material, network, conditions, motion.time_step, {},
                      frame(peer_x, 0) - network.rest, frame(peer_v, 0));
  const double energy_at_start = run.kinetic_energy() + run.potential_energy();
  const std::int64_t last = std::max(frames.rbegin()->first, energy_rows.rbegin()->first);
  std::size_t compared = 0;  // rows after the start
  for (;; run.step()) {
    const std::int64_t step = run.steps();
    if (const auto at = frames.find(step); at != frames.end()) {
      const Eigen::VectorXd off_by_node =
          (network.rest + run.displacement() - frame(peer_x, at->second)).rowwise().norm();
      const Eigen::VectorXd off_v_by_node = (run.velocity() - frame(peer_v, at->second)).rowwise().norm();
      double off = 0.0;
      double off_v = 0.0;
      for (std::size_t row = at->second; row < at->second + static_cast<std::size_t>(nodes); ++row) {
        if (table.clamped(row)) continue;
        if (step > 0) ++compared;
        off = worse(off, off_by_node[node_of_row[row]] / network.spacing);
        off_v = worse(off_v, relative_to(off_v_by_node[node_of_row[row]], largest_velocity.value));
      }
      position.add(off);
      if (step <= motion.early) early.add(off);
      velocity.add(off_v);
      record.append({static_cast<double>(step), off, off_v});
      progress.show("steps", static_cast<std::size_t>(step), static_cast<std::size_t>(last));
    }
    if (const auto at = energy_rows.find(step); at != energy_rows.end()) {
      const double total = run.kinetic_energy() + run.potential_energy();
      const double peer_total = energies["total"][at->second];
      if (step > 0) ++compared;
      const auto over_start = [&](double difference) {
        return std::copysign(relative_to(difference, energy_scale), difference);
      };
      energy.add(over_start(total - peer_total));
      change.add(over_start(total - energy_at_start));
      peer_change.add(over_start(peer_total - energies["total"].front()));
      energy_record.append({static_cast<double>(step), over_start(total - energy_at_start),
                            over_start(peer_total - energies["total"].front()),
                            over_start(total - peer_total)});
    }
    if (step == last) break;
  }
  // The first frame is where the motion starts: it agrees with itself.
  if (compared == 0)
    throw NumericalFailure("the tables have no frame after the first: no motion is compared");
  seen.set("early_position_error", early.value);
  seen.set("position_error", position.value);
  seen.set("velocity_error", velocity.value);
  seen.set("energy_error", energy.value);
  seen.set("energy_change", change.value);
  seen.set("peer_energy_change", peer_change.value);
  seen.set("energy_rows", static_cast<double>(energy_record.columns.front().size()));
  count_rows(table, seen);
}

// One frame after the other, each of one step: a row of another step would be compared with the wrong time.
void refuse_mixed_frames(const Body& body, const PeerTable& table) {
  constexpr std::int64_t last_step = 1'000'000'000;
  const auto nodes = static_cast<std::size_t>(body.network.node_count());
  const std::vector<std::int64_t> steps = table.counts("step");
  const std::vector<std::int64_t> ids = table.counts("id");
  for (std::size_t row = 0; row < steps.size(); ++row) {
    const std::size_t first = row - row % nodes;
    if (steps[row] != steps[first]) {
      table.fail(fmt::format("row {} (id {}) is of step {}", row + 1, ids[row], steps[row]),
                 fmt::format("it stands in the frame of step {}, which has one row for each of {} atoms",
                             steps[first], nodes),
                 "Sort the table by steps, and complete its frames");
    }
    if (row == first && row > 0 && steps[row] <= steps[row - 1]) {
      table.fail(fmt::format("the frame of step {} follows that of step {}", steps[row], steps[row - 1]),
                 "steps rise from frame to frame", "Sort the table by steps");
    }
  }
  if (steps.back() > last_step) {
    table.fail(fmt::format("the last frame is that of step {}", steps.back()),
               fmt::format("{} steps are the limit", last_step), "Cut the table");
  }
}

// The case's, which must agree with the data file's; else the data file's; else 1.
double node_mass_of(const Body& body, const io::Table& peer) {
  const std::optional<double> given = peer.number_if("node_mass");
  if (given && body.node_mass && std::abs(*given - *body.node_mass) > 1e-6 * *body.node_mass) {
    peer.fail("node_mass", fmt::format("'node_mass' is {}", *given),
              fmt::format("the data file's atoms have mass {}", *body.node_mass),
              "Leave it out, or correct the one or the other");
  }
  return given.value_or(body.node_mass.value_or(1.0));
}

}  // namespace

engine::Study read_trajectory(const io::Table& top, const io::Table& peer) {
  const Body body = read_body(top, peer);
  const PeerTable table(peer, "table", peer.text("table"));
  table.need(joined({"step", "id"}, {xyz("", ""), xyz("v", "")}));
  const PeerTable energies(peer, "energies", peer.text("energies"));
  energies.need({"step", "total"});
  const std::vector<Eigen::Index> node_of_row = nodes_of_rows(body, table, peer);
  refuse_mixed_frames(body, table);
  const Motion motion{peer.number("time_step"), node_mass_of(body, peer),
                      peer.has("early_steps") ? peer.integer("early_steps", 0, 1'000'000'000) : 10};
  engine::need_positive(peer, "time_step", motion.time_step, "Give a positive number");
  engine::need_positive(peer, "node_mass", motion.node_mass, "Give a positive number");
  if (table["step"].front() != 0.0)
    peer.fail("table", fmt::format("the table begins at step {}", table["step"].front()),
              "the motion starts from its first frame, step 0", "Keep the first frame");
  const std::vector<std::int64_t> energy_steps = energies.counts("step");
  if (std::adjacent_find(energy_steps.begin(), energy_steps.end(), std::greater_equal<>{}) !=
      energy_steps.end())
    energies.fail("the steps of the energies do not rise", "each step has one row", "Mend the table");
  if (energies["step"].front() != 0.0)
    peer.fail("energies", fmt::format("the table begins at step {}", energies["step"].front()),
              "energies are compared with that at step 0", "Keep the first row");
  return {.plan = plan_of(
              body, fmt::format("leap-frog, time step {}, node mass {}", motion.time_step, motion.node_mass),
              {parts::Kind::LeapFrog}),
          .declares = trajectory_observations(motion),
          .run = [=](Observations& seen, Progress& progress, engine::Cost&) {
            warn(body, progress);
            compare_trajectory(body, table, energies, node_of_row, motion, progress, seen);
          }};
}

}  // namespace veriflex::measures::peer
