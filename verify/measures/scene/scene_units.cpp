#include <algorithm>
#include <cmath>

#include "bond/derive.hpp"
#include "engine/units.hpp"
#include "measures/scene/scene.hpp"

// The numbers that a scene is told by: how fast and how long, and what its bodies are made of.

namespace veriflex::measures {

namespace {

// The fastest motion that the case itself gives [L T^-1]; 0 where it gives none.
double speed_of(const io::Table& top, const scene::Scene& scene) {
  double speed = 0.0;
  const auto also = [&](double more) { speed = std::max(speed, more); };
  for (const std::optional<fluid::Walls>& walls : scene.fluid->walls) {
    if (walls) also(std::max(walls->low_velocity.norm(), walls->high_velocity.norm()));
  }
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

// The largest extent of a body in the fluid, else the least of the box [L].
double length_of(const scene::Scene& scene) {
  double length = 0.0;
  for (const scene::Body& body : scene.bodies) {
    if (!body.coupling) continue;
    const Vec3 extent = body.network.rest.colwise().maxCoeff() - body.network.rest.colwise().minCoeff();
    length = std::max(length, extent.maxCoeff());
  }
  const std::array<std::int64_t, 3>& size = scene.fluid->grid.size;
  return length > 0.0 ? length : static_cast<double>(std::min({size[0], size[1], size[2]}));
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
