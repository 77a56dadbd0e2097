#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "analytic/channel.hpp"
#include "engine/check_place.hpp"
#include "measures/fluid/channel.hpp"
#include "observe/field.hpp"

// An oscillating uniform force enters as a force on every node, of first order: g(t) is added after the
// collision of step t, and the velocity at time t is sum f c + g(t)/2, half of it before and half after.

namespace veriflex::measures::channel {

namespace {

using observe::Observations;

constexpr int phases = 8;  // shown, of a period
constexpr int shown = 4;   // the other half is the same with the sign changed

struct Womersley {
  Common common;         // velocity: that the force alone would reach, g/omega
  std::int64_t period;   // [T]
  std::int64_t periods;  // until it is periodic; the last one is measured

  double viscosity() const { return fluid::viscosity(common.fluid.relaxation_time); }
  double height() const { return static_cast<double>(common.nodes); }
  double omega() const { return 2.0 * std::numbers::pi / static_cast<double>(period); }
  double angle(std::int64_t step) const { return omega() * static_cast<double>(step % period); }
  double force(std::int64_t step) const { return common.velocity * omega() * std::cos(angle(step)); }
};

scene::Scene scene_of(const Womersley& study) {
  return {.fluid = gap(study.common), .uniform_force = [study](std::int64_t step) {
            Vec3 g = Vec3::Zero();
            g[static_cast<Eigen::Index>(along(study.common.axis))] = study.force(step);
            return g;
          }};
}

/// Over g/omega, across the gap at a step of the last period.
struct Velocities {
  std::vector<double> measured, exact;
};

Velocities velocities_at(const Womersley& study, const scene::Simulation& now,
                         std::span<const std::int64_t> across) {
  Velocities u{component(velocities_of(now.fluid(), across), along(study.common.axis)), {}};
  const double g = study.force(now.steps());
  for (double& value : u.measured) value = (value + 0.5 * g) / study.common.velocity;
  for (std::int64_t j = 0; j < study.common.nodes; ++j) {
    const std::complex<double> amplitude =
        study.omega() *
        analytic::oscillating_poiseuille(from_wall(j), study.height(), study.omega(), study.viscosity());
    u.exact.push_back((amplitude * std::polar(1.0, study.angle(now.steps()))).real());
  }
  return u;
}

void run_womersley(const Womersley& study, Observations& seen, Progress& progress) {
  observe::Record& profile = seen.open("profile");
  for (std::int64_t j = 0; j < study.common.nodes; ++j)
    profile.columns.front().values.push_back(from_wall(j) / study.height());
  scene::Simulation simulation(scene_of(study));
  const std::vector<std::int64_t> across =
      observe::line(simulation.fluid().spec().grid, study.common.axis, {0, 0, 0});
  const std::int64_t last = study.periods * study.period;
  NormSums errors;
  observe::Run run(simulation, study.common.monitor, {}, "", progress);
  run.advance(last - study.period, last);
  for (std::int64_t step = 0; step < study.period; ++step) {
    const Velocities u = velocities_at(study, simulation, across);
    for (std::size_t j = 0; j < u.exact.size(); ++j) errors.add(u.measured[j] - u.exact[j], u.exact[j]);
    const std::int64_t eighth = step * phases / study.period;
    if (step % (study.period / phases) == 0 && eighth < shown) {
      profile.columns[static_cast<std::size_t>(1 + 2 * eighth)].values = u.measured;
      profile.columns[static_cast<std::size_t>(2 + 2 * eighth)].values = u.exact;
    }
    run.advance(1, last);
  }
  run.finish();
  set_norms(seen, "", errors.relative());
  seen.set("womersley_number", 0.5 * study.height() * std::sqrt(study.omega() / study.viscosity()));
}

Observations womersley_observations() {
  Observations all;
  all.metrics = norm_metrics("", "the velocity over the last period");
  all.metrics.push_back({"womersley_number", {}, "1", "half the gap over the thickness sqrt(nu/omega)"});
  observe::Record profile{"profile",
                          "Velocity across the gap, in eighths of a period",
                          {{"position", "y/H", "1", "from wall to wall", {}}}};
  for (int k = 0; k < shown; ++k) {
    const std::string name = fmt::format("phase_{}", k);
    profile.columns.push_back(
        {name, "", "1", "over g/omega, so many eighths of a period after the largest force", {}});
    profile.columns.push_back({name + "_exact", "", "1", "exact", {}});
  }
  all.records = {profile};
  return all;
}

}  // namespace

engine::Study read_womersley(const io::Table& top) {
  const io::Table t = top.table("channel");
  const Womersley study{.common = read_common(top, "y"),
                        .period = t.integer("period", phases, 1'000'000'000),
                        .periods = t.integer("periods", 1, 10000)};
  if (study.period % phases != 0) {
    t.fail("period", fmt::format("'period' is {}", study.period), "eighths of it are shown",
           "Use a multiple of 8");
  }
  const double steps = static_cast<double>(study.periods) * static_cast<double>(study.period);
  if (steps > engine::max_steps) {
    t.fail("period", fmt::format("the run would take {:.3g} steps", steps),
           fmt::format("{:.1g} is the most", engine::max_steps), "Use a shorter period or fewer of them");
  }
  return study_of(top, {.fluid = gap(study.common), .uniform_force = true}, womersley_observations(), study,
                  run_womersley, study.periods * study.period);
}

}  // namespace veriflex::measures::channel
