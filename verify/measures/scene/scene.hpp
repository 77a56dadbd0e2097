/// What the parts of the driver `scene` share: a scene as the tables of a case say it.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/quantity.hpp"
#include "io/document.hpp"
#include "io/hdf5.hpp"
#include "observe/field.hpp"
#include "observe/run.hpp"
#include "observe/series.hpp"
#include "scene/plan.hpp"
#include "scene/scene.hpp"

namespace veriflex::measures {

/// What a [[body]] says beside the body itself, which is kept once: it may be large.
struct CaseBody {
  Vec3 stroke = Vec3::Zero();    // that a drive or an oscillation takes it to either side  [L]
  std::optional<double> period;  // of that  [T]
  io::Table table;
};

/// Whether columns and records may be called so: letters, digits, `_` and `-`.
bool is_plain_name(const std::string& name);

/// A list of nodes of a body that has `count`.
std::vector<std::int32_t> read_node_list(const io::Table& table, const std::string& key, Eigen::Index count);

/// `shape` of a [[body]]: its network in the body's own axes, without angles. `spacing` is r0, by default
/// `rest_length`; a data file has its own.
solid::Network read_shape(const io::Table& body, double rest_length);

/// A [[body]], into `body`. `in_fluid`: whether the scene has one.
CaseBody read_body(const io::Table& table, bool in_fluid, scene::Body& body);

/// The fluid and the bodies of a case.
struct CaseScene {
  scene::Scene scene;
  std::vector<CaseBody> bodies;  // one for each of the scene
};

/// [fluid] and [[body]], and what is wrong with them by themselves.
CaseScene read_fluid_and_bodies(const io::Table& top);

/// Refuses bodies that have no room in the box, or stand in each other.
void check_places(const CaseScene& read);

/// What is built of it.
scene::Plan plan_of(const io::Table& top, const scene::Scene& scene);

/// [fluid.initial]: the populations that the fluid starts from; empty without that table.
std::function<fluid::Populations(std::int64_t)> read_initial_flow(const io::Table& top,
                                                                  const fluid::Spec& fluid);

/// The numbers that a case of the driver is told by, and its [units].
std::vector<engine::Quantity> quantities_of(const io::Table& top);

/// What files of a snapshot are.
enum class SnapshotFormat { vtk_xml, vtk_hdf, lammps_data };

/// An [[observe]].
struct Observation {
  std::string name, what, title;
  observe::Due due{INFINITY};
  std::vector<std::int64_t> places;  // of the fluid, for probes and fields
  bool probes = false;               // one row for all places, not one for each
  std::vector<double> weights{};     // of the places in one sum over them; empty: each has its own columns
  observe::Fields fields;
  std::size_t body = 0;               // whose nodes are looked at, and
  std::vector<std::int32_t> nodes{};  // which
  observe::Series (*series)(const scene::Scene&) = nullptr;
  /// Files: of these bodies, or of the fluid from node to node.
  bool is_snapshot = false;
  SnapshotFormat format = SnapshotFormat::vtk_xml;
  std::vector<std::size_t> bodies{};
  std::array<std::int64_t, 3> from{}, to{};
  std::int64_t last_step = 0;
  double mean_from = 0.0;  // of a series: `.mean`, `.min` and `.max` are of the rows from then on  [T]
  /// When does that column first reach that value? Counted from where it first was at `from`.
  struct Reach {
    std::string column;
    double value;
    std::optional<double> from;
  };
  std::optional<Reach> reach{};  // of a series
  /// The periods of that column, from a time on.
  struct Swing {
    std::string column;
    double from;  // [T]
  };
  std::optional<Swing> swing{};  // of a series

  /// One row each time: it has metrics.
  bool is_series() const { return probes || series != nullptr; }
};

/// Every [[observe]] of a scene. `period`: of its drive, 0 without one; `steps`: of its run.
std::vector<Observation> read_observations(const io::Table& top, const scene::Scene& scene, double period,
                                           std::int64_t steps);

/// The record of an observation, without rows.
observe::Record empty_record(const Observation& observation, const scene::Scene& scene);

/// What a check may ask of it.
std::vector<std::string> measures_of(const Observation& observation, const scene::Scene& scene);

/// Adds rows to records[at] when they are due, and hands over snapshots (observe/attach). Returns what the
/// observers keep between two steps, null for nothing.
std::shared_ptr<std::vector<double>> add_observers(const Observation& observation, const scene::Scene& scene,
                                                   std::vector<observe::Record>& records, std::size_t at,
                                                   std::vector<observe::Observer>& observers);

/// Everything that a run of a scene is, between two steps. Put back into one that stands at its start, it
/// goes on bit by bit.
struct Running {
  scene::Simulation& simulation;
  observe::Run& run;
  std::span<observe::Record> records;
  std::vector<std::shared_ptr<std::vector<double>>> memories;  // of the observers, some null
  Progress& progress;

  void put_in(io::Hdf5Image& image) const;
  void take_from(const io::Hdf5File& file);
};

/// What `what = "body snapshot"` and `"fluid snapshot"` look at.
void read_body_snapshot(const io::Table& table, const scene::Scene& scene, Observation& to);
void read_fluid_snapshot(const io::Table& table, const scene::Scene& scene, Observation& to);

/// Three numbers of a node in the box.
std::array<std::int64_t, 3> read_node(const io::Table& table, const std::string& key, const Grid& grid);

/// `fields` of an observation of the fluid; density and velocity by default.
observe::Fields read_fields(const io::Table& table);

/// Hands over the files of a snapshot, `<name>-<step>.vtu`, `.vti`, `.hdf` or `.data`, and the list of all of
/// them, `<name>.pvd` or `.hdf.series`. `steps`: of the snapshots until now, this one too.
void hand_over_snapshot(const Observation& observation, const scene::Simulation& simulation,
                        const std::vector<double>& steps);

/// `<record>.<column>.last` of its rows, `.mean`, `.min` and `.max` of those since `mean_from`; `.reached`,
/// the time when the column that `reaches` names comes to its value; `.period` of the column that `swings`
/// names, and `.swing_mean`, `.swing_min` and `.swing_max` of every column over whole periods. Throws
/// NumericalFailure when it never comes there, or has no two periods.
std::vector<observe::Metric> metrics_of(const Observation& observation, const observe::Record& record);

}  // namespace veriflex::measures
