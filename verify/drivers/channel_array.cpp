#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "base/root.hpp"
#include "drivers/channel.hpp"
#include "drivers/for_all.hpp"
#include "engine/analytic/channel.hpp"
#include "engine/read_scene.hpp"
#include "observe/field.hpp"

// One obstacle in a periodic cell is an array of them. Once the flow is steady the obstacle takes up all that
// the force gives to the fluid; the mean pressure gradient g that the force stands for acts on the obstacle
// too, so that its drag is g times the volume of the whole cell.

namespace veriflex::drivers::channel {

namespace {

using observe::Observations;
using observe::Record;

struct Array {
  fluid::Spec fluid;  // at the first resolution
  fluid::Shape shape;
  std::size_t flow;  // axis of the force
  std::vector<std::int64_t> resolutions;
  Steady steady;
  observe::Watch watch;
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
    return size * engine::sphere_array_drag(solid_fraction(grid, shape) * size * size * size);
  }
  return engine::cylinder_array_drag(solid_fraction(grid, shape) * size * size);
}

/// The radius at which the series gives this drag; not a number when none near the shape's own does.
double radius_of_drag(const Grid& grid, const fluid::Shape& shape, double drag) {
  const double own = std::visit([](const auto& s) { return s.radius; }, shape);
  const auto excess = [&](double radius) { return exact_drag(grid, shape, radius) - drag; };
  const double least = 0.75 * own, most = 1.25 * own;
  if (excess(least) > 0.0 || excess(most) < 0.0) return std::numeric_limits<double>::quiet_NaN();
  return bracketed_root(excess, least, most);
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
  cell.fluid.obstacle = fluid::voxels(cell.fluid.grid, cell.shape);
  return cell;
}

/// F/(mu U) per length of a cylinder, F/(6 pi mu a U) of a sphere.
double drag_of(const Array& study, const Cell& cell) {
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(cell.fluid);
  march_to_steady(*fluid, observe::plane(cell.fluid.grid, study.flow, 0), study.steady, study.watch);
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

void run(const Array& study, Observations& seen, Progress& progress) {
  const std::size_t count = study.resolutions.size();
  std::vector<double> drags(count);
  for_all(count, "cells", progress, [&](std::size_t i) {  // the finest first: it takes longest
    drags[count - 1 - i] = drag_of(study, cut_out(refined(study, study.resolutions[count - 1 - i])));
  });
  Record record{"drag",
                "Drag of each obstacle of the array",
                {{"nodes", "", "1", "across a cell", {}},
                 {"drag", "", "1", "in units of viscosity, mean velocity and size", {}},
                 {"drag_exact", "", "1", "series", {}},
                 {"drag_of_voxels", "", "1", "series for an obstacle of the volume of the voxels", {}},
                 {"voxels_larger", "", "L", "radius that has the voxels' volume, beyond the true one", {}},
                 {"drag_larger", "", "L", "radius that has the measured drag, beyond the true one", {}}}};
  Record convergence{"convergence",
                     "Error of the drag",
                     {{"spacing", "", "1", "1/nodes across a cell", {}},
                      {"error_drag", "", "1", "relative", {}},
                      {"error_voxels", "", "1", "against an obstacle of the volume of the voxels", {}}}};
  for (std::size_t i = 0; i < count; ++i) {
    const Cell cell = cut_out(refined(study, study.resolutions[i]));
    const Grid& grid = cell.fluid.grid;
    const double radius = std::visit([](const auto& s) { return s.radius; }, cell.shape);
    const double exact = exact_drag(grid, cell.shape, radius);
    const double of_voxels = exact_drag(grid, cell.shape, radius_of_voxels(cell));
    const auto nodes = static_cast<double>(study.resolutions[i]);
    record.append({nodes, drags[i], exact, of_voxels, radius_of_voxels(cell) - radius,
                   radius_of_drag(grid, cell.shape, drags[i]) - radius});
    convergence.append({1.0 / nodes, std::abs(drags[i] / exact - 1.0), std::abs(drags[i] / of_voxels - 1.0)});
  }
  const std::vector<double>& spacing = convergence.find("spacing")->values;
  double offset = 0.0;
  for (const double larger : record.find("drag_larger")->values) {
    offset = worse(offset, std::abs(larger));
  }
  const double rough =
      record.find("drag_larger")->values.back() - record.find("voxels_larger")->values.back();
  seen = {
      .records = {record, convergence},
      .metrics = {{"drag", drags.back(), "1", "of the finest resolution"},
                  {"solid_fraction", solid_fraction(study.fluid.grid, study.shape), "1", "as asked for"},
                  {"order_drag", mean_order(spacing, convergence.find("error_drag")->values), "1",
                   "in the spacing, least squares over all resolutions"},
                  {"order_voxels", mean_order(spacing, convergence.find("error_voxels")->values), "1",
                   "in the spacing, least squares over all resolutions"},
                  {"largest_offset", offset, "L",
                   "largest distance of the radius that has the measured drag from the true one"},
                  {"roughness", rough, "L",
                   "radius that has the measured drag, beyond the one that has the voxels' volume; finest "
                   "resolution"}}};
}

std::size_t read_flow_axis(const io::Section& fluid, const fluid::Spec& spec, const fluid::Shape& shape) {
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

engine::Study read_array(const io::Section& top) {
  const io::Section t = top.table("channel");
  const io::Section table = top.table("fluid");
  const fluid::Spec spec = engine::read_fluid(top);
  const fluid::Shape shape = engine::read_obstacle(table);
  for (const char* key : {"walls_x", "walls_y", "walls_z"}) {
    if (table.has(key)) table.fail(key, "the cell has walls", "the array is periodic", "Leave them out");
  }
  const Array study{.fluid = spec,
                    .shape = shape,
                    .flow = read_flow_axis(table, spec, shape),
                    .resolutions = t.integers("resolutions"),
                    .steady = read_steady(t, 1e-9),
                    .watch = engine::read_watch(top)};
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
  const double most = cylinder == nullptr ? 0.1251 : 0.1001;
  if (const double fraction = solid_fraction(grid, shape); fraction > most) {
    table.fail("obstacle", fmt::format("the solid fraction is {:.4g}", fraction),
               fmt::format("the series for the drag holds to 0.1 % up to {:.3g}", most),
               "Use a smaller radius");
  }
  const Cell largest = refined(study, study.resolutions.back());
  engine::read_plan(top, {.fluid = largest.fluid});  // refuses a box beyond the memory before it is cut
  return study_of(
      top, cut_out(largest).fluid,
      {"drag", "solid_fraction", "order_drag", "order_voxels", "largest_offset", "roughness"},
      [study](Observations& seen, Progress& progress, engine::Cost&) { run(study, seen, progress); });
}

}  // namespace veriflex::drivers::channel
