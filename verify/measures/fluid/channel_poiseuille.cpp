#include <fmt/format.h>

#include <cmath>

#include "analytic/channel.hpp"
#include "engine/check_place.hpp"
#include "measures/fluid/channel.hpp"
#include "observe/field.hpp"

// Between plates nothing but the velocity along them varies, and the lattice's own steady state is known: the
// parabola with a slip of g (16 (tau - 1/2)^2 - 3)/(24 nu), in the velocity sum f c + g/2. The bare velocity
// sum f c is what both force schemes have in common, before the collision; it lags by the half step g/2.

namespace veriflex::measures::channel {

namespace {

using observe::Observations;

struct Poiseuille {
  Common common;  // velocity: of the parabola's top
  Steady steady;
  double viscous_times;  // of the run, in H^2/nu; 0 runs until it is steady

  double viscosity() const { return fluid::viscosity(common.fluid.relaxation_time); }
  double height() const { return static_cast<double>(common.nodes); }
  double force() const { return 8.0 * viscosity() * common.velocity / (height() * height()); }
  double steps() const { return std::ceil(viscous_times * height() * height() / viscosity()); }
};

fluid::Spec spec_of(const Poiseuille& study) {
  fluid::Spec spec = gap(study.common);
  spec.body_force[static_cast<Eigen::Index>(along(study.common.axis))] = study.force();
  return spec;
}

/// sum f c across the gap at the end.
std::vector<double> bare_profile(const Poiseuille& study, Progress& progress) {
  const fluid::Spec spec = spec_of(study);
  const std::vector<std::int64_t> nodes = observe::line(spec.grid, study.common.axis, {0, 0, 0});
  const scene::Simulation end =
      study.viscous_times > 0.0 ? run_steps({.fluid = spec}, static_cast<std::int64_t>(study.steps()),
                                            study.common.monitor, progress)
                                : run_to_steady(spec, nodes, study.steady, study.common.monitor, progress);
  return component(velocities_of(end.fluid(), nodes), along(study.common.axis));
}

std::vector<double> plus(std::vector<double> values, double offset) {
  for (double& value : values) value += offset;
  return values;
}

std::vector<double> parabola(const Poiseuille& study) {
  std::vector<double> u;
  for (std::int64_t j = 0; j < study.common.nodes; ++j) {
    u.push_back(study.force() / study.viscosity() * analytic::plane_poiseuille(from_wall(j), study.height()));
  }
  return u;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = worse(worst, std::abs(a[i] - b[i]));
  return worst;
}

/// Mean over the gap of velocity - parabola.
double slip(const std::vector<double>& velocity, const std::vector<double>& exact) {
  double sum = 0.0;
  for (std::size_t i = 0; i < exact.size(); ++i) sum += velocity[i] - exact[i];
  return sum / static_cast<double>(exact.size());
}

void run_poiseuille(const Poiseuille& study, Observations& seen, Progress& progress) {
  const std::vector<double> bare = bare_profile(study, progress);
  const double g = study.force(), top = study.common.velocity;
  const std::vector<double> velocity = plus(bare, 0.5 * g), exact = parabola(study);
  const double exact_slip = analytic::half_way_slip(study.common.fluid.relaxation_time);
  for (std::size_t j = 0; j < exact.size(); ++j) {
    seen.open("profile").append({from_wall(static_cast<std::int64_t>(j)) / study.height(), velocity[j] / top,
                                 exact[j] / top, bare[j] / top, exact[j] / top});
  }
  set_norms(seen, "", error_norms(velocity, exact));
  set_norms(seen, "bare_", error_norms(bare, exact));
  seen.set("error_lattice", largest_difference(velocity, plus(exact, exact_slip * g)) / top);
  seen.set("slip", slip(velocity, exact) / g);
  seen.set("slip_exact", exact_slip);
  seen.set("slip_bare", slip(bare, exact) / g);
}

Observations poiseuille_observations() {
  Observations all;
  all.metrics = norm_metrics("", "sum f c + g/2");
  for (const observe::Metric& metric : norm_metrics("bare_", "sum f c")) all.metrics.push_back(metric);
  all.metrics.insert(
      all.metrics.end(),
      {{"error_lattice", {}, "1", "largest, sum f c + g/2 against the lattice's own solution, over the top"},
       {"slip", {}, "T", "slip over g in sum f c + g/2"},
       {"slip_exact", {}, "T", "(16 (tau - 1/2)^2 - 3)/(24 nu)"},
       {"slip_bare", {}, "T", "slip over g in sum f c"}});
  all.records = {{"profile",
                  "Velocity across the gap",
                  {{"position", "y/H", "1", "from wall to wall", {}},
                   {"velocity", "", "1", "sum f c + g/2, over the parabola's top", {}},
                   {"velocity_exact", "", "1", "the parabola", {}},
                   {"bare", "", "1", "sum f c, over the parabola's top", {}},
                   {"bare_exact", "", "1", "the parabola", {}}}}};
  return all;
}

}  // namespace

engine::Study read_poiseuille(const io::Table& top) {
  const io::Table t = top.table("channel");
  const Common common = read_common(top, "y");
  Poiseuille study{.common = common, .steady = {}, .viscous_times = t.number("viscous_times", 0.0)};
  if (!t.has("viscous_times")) {
    const auto height = static_cast<double>(common.nodes);
    study.steady =
        read_steady(t, 1e-15, common.fluid, height, fmt::format("a gap of {} nodes", common.nodes));
  } else if (!(study.viscous_times > 0.0) || study.steps() > engine::max_steps) {
    t.fail("viscous_times", fmt::format("a run would take {:.3g} steps", study.steps()),
           fmt::format("it takes between 1 and {:.1g}", engine::max_steps),
           "After 2.5 the slowest mode has fallen to 2e-11; use fewer nodes or a larger relaxation time");
  }
  const std::int64_t steps =
      study.viscous_times > 0.0
          ? static_cast<std::int64_t>(study.steps())
          : steps_to_steady(study.steady, slowest_rate(common.fluid, static_cast<double>(common.nodes)));
  return study_of(top, {.fluid = spec_of(study)}, poiseuille_observations(), study, run_poiseuille, steps);
}

}  // namespace veriflex::measures::channel
