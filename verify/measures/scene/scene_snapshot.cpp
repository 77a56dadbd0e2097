#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "io/vtk.hpp"
#include "measures/scene/scene.hpp"
#include "observe/attach.hpp"
#include "observe/snapshot.hpp"

// Snapshots of a scene for ParaView: what the entries say, and the files that are written while it runs.

namespace veriflex::measures {

void read_body_snapshot(const io::Table& t, const scene::Scene& scene, Observation& to) {
  to.is_snapshot = true;
  std::vector<std::string> names;
  for (const scene::Body& body : scene.bodies) names.push_back(body.name);
  if (names.empty()) t.fail("what", "it looks at a body", "the scene has none", "Add a [[body]]");
  for (std::size_t i = 0; i < names.size(); ++i) to.bodies.push_back(i);
  if (!t.has("body")) return;
  const std::string name = t.choice("body", names);
  to.bodies = {static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin())};
}

void read_fluid_snapshot(const io::Table& t, const scene::Scene& scene, Observation& to) {
  to.is_snapshot = true;
  const Grid& grid = scene.fluid->grid;
  to.to = {grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1};
  if (t.has("from")) to.from = read_node(t, "from", grid);
  if (t.has("to")) to.to = read_node(t, "to", grid);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (to.from[axis] > to.to[axis])
      t.fail("to", "the box holds no node", "it ends before it begins", "Exchange from and to");
  }
  to.fields = read_fields(t);
}

std::function<void(const scene::Simulation&)> snapshots(const Observation& o) {
  const auto members = std::make_shared<std::vector<io::VtkMember>>();
  return [o, members](const scene::Simulation& simulation) {
    if (!observe::is_attaching()) return;
    const auto time = static_cast<double>(simulation.steps());
    const auto file = [&](const std::string& whose, const char* kind, const std::string& bytes, int part) {
      const std::string name = fmt::format("{}{}-{:09}.{}", o.name, whose, simulation.steps(), kind);
      observe::attach(name, bytes);
      members->push_back({time, part, name});
    };
    for (std::size_t k = 0; k < o.bodies.size(); ++k) {
      const scene::MovingBody& body = simulation.body(o.bodies[k]);
      const std::string whose = o.bodies.size() > 1 ? "-" + body.name() : "";
      file(whose, "vtu", observe::snapshot_of_body(body, time), static_cast<int>(k));
    }
    if (o.bodies.empty())
      file("", "vti", observe::snapshot_of_fluid(simulation.fluid(), o.from, o.to, o.fields, time), 0);
    // Often enough to be looked at while the scene runs; the list of a long series is not written each time.
    const std::size_t count = members->size();
    if (count < 100 || count % 100 == 0 || simulation.steps() == o.last_step)
      observe::attach(o.name + ".pvd", io::vtk_collection(*members));
  };
}

}  // namespace veriflex::measures
