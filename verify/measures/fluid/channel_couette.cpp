#include <fmt/format.h>

#include <cmath>

#include "measures/fluid/channel.hpp"
#include "observe/field.hpp"

// Between a plate at rest and a sliding one the velocity is linear, and half-way bounce-back has no slip for
// that: the lattice's own solution is the continuum's.

namespace veriflex::measures::channel {

namespace {

using observe::Observations;
using observe::Record;

struct Couette {
  Common common;  // velocity: of the high wall along the next axis; half of it along the other
  Steady steady;
};

Vec3 wall_velocity(const Couette& study) {
  Vec3 u = Vec3::Zero();
  const std::size_t next = along(study.common.axis);
  u[static_cast<Eigen::Index>(next)] = study.common.velocity;
  u[static_cast<Eigen::Index>(along(next))] = 0.5 * study.common.velocity;
  return u;
}

constexpr const char* velocity_names[] = {"velocity_x", "velocity_y", "velocity_z"};
constexpr const char* stress_names[3][3] = {{"stress_xx", "stress_xy", "stress_xz"},
                                            {"stress_xy", "stress_yy", "stress_yz"},
                                            {"stress_xz", "stress_yz", "stress_zz"}};

fluid::Spec spec_of(const Couette& study) {
  fluid::Spec spec = gap(study.common);
  spec.walls[study.common.axis]->high_velocity = wall_velocity(study);
  return spec;
}

Record steady_state(const Couette& study, Progress& progress) {
  const fluid::Spec spec = spec_of(study);
  const std::vector<std::int64_t> nodes = observe::line(spec.grid, study.common.axis, {0, 0, 0});
  const scene::Simulation end = run_to_steady(spec, nodes, study.steady, study.common.monitor, progress);
  return observe::at_nodes(end.fluid(), nodes, {.density = true, .velocity = true, .stress = true}, "state",
                           "");
}

void run_couette(const Couette& study, Observations& seen, Progress& progress) {
  const Record state = steady_state(study, progress);
  const std::size_t normal = study.common.axis;
  const Vec3 wall = wall_velocity(study);
  const double top = study.common.velocity;
  const auto height = static_cast<double>(study.common.nodes);
  const double nu = fluid::viscosity(study.common.fluid.relaxation_time);
  double velocity = 0.0, stress = 0.0, density = 0.0;
  for (std::size_t j = 0; j < static_cast<std::size_t>(study.common.nodes); ++j) {
    const double share = from_wall(static_cast<std::int64_t>(j)) / height;
    density = worse(density, std::abs(state.find("density")->values[j] - 1.0));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double of_wall = wall[static_cast<Eigen::Index>(axis)];
      const double u = state.find(velocity_names[axis])->values[j];
      velocity = worse(velocity, std::abs(u - share * of_wall) / top);
      const double shear = state.find(stress_names[normal][axis])->values[j];
      stress = worse(stress, std::abs(shear / (nu * top / height) - of_wall / top));
    }
    seen.open("profile").append({share, state.find(velocity_names[along(normal)])->values[j] / top, share});
  }
  seen.set("velocity_error", velocity);
  seen.set("stress_error", stress);
  seen.set("density_error", density);
}

Observations couette_observations() {
  Observations all;
  all.metrics = {{"velocity_error", {}, "1", "largest departure from the line, over the wall's velocity"},
                 {"stress_error", {}, "1", "largest departure from nu U/H, over it"},
                 {"density_error", {}, "1", "largest departure from 1"}};
  all.records = {{"profile",
                  "Velocity between the walls",
                  {{"position", "y/H", "1", "from wall to wall", {}},
                   {"velocity", "", "1", "over that of the wall", {}},
                   {"velocity_exact", "", "1", "a straight line", {}}}}};
  return all;
}

}  // namespace

engine::Study read_couette(const io::Table& top) {
  const Common common = read_common(top, "y");
  const Couette study{
      .common = common,
      .steady = read_steady(top.table("channel"), 1e-15, common.fluid, static_cast<double>(common.nodes),
                            fmt::format("a gap of {} nodes", common.nodes))};
  return study_of(
      top, {.fluid = spec_of(study)}, couette_observations(), study, run_couette,
      steps_to_steady(study.steady, slowest_rate(common.fluid, static_cast<double>(common.nodes))));
}

}  // namespace veriflex::measures::channel
