#include "measures/fluid/periodic_fluid.hpp"

#include <fmt/format.h>

#include "fluid/initial.hpp"

namespace veriflex::measures {

fluid::Spec read_periodic_fluid(const io::Table& top, engine::Varied varied) {
  const fluid::Spec spec = engine::read_fluid(top, varied);
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

std::vector<std::int64_t> read_resolutions(const io::Table& table, std::size_t rows, std::int64_t min) {
  const std::vector<std::int64_t> nodes = table.integers("nodes");
  if (nodes.size() < rows) {
    table.fail("nodes", fmt::format("{} resolutions", nodes.size()),
               fmt::format("{} are the least from which this driver concludes anything", rows),
               "Give for example [16, 32, 64]");
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i] < min || nodes[i] > 4096) {
      table.fail("nodes", fmt::format("'nodes' holds {}", nodes[i]),
                 fmt::format("a side has {} to 4096 nodes here", min), "Choose numbers in that range");
    }
    if (i > 0 && nodes[i] <= nodes[i - 1])
      table.fail("nodes", "they do not rise", "the order is taken between neighbours", "Sort them");
  }
  return nodes;
}

void require_steps(const io::Table& fluid, double steps) {
  if (steps <= 1e9) return;
  fluid.fail("relaxation_time", fmt::format("a run would take {:.3g} steps", steps),
             "the flow decays by viscosity, which is next to nothing there",
             "Use a larger relaxation time or fewer nodes");
}

std::array<int, 2> axes_of(const std::string& plane) { return {plane[0] - 'x', plane[1] - 'x'}; }

Grid plane_box(std::int64_t n, const std::array<int, 2>& plane) {
  Grid grid{{1, 1, 1}};
  for (const int axis : plane) grid.size[static_cast<std::size_t>(axis)] = n;
  return grid;
}

void start(fluid::Fluid& fluid, const analytic::DecayingFlow& flow, Start how) {
  const Grid& grid = fluid.spec().grid;
  const double tau = fluid.spec().relaxation_time;
  fluid.start([&](std::int64_t node) {
    const analytic::FlowState here = flow.at(position(grid, node), 0.0);
    const double rho = 1.0 + here.pressure / fluid::sound_speed_squared;
    Vec3 u = here.velocity;
    if (how == Start::Balanced) u += flow.swelling(position(grid, node), fluid::sound_speed_squared);
    const Mat3 gradient = how == Start::Equilibrium ? Mat3(Mat3::Zero()) : here.gradient;
    return fluid::near_equilibrium(rho, u, gradient, tau);
  });
}

}  // namespace veriflex::measures
