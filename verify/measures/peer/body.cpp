#include "measures/peer/body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "engine/read_scene.hpp"
#include "measures/data_file.hpp"
#include "scene/lammps_network.hpp"
#include "solid/inadmissible.hpp"

namespace veriflex::measures::peer {

namespace {

bool agree(double a, double b) {
  return a == b || (std::isfinite(a - b) && std::abs(a - b) <= 1e-6 * std::max(std::abs(a), std::abs(b)));
}

struct Coefficient {
  const char* parameter;  // of the law
  std::size_t index;      // of LAMMPS's coefficient
  double factor;          // the law's value over LAMMPS's
};

// What the coefficients of a bond style mean for the law; nothing where they are not known here.
// [LAMMPS: bond_style harmonic K r0 with U = K (r - r0)^2; bond_style fene K R0 epsilon sigma, cut at 2^(1/6)
// sigma]
std::vector<Coefficient> meaning(const std::string& style, const std::string& law) {
  if (style == "harmonic" && law == "harmonic") return {{"bond_stiffness", 0, 2.0}, {"rest_length", 1, 1.0}};
  if (style == "fene" && law == "fene-lj") {
    return {{"fene_k", 0, 1.0},
            {"r_max", 1, 1.0},
            {"epsilon", 2, 1.0},
            {"sigma", 3, 1.0},
            {"cutoff", 3, bond::FeneLj::lj_minimum}};
  }
  return {};
}

// Holds the bonds' coefficients against the case's law, and says what it could not check.
void check_bonds(const io::LammpsData& data, const bond::AnyLaw& law, Body& body) {
  const std::string name = bond::name_of(law);
  std::set<int> types;
  for (const io::LammpsBond& bond : data.bonds) types.insert(bond.type);
  std::set<int> known;
  for (const io::LammpsCoefficients& row : data.bond_coefficients) {
    if (!types.contains(row.type)) continue;
    const bool other_law =
        (row.style == "harmonic" || row.style == "fene") && meaning(row.style, name).empty();
    if (other_law) {
      throw InputError({data.file, row.line, 1},
                       fmt::format("bonds of type {} are '{}'", row.type, row.style),
                       fmt::format("the case's bonds are {}", name), "Correct the one or the other");
    }
    const std::vector<Coefficient> wanted = meaning(row.style, name);
    if (wanted.empty()) {
      body.warnings.push_back(fmt::format("{}:{}: coefficients of bond style '{}' are not checked", data.file,
                                          row.line, row.style));
      continue;
    }
    if (row.values.size() <= wanted.back().index) {
      throw InputError({data.file, row.line, 1}, fmt::format("{} coefficients", row.values.size()),
                       fmt::format("bond style {} has {}", row.style, wanted.back().index + 1),
                       "Complete the row");
    }
    for (const Coefficient& one : wanted) {
      const double here = one.factor * row.values[one.index];
      for (const bond::NamedValue& p : bond::parameters_of(law)) {
        if (p.name != one.parameter || agree(here, p.value)) continue;
        throw InputError({data.file, row.line, 1},
                         fmt::format("bonds of type {} have {} = {}", row.type, p.name, here),
                         fmt::format("the case has {}; all bonds obey its law", p.value),
                         "Correct the one or the other, or leave the section out");
      }
    }
    known.insert(row.type);
  }
  if (types.size() > 1 && known.size() < types.size()) {
    body.warnings.push_back(
        fmt::format("{}: bonds are of {} types; all of them obey the case's law", data.file, types.size()));
  }
}

// The same for angles. [LAMMPS: angle_style harmonic K theta0, U = K (theta - theta0)^2]
void check_angles(const io::LammpsData& data, double stiffness, const std::vector<std::int64_t>& straight,
                  Body& body) {
  if (stiffness == 0.0) {
    if (!data.angles.empty()) {
      body.warnings.push_back(fmt::format("{}: its {} angles are left out, the case gives them no stiffness",
                                          data.file, data.angles.size()));
    }
    return;
  }
  for (const io::LammpsCoefficients& row : data.angle_coefficients) {
    if (std::none_of(data.angles.begin(), data.angles.end(),
                     [&](const io::LammpsAngle& angle) { return angle.type == row.type; }))
      continue;
    if (row.style != "harmonic" || row.values.size() < 2) {
      body.warnings.push_back(fmt::format("{}:{}: coefficients of angle style '{}' are not checked",
                                          data.file, row.line, row.style));
      continue;
    }
    const bool is_straight = std::find(straight.begin(), straight.end(), row.type) != straight.end();
    const double rest = is_straight ? 180.0 : 90.0;
    if (agree(2.0 * row.values[0], stiffness) && agree(row.values[1], rest)) continue;
    throw InputError({data.file, row.line, 1},
                     fmt::format("angles of type {} have stiffness {} and rest at {} degrees", row.type,
                                 2.0 * row.values[0], row.values[1]),
                     fmt::format("the case has {} and {}", stiffness, rest),
                     "Correct the one or the other, or straight_types, or leave the section out");
  }
}

// The mass that all atoms share. Throws InputError when they do not.
std::optional<double> common_mass(const io::LammpsData& data) {
  std::map<int, double> mass_of;
  for (const io::LammpsMass& row : data.masses) mass_of[row.type] = row.mass;
  std::optional<double> common;
  for (const io::LammpsAtom& atom : data.atoms) {
    const auto mass = mass_of.find(atom.type);
    if (mass == mass_of.end()) return std::nullopt;
    if (common.value_or(mass->second) != mass->second) {
      const auto row = std::find_if(data.masses.begin(), data.masses.end(),
                                    [&](const io::LammpsMass& m) { return m.type == atom.type; });
      throw InputError({data.file, row->line, 1},
                       fmt::format("atoms have masses {} and {}", *common, mass->second),
                       "all nodes of a moving body have one mass here", "Give them one mass");
    }
    common = mass->second;
  }
  return common;
}

}  // namespace

void warn(const Body& body, Progress& progress) {
  for (const std::string& warning : body.warnings) progress.warn(warning);
}

Body read_body(const io::Table& top, const io::Table& peer) {
  const std::string name = peer.text("data");
  const io::LammpsData data = io::read_lammps_data(data_file(peer, "data"));
  std::vector<std::int64_t> straight;
  if (peer.has("straight_types")) straight = peer.integers("straight_types");
  for (const std::int64_t type : straight) {
    if (type < 1 || type > data.angle_types) {
      peer.fail("straight_types", fmt::format("'straight_types' holds {}", type),
                fmt::format("'{}' has angle types 1 to {}", name, data.angle_types),
                "Name those types that rest at 180 degrees");
    }
  }
  Body body{.material = {engine::read_law(top), engine::read_angle_stiffness(top)},
            .network = scene::network_of(data, straight),
            .node_of_id = {},
            .node_mass = {},
            .warnings = {}};
  check_bonds(data, body.material.law, body);
  check_angles(data, body.material.angle_stiffness, straight, body);
  if (peer.text("kind") == "trajectory") body.node_mass = common_mass(data);
  if (body.material.angle_stiffness > 0.0 && body.network.angles.empty()) {
    peer.fail("data", fmt::format("'{}' has no angles", name), "the case gives them a stiffness",
              "Leave out [angle], or add the angles");
  }
  for (std::size_t i = 0; i < data.atoms.size(); ++i)
    body.node_of_id[data.atoms[i].id] = static_cast<Eigen::Index>(i);
  return body;
}

std::vector<Eigen::Index> nodes_of_rows(const Body& body, const PeerTable& table, const io::Table& peer) {
  const auto nodes = static_cast<std::size_t>(body.network.node_count());
  std::vector<Eigen::Index> found;
  std::vector<int> times(nodes, 0);
  for (const std::int64_t id : table.counts("id")) {
    const auto at = body.node_of_id.find(id);
    if (at == body.node_of_id.end()) {
      peer.fail("table", fmt::format("the table has a row of id {}", id), "the data file has no such atom",
                "Name the table and the data of the same body");
    }
    if (++times[static_cast<std::size_t>(at->second)] > static_cast<int>(found.size() / nodes) + 1) {
      peer.fail("table", fmt::format("the table has a second row of id {}", id),
                fmt::format("each frame has one row for each of the {} atoms", nodes), "Mend the table");
    }
    found.push_back(at->second);
  }
  if (found.size() % nodes != 0) {
    peer.fail("table", fmt::format("the table has {} rows", found.size()),
              fmt::format("it needs one for each of the {} atoms", nodes),
              "Name the table and the data of the same body");
  }
  return found;
}

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

scene::Plan plan_of(const Body& body, const std::string& method, const std::vector<parts::Kind>& by) {
  using parts::Kind;
  scene::Plan plan = scene::plan({.law = body.material.law, .solid = std::nullopt});
  std::erase_if(plan.left_out, [](const scene::LeftOut& l) { return l.module == "solid"; });
  plan.built.push_back(
      {"solid",
       fmt::format("{} nodes, {} bonds ({}) from a data file, typical length {}", body.network.node_count(),
                   body.network.bonds.size(), bond::name_of(body.material.law), body.network.spacing),
       solid::bond_bytes(body.network),
       {Kind::Bonds}});
  if (body.material.angle_stiffness > 0.0) {
    const auto straight = std::count_if(body.network.angles.begin(), body.network.angles.end(),
                                        [](const solid::Angle& a) { return a.straight; });
    plan.built.push_back({"angles",
                          fmt::format("{} angles of stiffness {}, {} of them rest at 180 degrees",
                                      body.network.angles.size(), body.material.angle_stiffness, straight),
                          solid::angle_bytes(body.network),
                          {Kind::Angles}});
  } else {
    plan.left_out.push_back({"angles", "the case gives them no stiffness", Kind::Angles});
  }
  if (!method.empty()) plan.built.push_back({"solver", method, 0.0, by});
  if (by == std::vector{Kind::LeapFrog}) {
    plan.left_out.push_back(
        {"constraints", "the body is free: no pass over fixed or driven coordinates", Kind::Constraints});
  } else {
    plan.left_out.push_back({"velocities", "a static study needs none", Kind::LeapFrog});
  }
  return plan;
}

double evaluate(const solid::Material& material, const solid::Network& network, const Positions& u,
                Positions& gradient) {
  const solid::NetworkParts held = solid::parts_of(network);
  return solid::visit(material, [&](const auto& law, const auto& angle) {
    solid::Workspace work;
    if (!solid::deform(law, network, u, work) || !solid::gradient(law, angle, network, work, gradient)) {
      throw NumericalFailure("the table's configuration: " +
                             solid::what_is_inadmissible(material, network, u));
    }
    return solid::energy(law, angle, network, work);
  });
}

}  // namespace veriflex::measures::peer
