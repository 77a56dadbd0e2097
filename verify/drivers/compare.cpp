// The solid against tables that another program computed. One kind of comparison per question that such a
// program can answer; each measures how far this program is off, over the largest of what is compared. Rows
// in which the other program is known not to compute the stated potential carry `clamped` = 1: they are
// measured on their own and do not enter the errors.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "drivers/drivers.hpp"
#include "engine/read_scene.hpp"
#include "engine/reference.hpp"
#include "repository.hpp"
#include "scene/lammps_network.hpp"
#include "solid/leapfrog.hpp"
#include "solid/statics.hpp"

namespace veriflex::drivers {

namespace {

namespace fs = std::filesystem;
using observe::Metric;
using observe::Observations;
using observe::Record;
using solid::HarmonicAngle;
using solid::Held;
using solid::Material;
using solid::Network;
using solid::NoAngle;
using solid::Workspace;

constexpr int x_axis = 0, y_axis = 1, z_axis = 2;

// Bonds that carry no force, so that the loops of the solid yield the angles' part alone.
struct Slack {
  static constexpr std::string_view name = "slack";
  static constexpr std::array<bond::Parameter<Slack>, 0> parameters() { return {}; }
  double energy(double) const { return 0.0; }
  double tension(double) const { return 0.0; }
  double stiffness(double) const { return 0.0; }
  Interval domain() const { return {0.0, bond::infinity}; }
  double typical_length() const { return 1.0; }
  void check() const {}
};
static_assert(bond::BondLaw<Slack>);

// The table of a reference, whose columns are asked for by name.
class Table {
 public:
  Table(const io::Section& compare, const std::string& key, const std::string& id) {
    const fs::path beside = fs::path(compare.place().file).parent_path();
    reference_ = engine::find_reference(id, beside, repository::references, compare.place(key));
    if (reference_.columns.empty()) {
      compare.fail(key, fmt::format("reference '{}' has no table", reference_.id),
                   "its rows are what is compared", "Name a reference with [data]");
    }
  }

  // All columns that a kind needs, or an error at the case's key.
  void need(const io::Section& compare, const std::string& key, const std::vector<std::string>& names) const {
    for (const std::string& name : names) {
      if (find(name) != nullptr) continue;
      std::vector<std::string> has;
      for (const io::CsvColumn& column : reference_.columns) has.push_back(column.name);
      compare.fail(key, fmt::format("the table of '{}' has no column '{}'", reference_.id, name),
                   fmt::format("it has: {}; needed: {}", fmt::join(has, ", "), fmt::join(names, ", ")),
                   "Look at the kind of comparison and at the table");
    }
  }

  const std::vector<double>& operator[](const std::string& name) const { return *find(name); }
  std::size_t rows() const { return reference_.columns.front().values.size(); }

  // Columns `prefix` + x, y, z + `suffix` as vectors.
  Positions vectors(const std::string& prefix, const std::string& suffix) const {
    Positions all(static_cast<Eigen::Index>(rows()), 3);
    for (int axis = 0; axis < 3; ++axis) {
      const std::vector<double>& values = (*this)[prefix + "xyz"[axis] + suffix];
      for (std::size_t i = 0; i < rows(); ++i) all(static_cast<Eigen::Index>(i), axis) = values[i];
    }
    return all;
  }

  bool clamped(std::size_t row) const {
    const std::vector<double>* flags = find("clamped");
    return flags != nullptr && (*flags)[row] != 0.0;
  }

 private:
  const std::vector<double>* find(const std::string& name) const {
    for (const io::CsvColumn& column : reference_.columns) {
      if (column.name == name) return &column.values;
    }
    return nullptr;
  }

  engine::Reference reference_;
};

std::vector<std::string> xyz(const std::string& prefix, const std::string& suffix) {
  return {prefix + "x" + suffix, prefix + "y" + suffix, prefix + "z" + suffix};
}

// The largest of what was added; a NaN stays.
struct Largest {
  double value = 0.0;
  void add(double x) {
    if (!(std::abs(x) <= value)) value = std::abs(x);
  }
};

// Errors of one quantity over the rows, relative to the largest magnitude that the peer has in a row that
// counts.
struct Errors {
  std::vector<double> by_row;
  double largest = 0.0;          // over the rows that count
  double largest_clamped = 0.0;  // over the others
};

Errors relative_errors(const std::vector<double>& difference, const std::vector<double>& peer,
                       const Table& table) {
  Largest scale;
  for (std::size_t i = 0; i < peer.size(); ++i) {
    if (!table.clamped(i)) scale.add(peer[i]);
  }
  Largest counted;
  Largest clamped;
  Errors errors;
  for (std::size_t i = 0; i < peer.size(); ++i) {
    errors.by_row.push_back(std::abs(difference[i]) / scale.value);
    (table.clamped(i) ? clamped : counted).add(errors.by_row.back());
  }
  errors.largest = counted.value;
  errors.largest_clamped = clamped.value;
  return errors;
}

std::vector<double> minus(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

std::vector<double> lengths(const Positions& vectors) {
  const Eigen::VectorXd norms = vectors.rowwise().norm();
  return {norms.begin(), norms.end()};
}

void count_rows(const Table& table, Observations& seen) {
  std::size_t clamped = 0;
  for (std::size_t i = 0; i < table.rows(); ++i) clamped += table.clamped(i);
  seen.metrics.push_back(
      {"rows", static_cast<double>(table.rows() - clamped), "1", "rows that were compared"});
  seen.metrics.push_back({"clamped_rows", static_cast<double>(clamped), "1",
                          "rows left out: the peer does not compute the stated potential there"});
}

const char* const of_the_largest = "largest error over the largest magnitude in the peer's table";

// Energy and gradient of the law and angle at displacement u.
template <bond::BondLaw Law, class AngleTerm>
double evaluate(const Law& law, const AngleTerm& angle, const Network& network, const Positions& u,
                Positions& gradient) {
  Workspace work;
  if (!solid::deform(law, network, u, work) || !solid::gradient(law, angle, network, work, gradient)) {
    throw NumericalFailure(fmt::format(
        "a bond of the table's configuration is outside the domain of {}, or an angle is degenerate",
        Law::name));
  }
  return solid::energy(law, angle, network, work);
}

double energy_at(const Material& material, const Network& network, const Positions& u) {
  Positions unused;
  return solid::visit(
      material, [&](const auto& law, const auto& angle) { return evaluate(law, angle, network, u, unused); });
}

// ---- bond-table: one bond at the rows' lengths

Observations compare_bond(const bond::AnyLaw& law, const Table& table) {
  const Interval domain = bond::domain(law);
  std::vector<double> energy;
  std::vector<double> force;
  for (const double r : table["r"]) {
    if (!domain.contains(r)) {
      throw NumericalFailure(fmt::format("length {} of the table is outside the domain of {}, {} to {}", r,
                                         bond::name_of(law), domain.lo, domain.hi));
    }
    energy.push_back(bond::energy(law, r));
    force.push_back(-bond::tension(law, r));
  }
  const Errors energy_error = relative_errors(minus(energy, table["energy"]), table["energy"], table);
  const Errors force_error = relative_errors(minus(force, table["force"]), table["force"], table);
  Observations seen;
  Record record{"bond_table",
                "One bond: this program and its peer",
                {{"r", "r", "L", "length of the bond", {}},
                 {"force", "", "M L T^-2", "force, positive where the ends repel each other", {}},
                 {"peer_force", "", "M L T^-2", "the same of the peer", {}},
                 {"energy", "U", "M L^2 T^-2", "energy", {}},
                 {"peer_energy", "", "M L^2 T^-2", "the same of the peer", {}},
                 {"force_error", "", "1", "error over the largest force of the table", {}},
                 {"energy_error", "", "1", "error over the largest energy of the table", {}},
                 {"clamped", "", "1", "1 where the peer does not compute the stated potential", {}}}};
  for (std::size_t i = 0; i < table.rows(); ++i) {
    record.append({table["r"][i], force[i], table["force"][i], energy[i], table["energy"][i],
                   force_error.by_row[i], energy_error.by_row[i], table.clamped(i) ? 1.0 : 0.0});
  }
  seen.records.push_back(record);
  seen.metrics.push_back({"force_error", force_error.largest, "1", of_the_largest});
  seen.metrics.push_back({"energy_error", energy_error.largest, "1", of_the_largest});
  seen.metrics.push_back(
      {"clamped_force_error", force_error.largest_clamped, "1", "the same over the rows left out"});
  count_rows(table, seen);
  return seen;
}

// ---- angle-table: one angle at the rows' positions of its three nodes, the second the apex

Observations compare_angle(double stiffness, bool straight, const Table& table) {
  const auto rows = static_cast<Eigen::Index>(table.rows());
  const std::array<Positions, 3> at{table.vectors("", "1"), table.vectors("", "2"), table.vectors("", "3")};
  const std::array<Positions, 3> peer{table.vectors("f", "1"), table.vectors("f", "2"),
                                      table.vectors("f", "3")};
  std::vector<double> energy;
  std::vector<double> off(table.rows(), 0.0);  // largest difference of a component
  std::vector<double> force;                   // largest component
  std::vector<double> peer_force;
  for (Eigen::Index i = 0; i < rows; ++i) {
    Network network;
    network.rest.resize(3, 3);
    for (int node = 0; node < 3; ++node) network.rest.row(node) = at[static_cast<std::size_t>(node)].row(i);
    network.bonds = {{0, 1}, {1, 2}};
    network.vectors.resize(2, 3);
    network.vectors.row(0) = network.rest.row(1) - network.rest.row(0);
    network.vectors.row(1) = network.rest.row(2) - network.rest.row(1);
    network.angles = {{0, 1, -1, 1, straight}};
    network.spacing = network.vectors.row(0).norm();
    Positions gradient;
    energy.push_back(evaluate(Slack{}, HarmonicAngle{stiffness}, network, Positions::Zero(3, 3), gradient));
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
    off[static_cast<std::size_t>(i)] = difference.value;
  }
  const Errors energy_error = relative_errors(minus(energy, table["energy"]), table["energy"], table);
  const Errors force_error = relative_errors(off, peer_force, table);
  Observations seen;
  Record record{
      "angle_table",
      "One angle: this program and its peer",
      {{"theta", "", "1", "opening in degrees", {}},
       {"force", "", "M L T^-2", "largest of the nine components of force", {}},
       {"peer_force", "", "M L T^-2", "the same of the peer", {}},
       {"energy", "U", "M L^2 T^-2", "energy", {}},
       {"peer_energy", "", "M L^2 T^-2", "the same of the peer", {}},
       {"force_error", "", "1", "largest error of a component over the largest component of the table", {}},
       {"energy_error", "", "1", "error over the largest energy of the table", {}},
       {"clamped", "", "1", "1 where the peer does not compute the stated potential", {}}}};
  Largest clamped_relative;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    record.append({table["theta"][i], force[i], peer_force[i], energy[i], table["energy"][i],
                   force_error.by_row[i], energy_error.by_row[i], table.clamped(i) ? 1.0 : 0.0});
    if (table.clamped(i)) clamped_relative.add(off[i] / force[i]);
  }
  seen.records.push_back(record);
  seen.metrics.push_back({"force_error", force_error.largest, "1", of_the_largest});
  seen.metrics.push_back({"energy_error", energy_error.largest, "1", of_the_largest});
  seen.metrics.push_back({"clamped_force_error", clamped_relative.value, "1",
                          "over the rows left out, relative to each row's own largest component"});
  count_rows(table, seen);
  return seen;
}

// ---- kinds with a network

struct Body {
  Material material;
  Network network;
  std::map<std::int64_t, Eigen::Index> node_of_id;
};

Body read_body(const io::Section& top, const io::Section& compare) {
  const fs::path beside = fs::path(compare.place().file).parent_path();
  const std::string name = compare.text("data");
  fs::path file = beside / name;
  if (!fs::exists(file)) file = repository::references / name;
  if (!fs::exists(file)) {
    compare.fail("data", fmt::format("data file '{}' not found", name),
                 fmt::format("looked in {} and {}", beside.string(), repository::references.string()),
                 "Name it relative to one of these");
  }
  const io::LammpsData data = io::read_lammps_data(file);
  std::vector<std::int64_t> straight;
  if (compare.has("straight_types")) straight = compare.integers("straight_types");
  for (const std::int64_t type : straight) {
    if (type < 1 || type > data.angle_types) {
      compare.fail("straight_types", fmt::format("'straight_types' holds {}", type),
                   fmt::format("'{}' has angle types 1 to {}", name, data.angle_types),
                   "Name those types that rest at 180 degrees");
    }
  }
  Body body{
      {engine::read_law(top), engine::read_angle_stiffness(top)}, scene::network_of(data, straight), {}};
  if (body.material.angle_stiffness > 0.0 && body.network.angles.empty()) {
    compare.fail("data", fmt::format("'{}' has no angles", name), "the case gives them a stiffness",
                 "Leave out [angle], or add the angles");
  }
  for (std::size_t i = 0; i < data.atoms.size(); ++i)
    body.node_of_id[data.atoms[i].id] = static_cast<Eigen::Index>(i);
  return body;
}

// The node of each row's `id`, in blocks of one row per node.
std::vector<Eigen::Index> nodes_of_rows(const Body& body, const Table& table, const io::Section& compare) {
  const auto nodes = static_cast<std::size_t>(body.network.node_count());
  const std::vector<double>& ids = table["id"];
  std::vector<Eigen::Index> found;
  std::vector<int> times(nodes, 0);
  for (const double id : ids) {
    const auto at = body.node_of_id.find(static_cast<std::int64_t>(id));
    if (at == body.node_of_id.end() || std::floor(id) != id) {
      compare.fail("table", fmt::format("the table has a row of id {}", id), "the data file has no such atom",
                   "Name the table and the data of the same body");
    }
    if (++times[static_cast<std::size_t>(at->second)] > static_cast<int>(found.size() / nodes) + 1) {
      compare.fail("table", fmt::format("the table has a second row of id {}", id),
                   fmt::format("each frame has one row for each of the {} atoms", nodes), "Mend the table");
    }
    found.push_back(at->second);
  }
  if (found.size() % nodes != 0) {
    compare.fail("table", fmt::format("the table has {} rows", found.size()),
                 fmt::format("it needs one for each of the {} atoms", nodes),
                 "Name the table and the data of the same body");
  }
  return found;
}

// Rows `from` onwards of a column of vectors, in the order of nodes.
Positions by_node(const Positions& rows, const std::vector<Eigen::Index>& node_of_row, std::size_t from,
                  Eigen::Index nodes) {
  Positions all(nodes, 3);
  for (std::size_t i = from; i < from + static_cast<std::size_t>(nodes); ++i)
    all.row(node_of_row[i]) = rows.row(static_cast<Eigen::Index>(i));
  return all;
}

std::vector<double> by_node(const std::vector<double>& rows, const std::vector<Eigen::Index>& node_of_row) {
  std::vector<double> all(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) all[static_cast<std::size_t>(node_of_row[i])] = rows[i];
  return all;
}

// ---- node-forces: a displaced network

struct NodeParts {
  Positions bond_force, angle_force, force;
  std::vector<double> bond_energy, angle_energy;  // half of each bond's to its nodes, a third of each angle's
};

NodeParts node_parts(const Body& body, const Positions& u) {
  const Network& network = body.network;
  const auto nodes = static_cast<std::size_t>(network.node_count());
  NodeParts parts{
      {}, Positions::Zero(u.rows(), 3), {}, std::vector<double>(nodes, 0.0), std::vector<double>(nodes, 0.0)};
  Positions gradient;
  solid::visit(body.material, [&](const auto& law, const auto& angle) {
    evaluate(law, NoAngle{}, network, u, gradient);
    parts.bond_force = -gradient;
    if constexpr (!std::is_same_v<std::decay_t<decltype(angle)>, NoAngle>) {
      evaluate(Slack{}, angle, network, u, gradient);
      parts.angle_force = -gradient;
    }
    evaluate(law, angle, network, u, gradient);
    parts.force = -gradient;

    Workspace work;
    if (!solid::deform(law, network, u, work)) throw NumericalFailure("unreachable: evaluated above");
    for (std::size_t b = 0; b < network.bonds.size(); ++b) {
      const double share = 0.5 * law.energy(work.d.row(static_cast<Eigen::Index>(b)).norm());
      parts.bond_energy[static_cast<std::size_t>(network.bonds[b].first)] += share;
      parts.bond_energy[static_cast<std::size_t>(network.bonds[b].second)] += share;
    }
    if constexpr (!std::is_same_v<std::decay_t<decltype(angle)>, NoAngle>) {
      for (const solid::Angle& t : network.angles) {
        const solid::Bond& a = network.bonds[static_cast<std::size_t>(t.bond_a)];
        const solid::Bond& b = network.bonds[static_cast<std::size_t>(t.bond_b)];
        const double deviation = solid::angle_state(t.sign_a * work.d.row(t.bond_a).transpose(),
                                                    t.sign_b * work.d.row(t.bond_b).transpose(), t.straight)
                                     .deviation;
        const double share = 0.5 * angle.stiffness * deviation * deviation / 3.0;
        const std::int32_t apex = t.sign_a > 0 ? a.first : a.second;
        const std::int32_t end_a = t.sign_a > 0 ? a.second : a.first;
        const std::int32_t end_b = t.sign_b > 0 ? b.second : b.first;
        for (const std::int32_t node : {apex, end_a, end_b})
          parts.angle_energy[static_cast<std::size_t>(node)] += share;
      }
    }
  });
  return parts;
}

Observations compare_nodes(const Body& body, const Table& table,
                           const std::vector<Eigen::Index>& node_of_row) {
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

  Observations seen;
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
  return seen;
}

// ---- statics: layers of nodes across z

// Nodes by layer, from the lowest z.
std::vector<std::vector<Eigen::Index>> layers_of(const Network& network) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(network.node_count()));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Eigen::Index>(i);
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return network.rest(a, z_axis) < network.rest(b, z_axis);
  });
  std::vector<std::vector<Eigen::Index>> layers;
  for (const Eigen::Index node : order) {
    const bool same =
        !layers.empty() &&
        network.rest(node, z_axis) - network.rest(layers.back().front(), z_axis) < 1e-6 * network.spacing;
    if (!same) layers.emplace_back();
    layers.back().push_back(node);
  }
  return layers;
}

void hold(Held& held, const std::vector<Eigen::Index>& nodes, const std::vector<int>& axes) {
  for (const Eigen::Index node : nodes) {
    for (const int axis : axes) held(node, axis) = true;
  }
}

// Holds what else could shift across z and turn about it; no force is needed for that.
void hold_in_plane(Held& held, const Network& network) {
  const Eigen::VectorXd dx = (network.rest.col(x_axis).array() - network.rest(0, x_axis)).matrix();
  const Eigen::VectorXd dy = (network.rest.col(y_axis).array() - network.rest(0, y_axis)).matrix();
  Eigen::Index far = 0;
  (dx.cwiseAbs2() + dy.cwiseAbs2()).maxCoeff(&far);
  held(0, x_axis) = held(0, y_axis) = true;
  if (far != 0) held(far, std::abs(dx[far]) >= std::abs(dy[far]) ? y_axis : x_axis) = true;
}

double sum_over(const Positions& reaction, const std::vector<Eigen::Index>& nodes, int axis) {
  double sum = 0.0;
  for (const Eigen::Index node : nodes) sum += reaction(node, axis);
  return sum;
}

std::vector<double> plus(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

// ---- tensile: end layers held along z at each strain, free across it

Observations compare_tensile(const Body& body, const Table& table, Progress& progress) {
  const Network& network = body.network;
  const auto layers = layers_of(network);
  const double bottom = network.rest(layers.front().front(), z_axis);
  const double length = network.rest(layers.back().front(), z_axis) - bottom;
  Held held = Held::Constant(network.node_count(), 3, false);
  hold(held, layers.front(), {z_axis});
  hold(held, layers.back(), {z_axis});
  hold_in_plane(held, network);

  std::vector<double> force_bottom;
  std::vector<double> force_top;
  std::vector<double> energy;
  Largest residual;
  for (const double strain : table["strain"]) {
    progress.show("strains", energy.size(), table.rows());
    Positions u = Positions::Zero(network.node_count(), 3);
    u.col(z_axis) = strain * (network.rest.col(z_axis).array() - bottom);
    for (const Eigen::Index node : layers.back()) u(node, z_axis) = strain * length;
    const solid::Equilibrium e =
        solid::equilibrium(body.material, network, u, held, Positions::Zero(u.rows(), 3));
    // The peer's force is that of the network on the layer, ours that of the hold on the network.
    force_bottom.push_back(-sum_over(e.reaction, layers.front(), z_axis));
    force_top.push_back(-sum_over(e.reaction, layers.back(), z_axis));
    energy.push_back(energy_at(body.material, network, e.u));
    residual.add(e.residual);
  }
  const std::vector<double> peer_energy = plus(table["e_bond"], table["e_angle"]);
  const Errors bottom_error =
      relative_errors(minus(force_bottom, table["force_bottom"]), table["force_bottom"], table);
  const Errors top_error = relative_errors(minus(force_top, table["force_top"]), table["force_top"], table);
  const Errors energy_error = relative_errors(minus(energy, peer_energy), peer_energy, table);
  Observations seen;
  Record record{"end_force",
                "Force of the pulled bar on its ends: this program and its peer",
                {{"strain", "", "1", "change of length over undeformed length", {}},
                 {"force", "", "M L T^-2", "force of bonds and angles on the first layer along z", {}},
                 {"peer_force", "", "M L T^-2", "the same of the peer", {}},
                 {"force_error", "", "1", "error over the largest force, first layer", {}},
                 {"last_layer_error", "", "1", "the same of the last layer", {}},
                 {"energy", "U", "M L^2 T^-2", "elastic energy", {}},
                 {"peer_energy", "", "M L^2 T^-2", "the same of the peer", {}},
                 {"energy_error", "", "1", "error over the largest energy", {}}}};
  for (std::size_t i = 0; i < table.rows(); ++i) {
    record.append({table["strain"][i], force_bottom[i], table["force_bottom"][i], bottom_error.by_row[i],
                   top_error.by_row[i], energy[i], peer_energy[i], energy_error.by_row[i]});
  }
  seen.records.push_back(record);
  seen.metrics.push_back({"force_error", std::max(bottom_error.largest, top_error.largest), "1",
                          "largest error over the largest force, both ends"});
  seen.metrics.push_back({"energy_error", energy_error.largest, "1", of_the_largest});
  seen.metrics.push_back({"largest_residual", residual.value, "1",
                          "largest out-of-balance force over the largest tension, all states"});
  count_rows(table, seen);
  return seen;
}

// ---- cantilever: first layers clamped, transverse force along x on each node of the last

Observations compare_cantilever(const Body& body, const Table& table, std::size_t clamped_layers,
                                Progress& progress) {
  const Network& network = body.network;
  const auto layers = layers_of(network);
  const std::vector<Eigen::Index>& last = layers.back();
  Held held = Held::Constant(network.node_count(), 3, false);
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
    energy.push_back(energy_at(body.material, network, u));
    residual.add(e.residual);
  }
  const std::vector<double> peer_energy = plus(table["e_bond"], table["e_angle"]);
  const Errors energy_error = relative_errors(minus(energy, peer_energy), peer_energy, table);
  const Errors reaction_error =
      relative_errors(minus(reaction, table["clamp_reaction_x"]), table["clamp_reaction_x"], table);
  Observations seen;
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
  return seen;
}

// ---- trajectory: free motion from the first frame on

struct Motion {
  double time_step;    // [T]
  double node_mass;    // [M]
  std::int64_t early;  // the steps up to which `early_position_error` is measured
};

Observations compare_trajectory(const Body& body, const Table& table, const Table& energies,
                                const std::vector<Eigen::Index>& node_of_row, const Motion& motion,
                                Progress& progress) {
  const Network& network = body.network;
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

  Observations seen;
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
  seen.metrics.push_back({"energy_rows", static_cast<double>(energy_record.columns.front().values.size()),
                          "1", "rows of the table of energies that were compared"});
  count_rows(table, seen);
  return seen;
}

// ---- reading

scene::Plan plan_of(const Body& body, const std::string& solver) {
  scene::Plan plan =
      scene::plan({.law = body.material.law, .solid = std::nullopt, .method = "", .moves = false});
  std::erase_if(plan.left_out, [](const scene::LeftOut& l) { return l.module == "solid"; });
  const auto bonds = static_cast<double>(body.network.bonds.size());
  const auto angles = static_cast<double>(body.network.angles.size());
  plan.built.push_back(
      {"solid",
       fmt::format("{} nodes, {} bonds ({}) from a data file, typical length {}", body.network.node_count(),
                   body.network.bonds.size(), bond::name_of(body.material.law), body.network.spacing),
       static_cast<double>(body.network.node_count()) * 24.0 + bonds * 32.0});
  if (body.material.angle_stiffness > 0.0) {
    const auto straight = std::count_if(body.network.angles.begin(), body.network.angles.end(),
                                        [](const solid::Angle& a) { return a.straight; });
    plan.built.push_back({"angles",
                          fmt::format("{} angles of stiffness {}, {} of them rest at 180 degrees",
                                      body.network.angles.size(), body.material.angle_stiffness, straight),
                          angles * static_cast<double>(sizeof(solid::Angle))});
  } else {
    plan.left_out.push_back({"angles", "the case gives them no stiffness"});
  }
  if (!solver.empty()) plan.built.push_back({"solver", solver, 0.0});
  return plan;
}

std::vector<std::string> joined(std::vector<std::string> a,
                                const std::vector<std::vector<std::string>>& more) {
  for (const auto& names : more) a.insert(a.end(), names.begin(), names.end());
  return a;
}

engine::Study read_bond_table(const io::Section& top, const io::Section& compare) {
  const bond::AnyLaw law = engine::read_law(top);
  const Table table(compare, "table", compare.text("table"));
  table.need(compare, "table", {"r", "energy", "force"});
  return {.plan = scene::plan({.law = law, .solid = std::nullopt, .method = "", .moves = false}),
          .measures = {"force_error", "energy_error", "clamped_force_error", "rows", "clamped_rows"},
          .run = [=](Progress&, engine::Cost&) { return compare_bond(law, table); }};
}

engine::Study read_angle_table(const io::Section& top, const io::Section& compare) {
  const double stiffness = engine::read_angle_stiffness(top);
  if (stiffness == 0.0)
    throw InputError(top.place(), "the case lacks [angle]", "its stiffness decides the forces",
                     "Write [angle] and stiffness = 1.0");
  const std::int64_t rest_angle = compare.integer("rest_angle", 90, 180);
  if (rest_angle != 90 && rest_angle != 180) {
    compare.fail("rest_angle", fmt::format("'rest_angle' is {}", rest_angle),
                 "angles rest at 90 or 180 degrees", "Choose one of these");
  }
  const Table table(compare, "table", compare.text("table"));
  table.need(compare, "table",
             joined({"theta", "energy"},
                    {xyz("", "1"), xyz("", "2"), xyz("", "3"), xyz("f", "1"), xyz("f", "2"), xyz("f", "3")}));
  return {
      .plan = {.built = {{"angle",
                          fmt::format("one angle of stiffness {}, at rest at {} degrees", stiffness,
                                      rest_angle),
                          0.0}},
               .left_out = {{"bonds", "the table is about one angle alone"}}},
      .measures = {"force_error", "energy_error", "clamped_force_error", "rows", "clamped_rows"},
      .run = [=](Progress&, engine::Cost&) { return compare_angle(stiffness, rest_angle == 180, table); }};
}

engine::Study read_node_forces(const io::Section& top, const io::Section& compare) {
  const Body body = read_body(top, compare);
  const Table table(compare, "table", compare.text("table"));
  table.need(compare, "table",
             joined({"id", "e_bond", "e_angle"},
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
  return {.plan = plan_of(body, ""),
          .measures = {"force_error", "bond_force_error", "angle_force_error", "bond_energy_error",
                       "angle_energy_error", "rows", "clamped_rows"},
          .run = [=](Progress&, engine::Cost&) { return compare_nodes(body, table, node_of_row); }};
}

constexpr const char* newton = "statics: Newton with line search, sparse Cholesky";

engine::Study read_tensile_table(const io::Section& top, const io::Section& compare) {
  const Body body = read_body(top, compare);
  const Table table(compare, "table", compare.text("table"));
  table.need(compare, "table", {"strain", "force_bottom", "force_top", "e_bond", "e_angle"});
  if (layers_of(body.network).size() < 2)
    compare.fail("data", "all nodes have the same z", "the bar is pulled along z", "Turn the body");
  return {.plan = plan_of(body, newton),
          .measures = {"force_error", "energy_error", "largest_residual", "rows", "clamped_rows"},
          .run = [=](Progress& progress, engine::Cost&) { return compare_tensile(body, table, progress); }};
}

engine::Study read_cantilever(const io::Section& top, const io::Section& compare) {
  const Body body = read_body(top, compare);
  const Table table(compare, "table", compare.text("table"));
  table.need(compare, "table", {"force_per_node", "tip_x", "tip_z", "e_bond", "e_angle", "clamp_reaction_x"});
  const auto layers = static_cast<std::int64_t>(layers_of(body.network).size());
  if (layers < 2)
    compare.fail("data", "all nodes have the same z", "the bar is clamped at its lowest layers",
                 "Turn the body");
  const auto clamped = static_cast<std::size_t>(compare.integer("clamped_layers", 1, layers - 1));
  return {
      .plan = plan_of(body, newton),
      .measures = {"tip_error", "reaction_error", "energy_error", "largest_residual", "rows", "clamped_rows"},
      .run = [=](Progress& progress, engine::Cost&) {
        return compare_cantilever(body, table, clamped, progress);
      }};
}

engine::Study read_trajectory(const io::Section& top, const io::Section& compare) {
  const Body body = read_body(top, compare);
  const Table table(compare, "table", compare.text("table"));
  table.need(compare, "table", joined({"step", "id"}, {xyz("", ""), xyz("v", "")}));
  const Table energies(compare, "energies", compare.text("energies"));
  energies.need(compare, "energies", {"step", "total"});
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
              body, fmt::format("leap-frog, time step {}, node mass {}", motion.time_step, motion.node_mass)),
          .measures = {"early_position_error", "position_error", "velocity_error", "energy_error",
                       "energy_change", "peer_energy_change", "energy_rows", "rows", "clamped_rows"},
          .run = [=](Progress& progress, engine::Cost&) {
            return compare_trajectory(body, table, energies, node_of_row, motion, progress);
          }};
}

}  // namespace

engine::Study read_compare(const io::Section& top) {
  const io::Section compare = top.table("compare");
  const std::vector<std::string> kinds{"bond-table", "angle-table", "node-forces",
                                       "tensile",    "cantilever",  "trajectory"};
  const std::string kind = compare.choice("kind", kinds);
  if (kind == "bond-table") return read_bond_table(top, compare);
  if (kind == "angle-table") return read_angle_table(top, compare);
  if (kind == "node-forces") return read_node_forces(top, compare);
  if (kind == "tensile") return read_tensile_table(top, compare);
  if (kind == "cantilever") return read_cantilever(top, compare);
  return read_trajectory(top, compare);
}

}  // namespace veriflex::drivers
