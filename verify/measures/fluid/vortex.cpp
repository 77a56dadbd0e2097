#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/reduce.hpp"
#include "engine/convergence.hpp"
#include "measures/drivers.hpp"
#include "measures/fluid/periodic_fluid.hpp"
#include "measures/fluid/run_fluid.hpp"

namespace veriflex::measures {

namespace {

using analytic::DecayingFlow;
using analytic::Pattern;
using observe::Observations;
using observe::Record;

constexpr double max_decays = 100.0;
constexpr double min_velocity = 1e-30;  // its square and that of its rounding are still numbers in float

struct VortexStudy {
  fluid::Spec fluid;  // the box is set per row, the storage too
  Pattern pattern;
  std::vector<std::string> planes;
  std::vector<fluid::Storage> storages;
  std::vector<std::int64_t> nodes;  // along a side
  double reynolds;                  // A N/nu: diffusive scaling, A falls as 1/N
  double decays;                    // e-foldings of the velocity over the run
  Start start;
  observe::MonitorSpec monitor;
};

// Distances between two fields over the magnitude of the exact one, in each norm.
struct Norms {
  double l1, l2, linf;
};

struct Row {
  std::string plane;
  fluid::Storage storage;
  std::int64_t nodes, steps;
  double amplitude;
  Norms velocity_error;
  double pressure_error;  // L2
  Positions velocity;     // at the end, where storages are compared
  double velocity_norm;   // of the exact velocity
};

DecayingFlow flow_of(const VortexStudy& study, const std::string& plane, std::int64_t n) {
  const double nu = fluid::viscosity(study.fluid.relaxation_time);
  const std::array<int, 2> axes = axes_of(plane);
  return {.pattern = study.pattern,
          .a = axes[0],
          .b = axes[1],
          .wavenumber = wavenumber(n),
          .amplitude = study.reynolds * nu / static_cast<double>(n),
          .viscosity = nu};
}

void compare(const fluid::Fluid& fluid, const DecayingFlow& flow, bool keep, Row& row) {
  const Grid& grid = fluid.spec().grid;
  std::vector<fluid::Populations> h;
  const auto take = [&](std::span<const std::int64_t> nodes) {
    h.resize(nodes.size());
    fluid.populations(nodes, h);
  };
  double mean = 0.0;
  in_parts(grid, [&](std::span<const std::int64_t> nodes) {
    take(nodes);
    for (const fluid::Populations& here : h) mean += fluid::density_deviation(here);
  });
  mean /= static_cast<double>(grid.count());

  if (keep) row.velocity.resize(grid.count(), 3);
  Norms error{}, exact{};
  double pressure_error = 0.0, pressure = 0.0;
  in_parts(grid, [&](std::span<const std::int64_t> nodes) {
    take(nodes);
    const Positions velocity = velocities_of(fluid, nodes);
    if (keep) row.velocity.middleRows(nodes.front(), velocity.rows()) = velocity;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const analytic::FlowState here = flow.at(position(grid, nodes[i]), static_cast<double>(fluid.steps()));
      const double distance = (Vec3(velocity.row(static_cast<Eigen::Index>(i))) - here.velocity).norm();
      const double magnitude = here.velocity.norm();
      error = {error.l1 + distance, error.l2 + distance * distance, worse(error.linf, distance)};
      exact = {exact.l1 + magnitude, exact.l2 + magnitude * magnitude, worse(exact.linf, magnitude)};
      const double p = fluid::sound_speed_squared * (fluid::density_deviation(h[i]) - mean);
      pressure_error += (p - here.pressure) * (p - here.pressure);
      pressure += here.pressure * here.pressure;
    }
  });
  row.velocity_norm = std::sqrt(exact.l2);
  row.velocity_error = {error.l1 / exact.l1, std::sqrt(error.l2 / exact.l2), error.linf / exact.linf};
  row.pressure_error = std::sqrt(pressure_error / pressure);
}

fluid::Spec spec_of(const VortexStudy& study, const std::string& plane, fluid::Storage storage,
                    std::int64_t n) {
  fluid::Spec spec = study.fluid;
  spec.storage = storage;
  spec.grid = plane_box(n, axes_of(plane));
  return spec;
}

bool storages_are_compared(const VortexStudy& study) { return study.storages.size() == 2; }

Row measure(const VortexStudy& study, const std::string& plane, fluid::Storage storage, std::int64_t n,
            engine::Cost& cost, const std::string& phase) {
  const DecayingFlow flow = flow_of(study, plane, n);
  Row row{.plane = plane,
          .storage = storage,
          .nodes = n,
          .steps = std::max<std::int64_t>(1, std::llround(study.decays / flow.decay_rate())),
          .amplitude = flow.amplitude,
          .velocity_error = {},
          .pressure_error = 0.0,
          .velocity = {},
          .velocity_norm = 0.0};
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(spec_of(study, plane, storage, n));
  start(*fluid, flow, study.start);
  cost.finish("start");
  run_steps(*fluid, row.steps, study.monitor);
  cost.finish(phase);
  compare(*fluid, flow, storages_are_compared(study) && plane == study.planes.front(), row);
  cost.finish("errors");
  return row;
}

// Of the first plane and storage.
void add_convergence(const VortexStudy& study, const std::vector<Row>& rows, Observations& seen) {
  Record record{"convergence",
                "Error at the end against the spacing, diffusive scaling",
                {{"spacing", "h", "1", "node spacing over the box", {}}}};
  struct Norm {
    std::string name;
    double (*of)(const Row&);
  };
  std::vector<Norm> norms{{"velocity_l1", [](const Row& row) { return row.velocity_error.l1; }},
                          {"velocity_l2", [](const Row& row) { return row.velocity_error.l2; }},
                          {"velocity_linf", [](const Row& row) { return row.velocity_error.linf; }}};
  if (study.pattern == Pattern::TaylorGreen)
    norms.push_back({"pressure_l2", [](const Row& row) { return row.pressure_error; }});
  std::vector<double> spacing;
  for (const std::int64_t n : study.nodes) spacing.push_back(1.0 / static_cast<double>(n));
  record.columns[0].values = spacing;
  for (const Norm& norm : norms) {
    observe::Column column{"error_" + norm.name, "", "1", "over that norm of the exact field", {}};
    for (std::size_t i = 0; i < study.nodes.size(); ++i) column.values.push_back(norm.of(rows[i]));
    // Sound that is left over rings through the pressure, in another phase at the end of each run: only all
    // grids together show its order.
    const bool rings = norm.name == "pressure_l2";
    const double order = rings ? engine::power_law(spacing, column.values).exponent
                               : engine::orders(spacing, column.values).back();
    seen.metrics.push_back({"order_" + norm.name, order, "1",
                            rings ? "over all grids, least squares" : "between the two finest grids"});
    seen.metrics.push_back({"error_" + norm.name, column.values.back(), "1", "of the finest grid"});
    record.columns.push_back(column);
  }
  seen.records.insert(seen.records.begin(), record);
}

// A row for each run, in the order of the phases `work_precision/<row>`.
Record work_record() {
  return {"work_precision",
          "Error of the velocity against the work done",
          {{"nodes", "N", "1", "nodes along a side", {}},
           {"bits", "", "1", "of a stored population", {}},
           {"plane", "", "1", "0, 1, 2: the plane begins with x, y, z", {}},
           {"steps", "", "1", "until the end", {}},
           {"amplitude", "A", "L T^-1", "of the velocity at the start", {}},
           {"error", "", "1", "of the velocity at the end, L2, relative", {}}}};
}

std::vector<double> work_row(const Row& row) {
  return {static_cast<double>(row.nodes),
          8.0 * static_cast<double>(fluid::bytes_of(row.storage)),
          static_cast<double>(axes_of(row.plane)[0]),
          static_cast<double>(row.steps),
          row.amplitude,
          row.velocity_error.l2};
}

// What rounding to float does to the velocity, beside the discretisation error; first plane.
void add_storage(const VortexStudy& study, const std::vector<Row>& rows, Observations& seen) {
  const std::size_t n = study.nodes.size();
  const bool double_first = study.storages.front() == fluid::Storage::Double;
  Record record{"storage",
                "Error of storing populations in float beside the discretisation error",
                {{"nodes", "N", "1", "nodes along a side", {}},
                 {"discretisation_error", "", "1", "double against the exact velocity, L2, relative", {}},
                 {"storage_error", "", "1", "float against double, L2, relative", {}},
                 {"share", "", "1", "storage error over discretisation error", {}}}};
  for (std::size_t i = 0; i < n; ++i) {
    const Row& whole = rows[double_first ? i : n + i];
    const Row& half = rows[double_first ? n + i : i];
    const double rounding = (half.velocity - whole.velocity).norm() / whole.velocity_norm;
    record.append({static_cast<double>(whole.nodes), whole.velocity_error.l2, rounding,
                   rounding / whole.velocity_error.l2});
  }
  const std::vector<double>& nodes = record.columns[0].values;
  const std::vector<double>& share = record.columns[3].values;
  const engine::PowerLaw law = engine::power_law(nodes, share);
  seen.metrics.push_back(
      {"float_error", record.columns[2].values.back(), "1", "of storing in float, relative, finest grid"});
  seen.metrics.push_back(
      {"float_share", share.back(), "1", "storage error over discretisation error, finest grid"});
  seen.metrics.push_back({"float_drowns_at", std::pow(law.factor, -1.0 / law.exponent), "1",
                          "N at which float's error is as large as the discretisation's: power law through "
                          "all grids"});
  seen.records.push_back(record);
}

// Largest relative difference of the error between planes at the same resolution: the lattice looks the same
// along all axes, so that only rounding may tell them apart.
double spread_of_planes(const VortexStudy& study, const std::vector<Row>& rows) {
  const std::size_t per_plane = study.nodes.size() * study.storages.size();
  double worst = 0.0;
  for (std::size_t i = per_plane; i < rows.size(); ++i) {
    const double first = rows[i % per_plane].velocity_error.l2;
    worst = worse(worst, std::abs(rows[i].velocity_error.l2 / first - 1.0));
  }
  return worst;
}

void run(const VortexStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  seen.records.push_back(work_record());
  std::vector<Row> rows;
  const std::size_t count = study.planes.size() * study.storages.size() * study.nodes.size();
  for (const std::string& plane : study.planes) {
    for (const fluid::Storage storage : study.storages) {
      for (const std::int64_t n : study.nodes) {
        progress.show("sweep", rows.size(), count);
        rows.push_back(
            measure(study, plane, storage, n, cost, fmt::format("work_precision/{}", rows.size())));
        seen.records.front().append(work_row(rows.back()));
      }
    }
  }
  add_convergence(study, rows, seen);
  if (storages_are_compared(study)) add_storage(study, rows, seen);
  if (study.planes.size() > 1)
    seen.metrics.push_back({"spread_of_planes", spread_of_planes(study, rows), "1",
                            "largest relative difference of the error between planes"});
}

std::vector<std::string> measured_names(const VortexStudy& study) {
  std::vector<std::string> names;
  for (const char* norm : {"velocity_l1", "velocity_l2", "velocity_linf", "pressure_l2"}) {
    if (study.pattern == Pattern::Shear && norm == std::string("pressure_l2")) continue;
    names.insert(names.end(), {std::string("order_") + norm, std::string("error_") + norm});
  }
  if (storages_are_compared(study))
    names.insert(names.end(), {"float_error", "float_share", "float_drowns_at"});
  if (study.planes.size() > 1) names.push_back("spread_of_planes");
  return names;
}

std::vector<std::string> read_names(const io::Table& table, const std::string& key,
                                    const std::vector<std::string>& known) {
  const std::vector<std::string> names = table.texts(key);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const bool repeated = std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i),
                                    names[i]) != names.begin() + static_cast<std::ptrdiff_t>(i);
    if (repeated || std::find(known.begin(), known.end(), names[i]) == known.end()) {
      table.fail(key, fmt::format("'{}' holds \"{}\"", key, names[i]),
                 repeated ? "it stands there twice" : fmt::format("known are {}", fmt::join(known, ", ")),
                 "Name each at most once");
    }
  }
  if (names.empty()) table.fail(key, "it is empty", "there is nothing to run", "Leave it out");
  return names;
}

}  // namespace

engine::Study read_vortex(const io::Table& top) {
  const io::Table t = top.table("vortex");
  VortexStudy study{.fluid = read_periodic_fluid(top, engine::Varied::Nodes),
                    .pattern = t.choice("flow", {"taylor-green", "shear"}) == "shear" ? Pattern::Shear
                                                                                      : Pattern::TaylorGreen,
                    .planes = t.has("planes") ? read_names(t, "planes", {"xy", "yz", "zx"})
                                              : std::vector<std::string>{"xy"},
                    .storages = {},
                    .nodes = read_resolutions(t, 2, 4),
                    .reynolds = t.number("reynolds"),
                    .decays = t.number("decays"),
                    .start = Start::Balanced,
                    .monitor = engine::read_monitor(top)};
  if (t.has("start")) {
    const std::string start = t.choice("start", {"balanced", "without-swelling", "equilibrium"});
    study.start = start == "balanced"           ? Start::Balanced
                  : start == "without-swelling" ? Start::WithoutSwelling
                                                : Start::Equilibrium;
  }
  if (t.has("storages")) {
    for (const std::string& name : read_names(t, "storages", names_of(fluid::storages)))
      study.storages.push_back(row_named(fluid::storages, name).value);
  } else {
    study.storages = {study.fluid.storage};
  }
  for (const auto& [key, value] : {std::pair{"reynolds", study.reynolds}, {"decays", study.decays}}) {
    if (!(value > 0.0))
      t.fail(key, fmt::format("'{}' is {}", key, value), "it must be positive", "Use for example 1.0");
  }
  if (study.decays > max_decays)
    t.fail("decays", fmt::format("'decays' is {}", study.decays),
           fmt::format("after {} e-foldings nothing is left of the flow but rounding", max_decays),
           "Use for example 1.0");
  const DecayingFlow finest = flow_of(study, study.planes.front(), study.nodes.back());
  if (finest.amplitude < min_velocity)
    t.fail("reynolds", fmt::format("the finest grid would start with a velocity of {:.3g}", finest.amplitude),
           fmt::format("below {} its square is lost to underflow", min_velocity), "Use for example 1.0");
  require_steps(top.table("fluid"), study.decays / finest.decay_rate());
  const DecayingFlow coarsest = flow_of(study, study.planes.front(), study.nodes.front());
  const double mach = coarsest.amplitude / std::sqrt(fluid::sound_speed_squared);
  if (mach > study.monitor.mach_limit) {
    t.fail(
        "reynolds", fmt::format("the coarsest grid would start at Mach number {:.3g}", mach),
        fmt::format("the monitor's limit is {}: the flow is to be incompressible", study.monitor.mach_limit),
        "Use a smaller Reynolds number, more nodes or a smaller relaxation time");
  }
  std::vector<fluid::Spec> runs;
  double kept = 0.0;  // velocities of the first plane  [bytes]
  for (const std::string& plane : study.planes) {
    for (const fluid::Storage storage : study.storages) {
      for (const std::int64_t n : study.nodes) {
        runs.push_back(spec_of(study, plane, storage, n));
        const bool compared = storages_are_compared(study) && plane == study.planes.front();
        if (compared) kept += 3.0 * sizeof(double) * static_cast<double>(runs.back().grid.count());
      }
    }
  }
  return {.plan = plan_in_turn(top, runs, kept),
          .measures = measured_names(study),
          .run = [study](Observations& seen, Progress& progress, engine::Cost& cost) {
            run(study, seen, progress, cost);
          }};
}

}  // namespace veriflex::measures
