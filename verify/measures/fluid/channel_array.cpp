#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "analytic/channel.hpp"
#include "base/root.hpp"
#include "engine/read_scene.hpp"
#include "measures/fluid/channel.hpp"
#include "measures/for_all.hpp"
#include "observe/field.hpp"

// One obstacle in a periodic cell is an array of them. Once the flow is steady the obstacle takes up all that
// the force gives to the fluid; the mean pressure gradient g that the force stands for acts on the obstacle
// too, so that its drag is g times the volume of the whole cell.

namespace veriflex::measures::channel {

namespace {

using observe::Observations;
using observe::Record;

struct Array {
  fluid::Spec fluid;  // at the first resolution
  fluid::Shape shape;
  std::size_t flow;  // axis of the force
  std::vector<std::int64_t> resolutions;
  Steady steady;
  observe::MonitorSpec monitor;
  bool has_series;  // of the drag, to hold it against
};

/// A cell of `nodes` along x: all lengths grow alike, forces fall as the third power, so that the Reynolds
/// number stays. Along a cylinder nothing varies, and nothing is refined.
struct Cell {
  fluid::Spec fluid;  // without the voxels of the shape
  fluid::Shape shape;
};

/// Volume fraction of the obstacle as given, not as cut out of the lattice.
double solid_fraction(const Grid& grid, const fluid::Shape& shape) {
  const auto volume = static_cast<double>(grid.count());
  if (const auto* sphere = std::get_if<fluid::Sphere>(&shape)) {
    return 4.0 / 3.0 * std::numbers::pi * std::pow(sphere->radius, 3) / volume;
  }
  const auto& cylinder = std::get<fluid::Cylinder>(shape);
  return std::numbers::pi * cylinder.radius * cylinder.radius *
         static_cast<double>(grid.size[cylinder.axis]) / volume;
}

/// The series, in the units of the shape's own radius, if its true radius were `radius`.
double exact_drag(const Grid& grid, const fluid::Shape& shape, double radius) {
  const double own = std::visit([](const auto& s) { return s.radius; }, shape);
  const double size = radius / own;
  if (std::holds_alternative<fluid::Sphere>(shape)) {
    return size * analytic::sphere_array_drag(solid_fraction(grid, shape) * size * size * size);
  }
  return analytic::cylinder_array_drag(solid_fraction(grid, shape) * size * size);
}

/// The radius at which the series gives this drag; not a number when none near the shape's own does.
double radius_of_drag(const Grid& grid, const fluid::Shape& shape, double drag) {
  const double own = std::visit([](const auto& s) { return s.radius; }, shape);
  const auto excess = [&](double radius) { return exact_drag(grid, shape, radius) - drag; };
  const double low = 0.75 * own, high = 1.25 * own;
  if (excess(low) > 0.0 || excess(high) < 0.0) return std::numeric_limits<double>::quiet_NaN();
  return bracketed_root(excess, low, high);
}

/// The radius of the shape whose volume is that of the voxels.
double radius_of_voxels(const Cell& cell) {
  const double own = std::visit([](const auto& s) { return s.radius; }, cell.shape);
  const double volume =
      static_cast<double>(cell.fluid.obstacle.size()) / static_cast<double>(cell.fluid.grid.count());
  const double ratio = volume / solid_fraction(cell.fluid.grid, cell.shape);
  return own * (std::holds_alternative<fluid::Sphere>(cell.shape) ? std::cbrt(ratio) : std::sqrt(ratio));
}

Cell refined(const Array& study, std::int64_t nodes) {
  const std::int64_t times = nodes / study.fluid.grid.size[0];
  const auto factor = static_cast<double>(times);
  Cell cell{study.fluid, study.shape};
  cell.fluid.obstacle.clear();
  cell.fluid.body_force /= factor * factor * factor;
  const auto grow = [factor](auto& shape) {
    shape.centre = ((shape.centre.array() + 0.5) * factor - 0.5).matrix();
    shape.radius *= factor;
  };
  std::visit(grow, cell.shape);
  const auto* cylinder = std::get_if<fluid::Cylinder>(&cell.shape);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (cylinder == nullptr || axis != cylinder->axis) cell.fluid.grid.size[axis] *= times;
  }
  return cell;
}

Cell cut_out(Cell cell) {
  cell.fluid.obstacle = fluid::voxels(cell.fluid.grid, cell.shape, fluid::closed(cell.fluid));
  return cell;
}

/// F/(mu U) per length of a cylinder, F/(6 pi mu a U) of a sphere.
double drag_of(const Array& study, const Cell& cell) {
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(cell.fluid);
  run_to_steady(*fluid, observe::plane(cell.fluid.grid, study.flow, 0), study.steady, study.monitor);
  const auto axis = static_cast<Eigen::Index>(study.flow);
  const double g = cell.fluid.body_force[axis];
  const auto volume = static_cast<double>(cell.fluid.grid.count());
  const double fluid_volume = volume - static_cast<double>(cell.fluid.obstacle.size());
  const double velocity = (fluid->totals().momentum[axis] + 0.5 * g * fluid_volume) / volume;
  const double viscosity = fluid::viscosity(cell.fluid.relaxation_time);
  if (const auto* sphere = std::get_if<fluid::Sphere>(&cell.shape)) {
    return g * volume / (6.0 * std::numbers::pi * viscosity * sphere->radius * velocity);
  }
  const auto length = static_cast<double>(cell.fluid.grid.size[std::get<fluid::Cylinder>(cell.shape).axis]);
  return g * volume / length / (viscosity * velocity);
}

/// Slope of log(error) against log(spacing) by least squares.
double mean_order(const std::vector<double>& spacing, const std::vector<double>& error) {
  const auto n = static_cast<Eigen::Index>(spacing.size());
  const Eigen::ArrayXd x = Eigen::Map<const Eigen::ArrayXd>(spacing.data(), n).log();
  const Eigen::ArrayXd y = Eigen::Map<const Eigen::ArrayXd>(error.data(), n).log();
  return ((x - x.mean()) * (y - y.mean())).sum() / (x - x.mean()).square().sum();
}

Record drag_record(const Array& study) {
  Record record{"drag",
                "Drag of each obstacle of the array",
                {{"nodes", "", "1", "across a cell", {}},
                 {"drag", "", "1", "in units of viscosity, mean velocity and size", {}},
                 {"voxels_larger", "", "L", "radius that has the voxels' volume, beyond the true one", {}}}};
  if (!study.has_series) return record;
  record.columns.push_back({"drag_exact", "", "1", "series", {}});
  record.columns.push_back(
      {"drag_of_voxels", "", "1", "series for an obstacle of the volume of the voxels", {}});
  record.columns.push_back(
      {"drag_larger", "", "L", "radius that has the measured drag, beyond the true one", {}});
  return record;
}

Record convergence_record() {
  return {"convergence",
          "Error of the drag",
          {{"spacing", "", "1", "1/nodes across a cell", {}},
           {"error_drag", "", "1", "relative", {}},
           {"error_voxels", "", "1", "against an obstacle of the volume of the voxels", {}}}};
}

/// Of one resolution, as soon as its drag is known.
void add_row(const Array& study, std::int64_t nodes, double drag, Observations& seen) {
  const Cell cell = cut_out(refined(study, nodes));
  const Grid& grid = cell.fluid.grid;
  const double radius = std::visit([](const auto& s) { return s.radius; }, cell.shape);
  const double of_volume = radius_of_voxels(cell);
  std::vector<double> row{static_cast<double>(nodes), drag, of_volume - radius};
  if (study.has_series) {
    const double exact = exact_drag(grid, cell.shape, radius);
    const double of_voxels = exact_drag(grid, cell.shape, of_volume);
    row.insert(row.end(), {exact, of_voxels, radius_of_drag(grid, cell.shape, drag) - radius});
    insert(seen.records[1], Order::Falling,
           std::array{1.0 / static_cast<double>(nodes), std::abs(drag / exact - 1.0),
                      std::abs(drag / of_voxels - 1.0)});
  }
  insert(seen.records[0], Order::Rising, row);
}

std::vector<std::int64_t> finest_first(const Array& study) {  // it takes longest
  return {study.resolutions.rbegin(), study.resolutions.rend()};
}

void run(const Array& study, Observations& seen, Progress& progress) {
  seen.records.push_back(drag_record(study));
  if (study.has_series) seen.records.push_back(convergence_record());
  const std::vector<std::int64_t> nodes = finest_first(study);
  std::vector<double> drags(nodes.size());
  for_all(
      nodes.size(), "cells", progress,
      [&](std::size_t i) { drags[i] = drag_of(study, cut_out(refined(study, nodes[i]))); },
      [&](std::size_t i) { add_row(study, nodes[i], drags[i], seen); });
  seen.metrics = {{"drag", drags.front(), "1", "of the finest resolution"},
                  {"solid_fraction", solid_fraction(study.fluid.grid, study.shape), "1", "as asked for"}};
  if (!study.has_series) return;

  const Record& record = seen.records[0];
  const Record& convergence = seen.records[1];
  const std::vector<double>& spacing = convergence.find("spacing")->values;
  double offset = 0.0;
  for (const double larger : record.find("drag_larger")->values) offset = worse(offset, std::abs(larger));
  const double rough =
      record.find("drag_larger")->values.back() - record.find("voxels_larger")->values.back();
  seen.metrics.insert(
      seen.metrics.end(),
      {{"order_drag", mean_order(spacing, convergence.find("error_drag")->values), "1",
        "in the spacing, least squares over all resolutions"},
       {"order_voxels", mean_order(spacing, convergence.find("error_voxels")->values), "1",
        "in the spacing, least squares over all resolutions"},
       {"max_offset", offset, "L",
        "largest distance of the radius that has the measured drag from the true one"},
       {"roughness", rough, "L",
        "radius that has the measured drag, beyond the one that has the voxels' volume; finest resolution"}});
}

std::size_t read_flow_axis(const io::Table& fluid, const fluid::Spec& spec, const fluid::Shape& shape) {
  const auto* cylinder = std::get_if<fluid::Cylinder>(&shape);
  const Vec3& g = spec.body_force;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double size = std::abs(g[static_cast<Eigen::Index>(axis)]);
    if (size > 0.0 && size == g.norm() && (cylinder == nullptr || cylinder->axis != axis)) return axis;
  }
  fluid.fail("body_force", "it is zero, oblique, or along the cylinder",
             "the drag is measured along one axis across the obstacle", "Set one component of it");
}

}  // namespace

engine::Study read_array(const io::Table& top) {
  const io::Table t = top.table("channel");
  const io::Table table = top.table("fluid");
  const fluid::Spec spec = engine::read_fluid(top);
  const fluid::Shape shape = engine::read_obstacle(table);
  for (const char* key : {"walls_x", "walls_y", "walls_z"}) {
    if (table.has(key)) table.fail(key, "the cell has walls", "the array is periodic", "Leave them out");
  }
  Array study{.fluid = spec,
              .shape = shape,
              .flow = read_flow_axis(table, spec, shape),
              .resolutions = t.integers("resolutions"),
              .steady = read_steady(t, 1e-9, spec.storage),
              .monitor = engine::read_monitor(top),
              .has_series = false};
  const auto& grid = spec.grid;
  const auto* cylinder = std::get_if<fluid::Cylinder>(&shape);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (grid.size[axis] != grid.size[0] && (cylinder == nullptr || axis != cylinder->axis)) {
      table.fail("nodes", "the cell is not a cube, or not a square across the cylinder",
                 "the known drag is that of square and cubic arrays", "Make them equal");
    }
  }
  std::int64_t before = 0;
  for (const std::int64_t nodes : study.resolutions) {
    if (nodes <= before || nodes % grid.size[0] != 0 || nodes > 4096) {
      t.fail("resolutions", "they do not rise, are no multiples of the cell's nodes along x, or exceed 4096",
             "the cell of [fluid] is refined by whole factors",
             fmt::format("Give for example [{}, {}, {}]", grid.size[0], 2 * grid.size[0], 4 * grid.size[0]));
    }
    before = nodes;
  }
  if (study.resolutions.size() < 2) {
    t.fail("resolutions", "fewer than two", "an order needs two", "Give two or more");
  }
  const double radius = std::visit([](const auto& s) { return s.radius; }, shape);
  if (2.0 * radius >= static_cast<double>(grid.size[cylinder != nullptr && cylinder->axis == 0 ? 1 : 0])) {
    table.table("obstacle")
        .fail("radius", fmt::format("'radius' is {}", radius),
              "the obstacle touches its own images and is no array of bodies",
              "Use less than half of the cell");
  }
  study.has_series = solid_fraction(grid, shape) <= (cylinder == nullptr ? 0.1251 : 0.1001);
  std::vector<std::string> measures{"drag", "solid_fraction"};
  if (study.has_series)
    measures.insert(measures.end(), {"order_drag", "order_voxels", "max_offset", "roughness"});
  std::vector<fluid::Spec> runs;
  for (const std::int64_t nodes : finest_first(study)) runs.push_back(refined(study, nodes).fluid);
  plan_at_once(top, runs);  // refuses boxes beyond the memory before they are cut
  // Flow past obstacles comes to rest more slowly than between walls a quarter of the cell apart.
  const double rate =
      slowest_rate(spec.relaxation_time, 0.25 * static_cast<double>(study.resolutions.back()));
  require_in_reach(t, study.steady, rate, fmt::format("a cell of {} nodes", study.resolutions.back()));
  for (std::size_t i = 0; i < runs.size(); ++i)
    runs[i] = cut_out(refined(study, finest_first(study)[i])).fluid;
  return {
      .plan = plan_at_once(top, runs),
      .measures = measures,
      .run = [study](Observations& seen, Progress& progress, engine::Cost&) { run(study, seen, progress); }};
}

}  // namespace veriflex::measures::channel
