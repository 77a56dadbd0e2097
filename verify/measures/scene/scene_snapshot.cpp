#include <fmt/format.h>

#include <algorithm>

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

namespace {

std::string file_name(const Observation& o, const scene::Simulation& simulation, std::size_t part,
                      double step) {
  const std::string whose = o.bodies.size() > 1 ? "-" + simulation.body(o.bodies[part]).name() : "";
  return fmt::format("{}{}-{:09.0f}.{}", o.name, whose, step, o.bodies.empty() ? "vti" : "vtu");
}

}  // namespace

void hand_over_snapshot(const Observation& o, const scene::Simulation& simulation,
                        const std::vector<double>& steps) {
  if (!observe::is_attaching()) return;
  const double now = steps.back();
  for (std::size_t k = 0; k < o.bodies.size(); ++k) {
    observe::attach(file_name(o, simulation, k, now),
                    observe::snapshot_of_body(simulation.body(o.bodies[k]), now));
  }
  if (o.bodies.empty()) {
    observe::attach(file_name(o, simulation, 0, now),
                    observe::snapshot_of_fluid(simulation.fluid(), o.from, o.to, o.fields, now));
  }
  // Often enough to be looked at while the scene runs; the list of a long series is not written each time.
  if (steps.size() >= 100 && steps.size() % 100 != 0 && simulation.steps() != o.last_step) return;
  std::vector<io::VtkMember> members;
  for (const double step : steps) {
    for (std::size_t k = 0; k < std::max<std::size_t>(1, o.bodies.size()); ++k) {
      members.push_back({step, static_cast<int>(k), file_name(o, simulation, k, step)});
    }
  }
  observe::attach(o.name + ".pvd", io::vtk_collection(members));
}

}  // namespace veriflex::measures
