#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>
#include <vector>

#include "bond/derive.hpp"
#include "engine/units.hpp"
#include "measures/scene/scene.hpp"

// The numbers that a scene is told by: how fast and how long, and what its bodies are made of.

namespace veriflex::measures {

namespace {

// Of the undisturbed flow that the uniform force drives between the nearest walls [L T^-1]; 0 without either.
double speed_of_force(const fluid::Spec& fluid) {
  const double viscosity = fluid::viscosity(fluid.relaxation_time);
  double speed = 0.0, nearest = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const auto gap = static_cast<double>(fluid.grid.size[static_cast<std::size_t>(axis)]);
    Vec3 along = fluid.body_force;
    along[axis] = 0.0;
    if (!fluid.walls[static_cast<std::size_t>(axis)] || along.isZero(0.0) || gap > nearest) continue;
    nearest = gap;
    speed = along.norm() * gap * gap / (8.0 * viscosity);
  }
  return speed;
}

// The fastest motion that the case itself gives [L T^-1]; 0 where it gives none.
double speed_of(const io::Table& top, const scene::Scene& scene) {
  double speed = 0.0;
  const auto also = [&](double more) { speed = std::max(speed, more); };
  for (const std::optional<fluid::Walls>& walls : scene.fluid->walls) {
    if (!walls) continue;
    also(std::max(walls->low_velocity.norm(), walls->high_velocity.norm()));
    for (const auto& opening : walls->openings) {
      if (const auto* inflow = std::get_if<fluid::Inflow>(&opening)) also(inflow->velocity.norm());
    }
  }
  also(speed_of_force(*scene.fluid));
  const io::Table fluid = top.table("fluid");
  if (fluid.has("initial") && fluid.table("initial").has("velocity")) {
    const std::vector<double> u = fluid.table("initial").numbers("velocity");
    if (u.size() == 3) also(Vec3(u[0], u[1], u[2]).norm());
  }
  for (const scene::Body& body : scene.bodies) {
    if (body.motion) also(body.motion->velocity.norm() + body.motion->amplitude.norm() * body.motion->omega);
    if (const auto& drive = body.conditions.drive) also(std::abs(drive->amplitude) * drive->omega);
  }
  return speed;
}

// The largest extent of the obstacle along axes that it does not go through from end to end [L]; 0 without
// one.
double length_of_obstacle(const fluid::Spec& fluid) {
  double length = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t size = fluid.grid.size[axis];
    std::vector<bool> met(static_cast<std::size_t>(size));
    for (const std::int64_t node : fluid.obstacle)
      met[static_cast<std::size_t>(fluid.grid.node(node)[axis])] = true;
    const std::int64_t extent = std::count(met.begin(), met.end(), true);
    if (extent < size) length = std::max(length, static_cast<double>(extent));
  }
  return length;
}

// The largest extent of a body in the fluid, else of the obstacle, else between the nearest walls, else
// the least of the box [L].
double length_of(const scene::Scene& scene) {
  double length = 0.0;
  for (const scene::Body& body : scene.bodies) {
    if (!body.coupling) continue;
    const Vec3 extent = body.network.rest.colwise().maxCoeff() - body.network.rest.colwise().minCoeff();
    length = std::max(length, extent.maxCoeff());
  }
  if (length == 0.0) length = length_of_obstacle(*scene.fluid);
  if (length > 0.0) return length;
  const std::array<std::int64_t, 3>& sizes = scene.fluid->grid.size;
  std::int64_t least = *std::max_element(sizes.begin(), sizes.end());
  const bool is_open = std::none_of(scene.fluid->walls.begin(), scene.fluid->walls.end(),
                                    [](const auto& walls) { return walls.has_value(); });
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool counts = is_open || scene.fluid->walls[axis];
    if (counts && sizes[axis] > 1) least = std::min(least, sizes[axis]);  // a box one node deep is plane
  }
  return static_cast<double>(least);
}

}  // namespace

std::vector<engine::Quantity> quantities_of(const io::Table& top) {
  const scene::Scene scene = read_fluid_and_bodies(top).scene;
  const std::optional<engine::CaseUnits> units = engine::read_units(top);
  engine::Told told;
  if (scene.fluid) {
    told.relaxation_time = scene.fluid->relaxation_time;
    told.length = length_of(scene);
    if (units && units->length) told.length = *units->length / units->units.spacing;
    double speed = speed_of(top, scene);
    if (units && units->speed) speed = *units->speed / units->units.factor(0, 1, -1);
    if (speed > 0.0) told.speed = speed;
  }
  for (const scene::Body& body : scene.bodies) {
    if (body.motion) continue;
    const double r0 = body.network.spacing;
    told.bodies.push_back({.name = body.name,
                           .young_modulus = bond::derive(body.material.law).young_modulus,
                           .density = body.conditions.node_mass / (r0 * r0 * r0),
                           .is_coupled = body.coupling.has_value()});
  }
  return engine::quantities(told, units ? std::optional(units->units) : std::nullopt);
}

}  // namespace veriflex::measures
