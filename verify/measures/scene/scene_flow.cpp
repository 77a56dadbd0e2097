#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "engine/read_scene.hpp"
#include "fluid/initial.hpp"
#include "measures/scene/scene.hpp"

// [fluid.initial]: a flow that the fluid starts from.

namespace veriflex::measures {

namespace {

/// The steady flow between the walls of the axis that it names.
std::function<fluid::Populations(std::int64_t)> couette(const io::Table& t, const fluid::Spec& fluid) {
  const int along = engine::read_axis(t, "along");
  const auto a = static_cast<std::size_t>(along);
  const std::optional<fluid::Walls>& walls = fluid.walls[a];
  if (!walls) {
    t.fail("along", fmt::format("the box has no walls along {}", "xyz"[along]),
           "the flow is that between them", fmt::format("Add walls_{} with their velocities", "xyz"[along]));
  }
  const Grid grid = fluid.grid;
  const double tau = fluid.relaxation_time;
  const Vec3 low = walls->low_velocity;
  const Vec3 slope = (walls->high_velocity - low) / static_cast<double>(grid.size[a]);
  Mat3 gradient = Mat3::Zero();
  gradient.row(along) = slope.transpose();
  return [grid, a, low, slope, gradient, tau](std::int64_t node) {
    const double from_wall = static_cast<double>(grid.node(node)[a]) + 0.5;
    return fluid::near_equilibrium(1.0, low + from_wall * slope, gradient, tau);
  };
}

/// Two shear layers in a periodic box, a sinus across them.                         [minion-brown-1997]
///
///   u = U tanh(k (s - 1/4)) up to s = 1/2, U tanh(k (3/4 - s)) beyond; v = d |U| sin(2 pi (q + 1/4))
///
/// s and q are the parts of the way across and along the layers.
std::function<fluid::Populations(std::int64_t)> double_shear_layer(const io::Table& t, const Vec3& U,
                                                                   int across, const fluid::Spec& fluid) {
  int along = 0;
  if (U.cwiseAbs().maxCoeff(&along) == 0.0 || U.cwiseAbs().sum() != std::abs(U[along])) {
    t.fail("velocity", "the layers stream along no axis, or several", "they lie along one of the box",
           "Give one component");
  }
  const double k = t.number("steepness", 80.0);
  engine::need_positive(t, "steepness", k);
  const double d = t.number("disturbance", 0.05);
  const Grid grid = fluid.grid;
  const double tau = fluid.relaxation_time, speed = U[along];
  return [grid, along, across, speed, k, d, tau](std::int64_t node) {
    const auto part = [&](int axis) {
      const auto a = static_cast<std::size_t>(axis);
      return static_cast<double>(grid.node(node)[a]) / static_cast<double>(grid.size[a]);
    };
    const auto spacings = [&](int axis) {
      return static_cast<double>(grid.size[static_cast<std::size_t>(axis)]);
    };
    const double s = part(across), side = s <= 0.5 ? 1.0 : -1.0;
    const double layer = std::tanh(k * (s <= 0.5 ? s - 0.25 : 0.75 - s));
    const double phase = 2.0 * std::numbers::pi * (part(along) + 0.25);
    Vec3 u = Vec3::Zero();
    u[along] = speed * layer;
    u[across] = d * std::abs(speed) * std::sin(phase);
    Mat3 gradient = Mat3::Zero();
    gradient(across, along) = side * speed * k * (1.0 - layer * layer) / spacings(across);
    gradient(along, across) =
        d * std::abs(speed) * std::cos(phase) * 2.0 * std::numbers::pi / spacings(along);
    return fluid::near_equilibrium(1.0, u, gradient, tau);
  };
}

}  // namespace

std::function<fluid::Populations(std::int64_t)> read_initial_flow(const io::Table& top,
                                                                  const fluid::Spec& fluid) {
  const io::Table table = top.table("fluid");
  if (!table.has("initial")) return {};
  const io::Table t = table.table("initial");
  const std::string flow = t.choice("flow", {"uniform", "shear-wave", "couette", "double-shear-layer"});
  if (flow == "couette") return couette(t, fluid);
  const Vec3 U = engine::read_vector(t, "velocity");
  if (flow == "uniform") {
    const fluid::Populations h = fluid::equilibrium(1.0, U);
    return [h](std::int64_t) { return h; };
  }
  const int along = engine::read_axis(t, "along");
  if (U[along] != 0.0) {
    t.fail("velocity", "the flow moves along its own normal", "that is sound, not shear",
           "Set that component to 0");
  }
  if (flow == "double-shear-layer") return double_shear_layer(t, U, along, fluid);
  const std::int64_t size = fluid.grid.size[static_cast<std::size_t>(along)];
  const std::int64_t waves = t.has("waves") ? t.integer("waves", 1, 1'000'000) : 1;
  if (2 * waves > size) {
    t.fail("waves", fmt::format("{} waves on {} nodes", waves, size), "a wave has two nodes or more",
           "Ask for fewer");
  }
  const double k = 2.0 * std::numbers::pi * static_cast<double>(waves) / static_cast<double>(size);
  const Grid grid = fluid.grid;
  const double tau = fluid.relaxation_time;
  return [grid, U, along, k, tau](std::int64_t node) {
    const double phase = k * static_cast<double>(grid.node(node)[static_cast<std::size_t>(along)]);
    Mat3 gradient = Mat3::Zero();
    gradient.row(along) = k * std::cos(phase) * U.transpose();
    return fluid::near_equilibrium(1.0, U * std::sin(phase), gradient, tau);
  };
}

}  // namespace veriflex::measures
