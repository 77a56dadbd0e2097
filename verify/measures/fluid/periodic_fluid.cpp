#include "measures/fluid/periodic_fluid.hpp"

#include <fmt/format.h>

#include "fluid/initial.hpp"

namespace veriflex::measures {

namespace {

constexpr std::int64_t max_width = 4096;

}  // namespace

fluid::Spec read_periodic_fluid(const io::Table& top) {
  const fluid::Spec spec = engine::read_fluid(top, engine::Varied::Nodes);
  const io::Table table = top.table("fluid");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!spec.walls[axis]) continue;
    table.fail(fmt::format("walls_{}", "xyz"[axis]), "this driver's box has no walls",
               "its flows are periodic", "Leave the key out");
  }
  if (!spec.body_force.isZero(0.0)) {
    table.fail("body_force", "this driver's flows have no force", "they decay from where they start",
               "Leave the key out");
  }
  return spec;
}

std::int64_t read_nodes(const io::Table& table, std::int64_t min) {
  if (table.has_list("nodes")) {
    table.fail("nodes", "'nodes' is a list", "a case measures one run, and its study makes many",
               "Give one number here, and the list as an axis of [sweep]");
  }
  return table.integer("nodes", min, max_width);
}

void require_steps(const io::Table& fluid, double steps) {
  if (steps <= 1e9) return;
  fluid.fail("relaxation_time", fmt::format("a run would take {:.3g} steps", steps),
             "the flow decays by viscosity, which is next to nothing there",
             "Use a larger relaxation time or fewer nodes");
}

std::array<int, 2> read_plane(const io::Table& table) {
  const std::string plane = table.has("plane") ? table.choice("plane", {"xy", "yz", "zx"}) : "xy";
  return {plane[0] - 'x', plane[1] - 'x'};
}

Grid plane_box(std::int64_t n, const std::array<int, 2>& plane) {
  Grid grid{{1, 1, 1}};
  for (const int axis : plane) grid.size[static_cast<std::size_t>(axis)] = n;
  return grid;
}

scene::Scene starting(const fluid::Spec& fluid, const analytic::DecayingFlow& flow, Start how) {
  const Grid grid = fluid.grid;
  const double tau = fluid.relaxation_time;
  return {.fluid = fluid, .initial_flow = [=](std::int64_t node) {
            const analytic::FlowState here = flow.at(position(grid, node), 0.0);
            const double rho = 1.0 + here.pressure / fluid::sound_speed_squared;
            Vec3 u = here.velocity;
            if (how == Start::Balanced) u += flow.swelling(position(grid, node), fluid::sound_speed_squared);
            const Mat3 gradient = how == Start::Equilibrium ? Mat3(Mat3::Zero()) : here.gradient;
            return fluid::near_equilibrium(rho, u, gradient, tau);
          }};
}

}  // namespace veriflex::measures
