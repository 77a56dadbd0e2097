#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <random>

#include "base/reduce.hpp"
#include "measures/drivers.hpp"
#include "measures/fluid/steady.hpp"

// A disordered but smooth start, and what must not change of it: mass, momentum beyond what the force gave,
// and the staggered momentum, which D3Q15 conserves too because every moving population flips the parity of x
// + y + z.

namespace veriflex::measures {

namespace {

using fluid::Totals;
using observe::Observations;

struct Conservation {
  fluid::Spec fluid;
  std::int64_t steps;
  double velocity;   // of each wave of the start; its density waves are as strong  [L T^-1]
  double staggered;  // checkerboard velocity of the start  [L T^-1]
  observe::MonitorSpec monitor;
};

/// Walls and obstacles take up momentum: there only the mass stays.
bool is_periodic(const fluid::Spec& fluid) {
  return fluid.obstacle.empty() && !fluid.walls[0] && !fluid.walls[1] && !fluid.walls[2];
}

constexpr int looks = 20;
constexpr int waves = 8;

struct Wave {
  std::array<double, 3> k;  // radians per node
  double phase;
  Vec3 velocity;   // of unit size
  double density;  // -1 to 1
};

/// Waves of one or two lengths along each axis, from a generator whose numbers are the same everywhere.
std::vector<Wave> disorder(const Grid& grid) {
  std::mt19937 random(1);
  const auto number = [&random] { return 2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0; };
  std::vector<Wave> all;
  for (int i = 0; i < waves; ++i) {
    Wave wave{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      wave.k[axis] =
          2.0 * std::numbers::pi * std::round(2.0 * number()) / static_cast<double>(grid.size[axis]);
    }
    wave.phase = std::numbers::pi * number();
    for (int axis = 0; axis < 3; ++axis) wave.velocity[axis] = number();
    wave.velocity.normalize();
    wave.density = number();
    all.push_back(wave);
  }
  return all;
}

scene::Scene starting(const Conservation& study) {
  const Grid grid = study.fluid.grid;
  return {.fluid = study.fluid, .initial_flow = [study, grid, all = disorder(grid)](std::int64_t node) {
            const auto [x, y, z] = grid.node(node);
            double rho = 1.0;
            Vec3 u = Vec3::Zero();
            for (const Wave& wave : all) {
              const double angle = wave.k[0] * static_cast<double>(x) + wave.k[1] * static_cast<double>(y) +
                                   wave.k[2] * static_cast<double>(z) + wave.phase;
              rho += study.velocity * wave.density * std::cos(angle);
              u += study.velocity * wave.velocity * std::cos(angle);
            }
            u[0] += (x + y + z) % 2 == 0 ? study.staggered : -study.staggered;
            return fluid::equilibrium(rho, u);
          }};
}

/// What is kept, how far it has moved since the start, per node.
struct Kept {
  const char* name;
  const char* dimension;
  const char* meaning;
  double (*drift)(const Totals& before, const Totals& now, const Vec3& given);
};

std::vector<Kept> kept(const fluid::Spec& fluid) {
  std::vector<Kept> all{{"mass", "M L^-3", "departure of the mass from that at the start, per node",
                         [](const Totals& before, const Totals& now, const Vec3&) {
                           return std::abs(now.mass_deviation - before.mass_deviation);
                         }}};
  if (!is_periodic(fluid)) return all;
  all.push_back({"momentum", "M L^-2 T^-1",
                 "departure of the momentum from that at the start plus n g V, per node",
                 [](const Totals& before, const Totals& now, const Vec3& given) {
                   return (now.momentum - before.momentum - given).norm();
                 }});
  all.push_back({"staggered_momentum", "M L^-2 T^-1", "departure of the staggered momentum, per node",
                 [](const Totals& before, const Totals& now, const Vec3&) {
                   return (now.staggered_momentum - before.staggered_momentum).norm();
                 }});
  return all;
}

Observations conservation_observations(const fluid::Spec& fluid) {
  Observations all;
  all.records = {{"drift", "What should not change, against time", {{"step", "t", "T", "", {}}}}};
  for (const Kept& one : kept(fluid)) {
    all.records[0].columns.push_back({one.name, "", one.dimension, one.meaning, {}});
    all.metrics.push_back({one.name, {}, one.dimension, std::string("largest ") + one.meaning});
  }
  return all;
}

void run_conservation(const Conservation& study, Observations& seen, Progress& progress) {
  scene::Simulation simulation(starting(study));
  const Totals before = simulation.fluid().totals();
  const auto volume = static_cast<double>(study.fluid.grid.count());
  const std::vector<Kept> all = kept(study.fluid);
  std::vector<double> largest(all.size(), 0.0);
  observe::Run run(simulation, study.monitor, {}, "", progress);
  for (int i = 1; i <= looks; ++i) {
    run.advance(study.steps * i / looks - simulation.steps(), study.steps);
    const Totals now = simulation.fluid().totals();
    const Vec3 given = static_cast<double>(simulation.steps()) * volume * study.fluid.body_force;
    std::vector<double> row{static_cast<double>(simulation.steps())};
    for (std::size_t k = 0; k < all.size(); ++k) {
      row.push_back(all[k].drift(before, now, given) / volume);
      largest[k] = worse(largest[k], row.back());
    }
    seen.open("drift").append(row);
  }
  run.finish();
  for (std::size_t k = 0; k < all.size(); ++k) seen.set(all[k].name, largest[k]);
}

}  // namespace

engine::Study read_conservation(const io::Table& top) {
  const io::Table table = top.table("fluid");
  const io::Table t = top.table("conservation");
  Conservation study{.fluid = engine::read_fluid(top),
                     .steps = t.integer("steps", looks, 1'000'000'000),
                     .velocity = t.number("velocity"),
                     .staggered = 0.0,
                     .monitor = engine::read_monitor(top)};
  if (is_periodic(study.fluid)) {
    study.staggered = t.number("staggered_velocity", 0.0);
    for (const std::int64_t n : study.fluid.grid.size) {
      if (n % 2 != 0) {
        table.fail("nodes", "an odd number of nodes along a periodic axis",
                   "a checkerboard does not fit, and the staggered momentum is not conserved",
                   "Use even numbers");
      }
    }
  }
  return study_of(top, {.fluid = study.fluid, .initial_flow = true}, conservation_observations(study.fluid),
                  study, run_conservation);
}

}  // namespace veriflex::measures
