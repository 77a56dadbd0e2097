#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "base/named.hpp"
#include "io/vtk.hpp"
#include "measures/scene/scene.hpp"
#include "observe/attach.hpp"
#include "observe/snapshot.hpp"

// Snapshots of a scene for ParaView: what the entries say, and the files that are written while it runs.

namespace veriflex::measures {

namespace {

// Those of VTK first: a fluid has no others.
constexpr std::array snapshot_formats{
    Named<SnapshotFormat>{SnapshotFormat::vtk_xml, "vtk-xml", "vtk_xml", "VTK's XML files"},
    Named<SnapshotFormat>{SnapshotFormat::vtk_hdf, "vtkhdf", "vtkhdf", "VTK's HDF5 files"},
    Named<SnapshotFormat>{SnapshotFormat::lammps_data, "lammps-data", "lammps_data", "LAMMPS data files"}};

SnapshotFormat read_format(const io::Table& t, std::span<const Named<SnapshotFormat>> known) {
  if (!t.has("format")) return SnapshotFormat::vtk_xml;
  return row_named(known, t.choice("format", names_of(known))).value;
}

}  // namespace

void read_body_snapshot(const io::Table& t, const scene::Scene& scene, Observation& to) {
  to.is_snapshot = true;
  to.format = read_format(t, snapshot_formats);
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
  to.format = read_format(t, std::span(snapshot_formats).first<2>());
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

std::string series_name(const Observation& o, const scene::Simulation& simulation, std::size_t part) {
  return o.bodies.size() > 1 ? o.name + "-" + simulation.body(o.bodies[part]).name() : o.name;
}

std::string file_name(const Observation& o, const scene::Simulation& simulation, std::size_t part,
                      double step) {
  const char* kind = o.bodies.empty() ? "vti" : "vtu";
  if (o.format == SnapshotFormat::vtk_hdf) kind = "hdf";
  if (o.format == SnapshotFormat::lammps_data) kind = "data";
  return fmt::format("{}-{:09.0f}.{}", series_name(o, simulation, part), step, kind);
}

void hand_over(const Observation& o, const std::string& name, const auto& picture) {
  if (o.format == SnapshotFormat::vtk_hdf) {
    const std::vector<char> bytes = io::vtk_hdf(picture);
    observe::attach(name, {bytes.data(), bytes.size()});
  } else {
    observe::attach(name, io::vtk_xml(picture));
  }
}

}  // namespace

void hand_over_snapshot(const Observation& o, const scene::Simulation& simulation,
                        const std::vector<double>& steps) {
  if (!observe::is_attaching()) return;
  const double now = steps.back();
  const std::size_t parts = std::max<std::size_t>(1, o.bodies.size());
  for (std::size_t k = 0; k < parts; ++k) {
    const std::string name = file_name(o, simulation, k, now);
    if (o.bodies.empty()) {
      hand_over(o, name, observe::picture_of_fluid(simulation.fluid(), o.from, o.to, o.fields, now));
    } else if (o.format == SnapshotFormat::lammps_data) {
      observe::attach(name, observe::lammps_data_of(simulation.body(o.bodies[k]), now));
    } else {
      hand_over(o, name, observe::picture_of_body(simulation.body(o.bodies[k]), now));
    }
  }
  // Often enough to be looked at while the scene runs; the list of a long series is not written each time.
  if (steps.size() >= 100 && steps.size() % 100 != 0 && simulation.steps() != o.last_step) return;
  const auto members = [&](std::size_t first, std::size_t count) {
    std::vector<io::VtkMember> all;
    for (const double step : steps) {
      for (std::size_t k = first; k < first + count; ++k)
        all.push_back({step, static_cast<int>(k), file_name(o, simulation, k, step)});
    }
    return all;
  };
  if (o.format == SnapshotFormat::vtk_xml)
    observe::attach(o.name + ".pvd", io::vtk_collection(members(0, parts)));
  for (std::size_t k = 0; o.format == SnapshotFormat::vtk_hdf && k < parts; ++k)
    observe::attach(series_name(o, simulation, k) + ".hdf.series", io::vtk_series(members(k, 1)));
}

}  // namespace veriflex::measures
