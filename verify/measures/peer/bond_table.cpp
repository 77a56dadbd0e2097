// One bond at the lengths of the table's rows.

#include <fmt/format.h>

#include "base/error.hpp"
#include "engine/read_scene.hpp"
#include "measures/peer/kinds.hpp"
#include "measures/peer/table.hpp"

namespace veriflex::measures::peer {

namespace {

using observe::Observations;

Observations bond_table_observations(const PeerTable& table) {
  Observations all;
  all.records = {{"bond_table",
                  "One bond: this program and its peer",
                  {{"r", "r", "L", "length of the bond", {}},
                   {"force", "", "M L T^-2", "force, positive where the ends repel each other", {}},
                   {"peer_force", "", "M L T^-2", "the same of the peer", {}},
                   {"energy", "U", "M L^2 T^-2", "energy", {}},
                   {"peer_energy", "", "M L^2 T^-2", "the same of the peer", {}},
                   {"force_error", "", "1", "error over the largest force of the table", {}},
                   {"energy_error", "", "1", "error over the largest energy of the table", {}},
                   {"clamped", "", "1", "1 where the peer does not compute the stated potential", {}}}}};
  all.metrics = {{"force_error", {}, "1", of_the_largest}, {"energy_error", {}, "1", of_the_largest}};
  if (table.has_clamped()) {
    all.metrics.push_back(
        {"clamped_force_error", {}, "1", "the same over the rows left out that lie in the law's domain"});
  }
  declare_rows(all);
  return all;
}

void compare_bond(const bond::AnyLaw& law, const PeerTable& table, Observations& seen) {
  const Interval domain = bond::domain(law);
  std::vector<double> energy;
  std::vector<double> force;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double r = table["r"][i];
    if (!domain.contains(r)) {
      if (table.clamped(i)) {
        energy.push_back(unanswered);
        force.push_back(unanswered);
        continue;
      }
      throw NumericalFailure(fmt::format("length {} of the table is outside the domain of {}, {} to {}", r,
                                         bond::name_of(law), domain.lo, domain.hi));
    }
    energy.push_back(bond::energy(law, r));
    force.push_back(-bond::tension(law, r));
  }
  const Errors energy_error = table.errors(energy, "energy");
  const Errors force_error = table.errors(force, "force");
  observe::Record& record = seen.open("bond_table");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    record.append({table["r"][i], force[i], table["force"][i], energy[i], table["energy"][i],
                   force_error.by_row[i], energy_error.by_row[i], table.clamped(i) ? 1.0 : 0.0});
  }
  seen.set("force_error", force_error.largest);
  seen.set("energy_error", energy_error.largest);
  if (table.has_clamped()) seen.set("clamped_force_error", force_error.largest_clamped.value_or(unanswered));
  count_rows(table, seen);
}

}  // namespace

engine::Study read_bond_table(const io::Table& top, const io::Table& peer) {
  const bond::AnyLaw law = engine::read_law(top);
  const PeerTable table(peer, "table", peer.text("table"));
  table.need({"r", "energy", "force"});
  return {.plan = scene::plan({.law = law, .solid = std::nullopt}),
          .declares = bond_table_observations(table),
          .run = [=](Observations& seen, Progress&, engine::Cost&) { compare_bond(law, table, seen); }};
}

}  // namespace veriflex::measures::peer
