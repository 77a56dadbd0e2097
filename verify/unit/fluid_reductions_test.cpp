// Sums and extremes over a box are those of its nodes, asked one by one.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "base/reduce.hpp"
#include "catch.hpp"
#include "fluid/fluid.hpp"

using namespace veriflex;
using namespace veriflex::fluid;

namespace {

// Walls along the axes whose bit is set, an obstacle of two nodes, and a flow that differs from node to node.
std::unique_ptr<Fluid> uneven(std::int64_t nx, double tau, Storage storage, unsigned walls, bool obstacle) {
  Spec spec{.grid = {{nx, 5, 6}}, .relaxation_time = tau, .storage = storage};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if ((walls >> axis & 1U) != 0) spec.walls[axis] = Walls{};
  }
  if (obstacle) spec.obstacle = {2 * nx, 2 * nx + 5 * nx};
  std::unique_ptr<Fluid> fluid = make_fluid(spec);
  fluid->start([](std::int64_t node) {
    std::mt19937 random(static_cast<unsigned>(node));
    std::uniform_real_distribution<double> uniform(-0.01, 0.01);
    Populations h;
    for (double& each : h) each = uniform(random);
    return h;
  });
  return fluid;
}

void check_against_single_nodes(const Fluid& fluid) {
  const Grid& grid = fluid.spec().grid;
  std::vector<std::int64_t> nodes(static_cast<std::size_t>(grid.count()));
  std::iota(nodes.begin(), nodes.end(), std::int64_t{0});
  std::vector<Populations> h(nodes.size());
  fluid.populations(nodes, h);
  Positions u;
  fluid.velocities(nodes, u);
  double mass = 0.0, min_density = INFINITY, max_speed = 0.0;
  Vec3 sum = Vec3::Zero(), staggered = Vec3::Zero();
  for (std::size_t node = 0; node < nodes.size(); ++node) {
    const auto [x, y, z] = grid.node(nodes[node]);
    const double sign = (x + y + z + fluid.steps()) % 2 == 0 ? 1.0 : -1.0;
    mass += density_deviation(h[node]);
    sum += momentum(h[node]);
    staggered += sign * momentum(h[node]);
    const auto& obstacle = fluid.spec().obstacle;
    if (std::find(obstacle.begin(), obstacle.end(), nodes[node]) != obstacle.end()) continue;
    min_density = lesser(min_density, 1.0 + density_deviation(h[node]));
    max_speed = worse(max_speed, u.row(static_cast<Eigen::Index>(node)).norm());
  }
  const bool is_float = fluid.spec().storage == Storage::Float;
  const double round_off = is_float ? 1e-5 : 1e-13;
  const Totals totals = fluid.totals();
  CHECK(std::abs(totals.mass_deviation - mass) < round_off);
  CHECK((totals.momentum - sum).norm() < round_off);
  CHECK((totals.staggered_momentum - staggered).norm() < round_off);
  const Extremes worst = fluid.extremes();
  CHECK(worst.min_density == Approx(min_density).epsilon(is_float ? 1e-6 : 1e-14));
  CHECK(worst.max_speed == Approx(max_speed).epsilon(is_float ? 1e-5 : 1e-13));
  CHECK(u.row(worst.max_speed_node).norm() == Approx(max_speed).epsilon(is_float ? 1e-5 : 1e-13));
}

}  // namespace

TEST_CASE("Sums and extremes over a box are those of its nodes, for any width, walls, storage and parity") {
  for (const double tau : {0.7, 1.0}) {
    for (const Storage storage : {Storage::Double, Storage::Float}) {
      for (const std::int64_t nx : {1, 2, 3, 4, 8, 16, 24}) {
        for (unsigned walls = 0; walls < 8; ++walls) {
          for (const bool obstacle : {false, true}) {
            CAPTURE(tau, storage, nx, walls, obstacle);
            const std::unique_ptr<Fluid> fluid = uneven(nx, tau, storage, walls, obstacle);
            for (int step = 0; step < 3; ++step) {
              check_against_single_nodes(*fluid);
              fluid->collide_and_stream();
            }
          }
        }
      }
    }
  }
}
