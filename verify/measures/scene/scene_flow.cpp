#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "engine/read_scene.hpp"
#include "fluid/initial.hpp"
#include "measures/scene/scene.hpp"

// [fluid.initial]: a flow that the fluid starts from.

namespace veriflex::measures {

std::function<fluid::Populations(std::int64_t)> read_initial_flow(const io::Table& top,
                                                                  const fluid::Spec& fluid) {
  const io::Table table = top.table("fluid");
  if (!table.has("initial")) return {};
  const io::Table t = table.table("initial");
  const std::string flow = t.choice("flow", {"uniform", "shear-wave"});
  const Vec3 U = engine::read_vector(t, "velocity");
  if (flow == "uniform") {
    const fluid::Populations h = fluid::equilibrium(1.0, U);
    return [h](std::int64_t) { return h; };
  }
  const int along = engine::read_axis(t, "along");
  if (U[along] != 0.0) {
    t.fail("velocity", "the wave moves along its own normal", "that is sound, not shear",
           "Set that component to 0");
  }
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
