#include "drivers/compare/body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "engine/read_scene.hpp"
#include "repository.hpp"
#include "scene/lammps_network.hpp"
#include "solid/undefined.hpp"

namespace veriflex::drivers::compare {

Body read_body(const io::Section& top, const io::Section& compare) {
  const std::filesystem::path beside = std::filesystem::path(compare.place().file).parent_path();
  const std::string name = compare.text("data");
  std::filesystem::path file = beside / name;
  if (!std::filesystem::exists(file)) file = repository::references() / name;
  if (!std::filesystem::exists(file)) {
    compare.fail("data", fmt::format("data file '{}' not found", name),
                 fmt::format("looked in {} and {}", beside.string(), repository::references().string()),
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

scene::Plan plan_of(const Body& body, const std::string& method, bool moves) {
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
  if (!method.empty()) plan.built.push_back({"solver", method, 0.0});
  if (moves) {
    plan.left_out.push_back({"constraints", "the body is free: no pass over held or driven coordinates"});
  } else {
    plan.left_out.push_back({"velocities", "a static study needs none"});
  }
  return plan;
}

double evaluate(const solid::Material& material, const solid::Network& network, const Positions& u,
                Positions& gradient) {
  return solid::visit(material, [&](const auto& law, const auto& angle) {
    solid::Workspace work;
    if (!solid::deform(law, network, u, work) || !solid::gradient(law, angle, network, work, gradient)) {
      throw NumericalFailure("the table's configuration: " + solid::what_is_undefined(material, network, u));
    }
    return solid::energy(law, angle, network, work);
  });
}

}  // namespace veriflex::drivers::compare
