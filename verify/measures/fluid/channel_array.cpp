#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "analytic/channel.hpp"
#include "base/root.hpp"
#include "engine/read_scene.hpp"
#include "measures/fluid/channel.hpp"
#include "observe/field.hpp"

// One obstacle in a periodic cell is an array of them. Once the flow is steady the obstacle takes up all that
// the force gives to the fluid; the mean pressure gradient g that the force stands for acts on the obstacle
// too, so that its drag is g times the volume of the whole cell.

namespace veriflex::measures::channel {

namespace {

using observe::Observations;

/// A cell of `nodes` along x: all lengths of the one of [fluid] grow alike, forces fall as the third power,
/// so that the Reynolds number stays. Along a cylinder nothing varies, and nothing is refined.
struct Array {
  fluid::Spec fluid;
  fluid::Shape shape;
  std::size_t flow;  // axis of the force
  Steady steady;
  observe::MonitorSpec monitor;
  bool has_series;  // of the drag, to hold it against
};

double radius_of(const fluid::Shape& shape) {
  return std::visit([](const auto& s) { return s.radius; }, shape);
}

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
  const double own = radius_of(shape);
  const double size = radius / own;
  if (std::holds_alternative<fluid::Sphere>(shape)) {
    return size * analytic::sphere_array_drag(solid_fraction(grid, shape) * size * size * size);
  }
  return analytic::cylinder_array_drag(solid_fraction(grid, shape) * size * size);
}

/// The radius at which the series gives this drag; not a number when none near the shape's own does.
double radius_of_drag(const Grid& grid, const fluid::Shape& shape, double drag) {
  const double own = radius_of(shape);
  const auto excess = [&](double radius) { return exact_drag(grid, shape, radius) - drag; };
  const double low = 0.75 * own, high = 1.25 * own;
  if (excess(low) > 0.0 || excess(high) < 0.0) return std::numeric_limits<double>::quiet_NaN();
  return bracketed_root(excess, low, high);
}

/// The radius of the shape whose volume is that of the voxels.
double radius_of_voxels(const Array& cell) {
  const double own = radius_of(cell.shape);
  const double volume =
      static_cast<double>(cell.fluid.obstacle.size()) / static_cast<double>(cell.fluid.grid.count());
  const double ratio = volume / solid_fraction(cell.fluid.grid, cell.shape);
  return own * (std::holds_alternative<fluid::Sphere>(cell.shape) ? std::cbrt(ratio) : std::sqrt(ratio));
}

void refine(Array& cell, std::int64_t times) {
  const auto factor = static_cast<double>(times);
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
}

/// F/(mu U) per length of a cylinder, F/(6 pi mu a U) of a sphere.
double drag_of(const Array& cell, Progress& progress) {
  const scene::Simulation end = run_to_steady(cell.fluid, observe::plane(cell.fluid.grid, cell.flow, 0),
                                              cell.steady, cell.monitor, progress);
  const auto axis = static_cast<Eigen::Index>(cell.flow);
  const double g = cell.fluid.body_force[axis];
  const auto volume = static_cast<double>(cell.fluid.grid.count());
  const double fluid_volume = volume - static_cast<double>(cell.fluid.obstacle.size());
  const double velocity = (end.fluid().totals().momentum[axis] + 0.5 * g * fluid_volume) / volume;
  const double viscosity = fluid::viscosity(cell.fluid.relaxation_time);
  if (const auto* sphere = std::get_if<fluid::Sphere>(&cell.shape)) {
    return g * volume / (6.0 * std::numbers::pi * viscosity * sphere->radius * velocity);
  }
  const auto length = static_cast<double>(cell.fluid.grid.size[std::get<fluid::Cylinder>(cell.shape).axis]);
  return g * volume / length / (viscosity * velocity);
}

Observations array_observations(bool has_series) {
  Observations all;
  all.metrics = {{"drag", {}, "1", "in units of viscosity, mean velocity and size"},
                 {"solid_fraction", {}, "1", "as asked for"},
                 {"voxels_larger", {}, "L", "radius that has the voxels' volume, beyond the true one"}};
  if (!has_series) return all;
  all.metrics.insert(
      all.metrics.end(),
      {{"drag_exact", {}, "1", "series"},
       {"drag_of_voxels", {}, "1", "series for an obstacle of the volume of the voxels"},
       {"error_drag", {}, "1", "relative"},
       {"error_voxels", {}, "1", "against an obstacle of the volume of the voxels, relative"},
       {"drag_larger", {}, "L", "radius that has the measured drag, beyond the true one"},
       {"offset", {}, "L", "distance of the radius that has the measured drag from the true one"},
       {"roughness",
        {},
        "L",
        "radius that has the measured drag, beyond the one that has the voxels' volume"}});
  return all;
}

void run_array(const Array& cell, Observations& seen, Progress& progress) {
  const Grid& grid = cell.fluid.grid;
  const double drag = drag_of(cell, progress);
  const double radius = radius_of(cell.shape);
  const double of_volume = radius_of_voxels(cell);
  seen.set("drag", drag);
  seen.set("solid_fraction", solid_fraction(grid, cell.shape));
  seen.set("voxels_larger", of_volume - radius);
  if (!cell.has_series) return;
  const double exact = exact_drag(grid, cell.shape, radius);
  const double of_voxels = exact_drag(grid, cell.shape, of_volume);
  const double larger = radius_of_drag(grid, cell.shape, drag) - radius;
  seen.set("drag_exact", exact);
  seen.set("drag_of_voxels", of_voxels);
  seen.set("error_drag", std::abs(drag / exact - 1.0));
  seen.set("error_voxels", std::abs(drag / of_voxels - 1.0));
  seen.set("drag_larger", larger);
  seen.set("offset", std::abs(larger));
  seen.set("roughness", larger - (of_volume - radius));
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
              .steady = {},
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
  const std::int64_t nodes = read_nodes(t);
  if (nodes % grid.size[0] != 0) {
    t.fail("nodes", fmt::format("'nodes' is {}, no multiple of the cell's {} along x", nodes, grid.size[0]),
           "the cell of [fluid] is refined by whole factors",
           fmt::format("Give for example {}", 2 * grid.size[0]));
  }
  const double radius = radius_of(shape);
  if (2.0 * radius >= static_cast<double>(grid.size[cylinder != nullptr && cylinder->axis == 0 ? 1 : 0])) {
    table.table("obstacle")
        .fail("radius", fmt::format("'radius' is {}", radius),
              "the obstacle touches its own images and is no array of bodies",
              "Use less than half of the cell");
  }
  study.has_series = solid_fraction(grid, shape) <= (cylinder == nullptr ? 0.1251 : 0.1001);
  study.fluid.obstacle.clear();
  refine(study, nodes / grid.size[0]);
  // Flow past obstacles comes to rest more slowly than between walls a quarter of the cell apart.
  study.steady =
      read_steady(t, 1e-9, spec, 0.25 * static_cast<double>(nodes), fmt::format("a cell of {} nodes", nodes));
  engine::read_plan(top, {.fluid = study.fluid});  // refuses a box beyond the memory before it is cut
  study.fluid.obstacle = fluid::voxels(study.fluid.grid, study.shape, fluid::closed(study.fluid));
  return study_of(top, {.fluid = study.fluid}, array_observations(study.has_series), study, run_array);
}

}  // namespace veriflex::measures::channel
