#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "measures/drivers.hpp"
#include "measures/fluid/norms.hpp"
#include "measures/fluid/periodic_fluid.hpp"
#include "measures/fluid/steady.hpp"

namespace veriflex::measures {

namespace {

using analytic::DecayingFlow;
using analytic::Pattern;
using observe::Observations;

constexpr double max_decays = 100.0;
constexpr double min_velocity = 1e-30;  // its square and that of its rounding are still numbers in float

struct Vortex {
  fluid::Spec fluid;
  DecayingFlow flow;
  std::int64_t steps;  // of the run
  Start start;
  bool other_storage;  // whether a second run stores populations in the other storage
  observe::MonitorSpec monitor;
};

// How far a fluid is from the exact flow.
struct Distance {
  NormSums velocity;
  double pressure;  // L2, relative
};

Distance distance(const fluid::Fluid& fluid, const DecayingFlow& flow) {
  const Grid& grid = fluid.spec().grid;
  std::vector<fluid::Populations> h;
  const auto take = [&](std::span<const std::int64_t> nodes) {
    h.resize(nodes.size());
    fluid.populations(nodes, h);
  };
  double mean = 0.0;
  in_parts(grid, [&](std::span<const std::int64_t> nodes) {
    take(nodes);
    for (const fluid::Populations& here : h) mean += fluid::density_deviation(here);
  });
  mean /= static_cast<double>(grid.count());

  Distance found{};
  double pressure_error = 0.0, pressure = 0.0;
  in_parts(grid, [&](std::span<const std::int64_t> nodes) {
    take(nodes);
    const Positions velocity = velocities_of(fluid, nodes);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const analytic::FlowState here = flow.at(position(grid, nodes[i]), static_cast<double>(fluid.steps()));
      found.velocity.add((Vec3(velocity.row(static_cast<Eigen::Index>(i))) - here.velocity).norm(),
                         here.velocity.norm());
      const double p = fluid::sound_speed_squared * (fluid::density_deviation(h[i]) - mean);
      pressure_error += (p - here.pressure) * (p - here.pressure);
      pressure += here.pressure * here.pressure;
    }
  });
  found.pressure = std::sqrt(pressure_error / pressure);
  return found;
}

// |u - u'| of two fluids, L2  [L T^-1].
double difference(const fluid::Fluid& a, const fluid::Fluid& b) {
  double sum = 0.0;
  in_parts(a.spec().grid, [&](std::span<const std::int64_t> nodes) {
    sum += (velocities_of(a, nodes) - velocities_of(b, nodes)).squaredNorm();
  });
  return std::sqrt(sum);
}

fluid::Storage other_of(fluid::Storage storage) {
  return storage == fluid::Storage::Double ? fluid::Storage::Float : fluid::Storage::Double;
}

Observations vortex_observations(const Vortex& study) {
  Observations all;
  all.metrics = norm_metrics("velocity_", "the velocity at the end");
  if (study.flow.pattern == Pattern::TaylorGreen)
    all.metrics.push_back({"error_pressure_l2", {}, "1", "of the pressure at the end, L2, relative"});
  all.metrics.push_back({"steps", {}, "1", "until the end"});
  if (study.other_storage) {
    all.metrics.push_back(
        {"storage_difference", {}, "1", "populations in float against double, velocity, L2, relative"});
    all.metrics.push_back({"storage_share", {}, "1", "that over the error in double"});
  }
  return all;
}

void run_vortex(const Vortex& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  const auto simulate = [&](const fluid::Spec& fluid) {
    return run_steps(starting(fluid, study.flow, study.start), study.steps, study.monitor, progress);
  };
  const scene::Simulation end = simulate(study.fluid);
  cost.finish("run");
  const Distance error = distance(end.fluid(), study.flow);
  set_norms(seen, "velocity_", error.velocity.relative());
  if (study.flow.pattern == Pattern::TaylorGreen) seen.set("error_pressure_l2", error.pressure);
  seen.set("steps", static_cast<double>(study.steps));
  cost.finish("errors");
  if (!study.other_storage) return;

  const bool is_double = study.fluid.storage == fluid::Storage::Double;
  fluid::Spec other = study.fluid;
  other.storage = other_of(other.storage);
  const scene::Simulation twin = simulate(other);
  const double exact = error.velocity.exact_l2();
  const double rounding = difference(end.fluid(), twin.fluid()) / exact;
  const NormSums in_double = is_double ? error.velocity : distance(twin.fluid(), study.flow).velocity;
  seen.set("storage_difference", rounding);
  seen.set("storage_share", rounding / in_double.relative().l2);
  cost.finish("other storage");
}

std::vector<scene::ExpectedWork> expected_work(const Vortex& study) {
  std::vector<scene::ExpectedWork> runs{*scene::expected_work({.fluid = study.fluid}, study.steps)};
  if (study.other_storage) {
    fluid::Spec other = study.fluid;
    other.storage = other_of(other.storage);
    runs.push_back(*scene::expected_work({.fluid = other}, study.steps));
  }
  return runs;
}

Start read_start(const io::Table& t) {
  if (!t.has("start")) return Start::Balanced;
  const std::string start = t.choice("start", {"balanced", "without-swelling", "equilibrium"});
  if (start == "balanced") return Start::Balanced;
  return start == "without-swelling" ? Start::WithoutSwelling : Start::Equilibrium;
}

double read_positive(const io::Table& t, const std::string& key) {
  return engine::need_positive(t, key, t.number(key), "Use for example 1.0");
}

}  // namespace

engine::Study read_vortex(const io::Table& top) {
  const io::Table t = top.table("vortex");
  Vortex study{.fluid = read_periodic_fluid(top),
               .flow = {},
               .steps = 0,
               .start = read_start(t),
               .other_storage = t.flag("other_storage", false),
               .monitor = engine::read_monitor(top)};
  const std::array<int, 2> plane = read_plane(t);
  const std::int64_t nodes = read_nodes(t, 4);
  const double reynolds = read_positive(t, "reynolds"), decays = read_positive(t, "decays");
  if (decays > max_decays) {
    t.fail("decays", fmt::format("'decays' is {}", decays),
           fmt::format("after {} e-foldings nothing is left of the flow but rounding", max_decays),
           "Use for example 1.0");
  }
  study.fluid.grid = plane_box(nodes, plane);
  const double nu = fluid::viscosity(study.fluid.relaxation_time);
  study.flow = {.pattern = t.choice("flow", {"taylor-green", "shear"}) == "shear" ? Pattern::Shear
                                                                                  : Pattern::TaylorGreen,
                .a = plane[0],
                .b = plane[1],
                .wavenumber = wavenumber(nodes),
                .amplitude = reynolds * nu / static_cast<double>(nodes),
                .viscosity = nu};
  if (study.flow.amplitude < min_velocity) {
    t.fail("reynolds", fmt::format("the flow would start with a velocity of {:.3g}", study.flow.amplitude),
           fmt::format("below {} its square is lost to underflow", min_velocity), "Use for example 1.0");
  }
  const double mach = study.flow.amplitude / std::sqrt(fluid::sound_speed_squared);
  if (mach > study.monitor.mach_limit) {
    t.fail(
        "reynolds", fmt::format("the flow would start at Mach number {:.3g}", mach),
        fmt::format("the monitor's limit is {}: the flow is to be incompressible", study.monitor.mach_limit),
        "Use a smaller Reynolds number, more nodes or a smaller relaxation time");
  }
  require_steps(top.table("fluid"), decays / study.flow.decay_rate());
  study.steps = std::max<std::int64_t>(1, std::llround(decays / study.flow.decay_rate()));
  return {.plan = engine::read_plan(top, {.fluid = study.fluid, .initial_flow = true}),
          .declares = vortex_observations(study),
          .run = std::bind_front(run_vortex, study),
          .expects = [study] { return expected_work(study); }};
}

}  // namespace veriflex::measures
