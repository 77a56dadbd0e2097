#include "scene/offers.hpp"

#include <fmt/format.h>

#include <cmath>

#include "scene/coupling_stability.hpp"
#include "scene/markers.hpp"
#include "solid/modes.hpp"

namespace veriflex::scene {

namespace {

constexpr double share_of_limit = 0.5;  // of 2/omega_max at rest: bonds may become four times as stiff
constexpr double widest_support = 4.0;  // of a delta function  [L]

/// The least number of sub-steps that is stable; that of the body when none below is.
int least_substeps(const Scene& scene, const Body& body) {
  const solid::FixedDofs held = body.conditions.fixed.size() > 0
                                    ? body.conditions.fixed
                                    : solid::FixedDofs::Constant(body.network.node_count(), 3, false);
  const double omega =
      solid::largest_frequency(body.material, body.network, Positions::Zero(body.network.node_count(), 3),
                               held, body.conditions.node_mass);
  for (int count = 1; count < body.substeps.count; ++count) {
    if (omega / count > share_of_limit * 2.0) continue;
    if (!scene.fluid || !body.coupling) return count;
    Body fewer = body;
    fewer.substeps.count = count;
    if (!coupling_growth(*scene.fluid, fewer).grows()) return count;
  }
  return body.substeps.count;
}

/// Room that the bodies take along an axis, with the way that a drive or a motion takes them.
double room(const Scene& scene, int axis) {
  double widest = 0.0;
  for (const Body& body : scene.bodies) {
    if (!body.coupling) continue;
    const Positions X = markers_at_rest(body);
    double room = X.col(axis).maxCoeff() - X.col(axis).minCoeff() + widest_support;
    if (body.motion) room += 2.0 * std::abs(body.motion->amplitude[axis]);
    if (body.conditions.drive && body.conditions.drive->axis == axis)
      room += 2.0 * std::abs(body.conditions.drive->amplitude);
    widest = std::max(widest, room);
  }
  return widest;
}

}  // namespace

std::vector<Offer> offers(const Scene& scene, const std::function<std::string(std::size_t)>& substeps_of) {
  std::vector<Offer> all;
  if (scene.fluid && scene.fluid->storage == fluid::Storage::Double) {
    all.push_back({"float storage",
                   fmt::format("{:.3g} MB, and half of what the fluid moves through the memory",
                               0.5e-6 * fluid::memory_bytes(*scene.fluid)),
                   "fluid.storage=float"});
  }
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (body.motion || body.substeps.safety > 0.0 || body.substeps.count == 1) continue;
    const int least = least_substeps(scene, body);
    if (least == body.substeps.count) continue;
    all.push_back({fmt::format("{} sub-step{} of {}", least, least == 1 ? "" : "s", body.name),
                   fmt::format("{} of {} evaluations of its forces a step", body.substeps.count - least,
                               body.substeps.count),
                   fmt::format("{}={}", substeps_of(i), least)});
  }
  for (std::size_t axis = 0; scene.fluid && axis < 3; ++axis) {
    const std::int64_t nodes = scene.fluid->grid.size[axis];
    const std::int64_t fewer = nodes * 3 / 4;
    const double needed = room(scene, static_cast<int>(axis));
    if (scene.fluid->walls[axis] || needed == 0.0 || !scene.fluid->obstacle.empty() ||
        static_cast<double>(fewer) < needed + 1.0)
      continue;
    std::array<std::int64_t, 3> box = scene.fluid->grid.size;
    box[axis] = fewer;
    all.push_back({fmt::format("{} nodes along {}", fewer, "xyz"[axis]), "a quarter of the fluid",
                   fmt::format("fluid.nodes=[{}, {}, {}]", box[0], box[1], box[2])});
  }
  return all;
}

}  // namespace veriflex::scene
