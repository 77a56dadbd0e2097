#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "analytic/stream_growth.hpp"
#include "measures/drivers.hpp"
#include "measures/fluid/periodic_fluid.hpp"
#include "measures/fluid/steady.hpp"

// How fast noise on a uniform stream grows: by the eigenvalues of the scheme's own waves, and in a run.

namespace veriflex::measures {

namespace {

using observe::Observations;

constexpr double most_waves = 1e6;
constexpr double no_longer_small = 1e-3;  // deviation of a population, of 1/9 or so

struct StreamStudy {
  fluid::Spec fluid;
  Vec3 stream;         // [L T^-1]
  std::int64_t steps;  // of the run; 0: none
  double noise;        // on each population, uniform in +- this
};

// The same number for a node and a population whatever the order of calls, uniform in +- 1 (splitmix64).
double noise_at(std::int64_t node, std::size_t q) {
  auto x = (static_cast<std::uint64_t>(node) * fluid::Q + q + 1) * 0x9E3779B97F4A7C15U;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9U;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBU;
  return static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1p-52 - 1.0;
}

// Root mean square deviation of the populations from the undisturbed stream.
double deviation_of(const fluid::Fluid& fluid, const fluid::Populations& undisturbed) {
  double squares = 0.0;
  in_parts(fluid.spec().grid, [&](std::span<const std::int64_t> nodes) {
    std::vector<fluid::Populations> h(nodes.size());
    fluid.populations(nodes, h);
    for (const fluid::Populations& at_node : h) {
      for (std::size_t q = 0; q < fluid::Q; ++q) {
        squares += (at_node[q] - undisturbed[q]) * (at_node[q] - undisturbed[q]);
      }
    }
  });
  return std::sqrt(squares / static_cast<double>(fluid.spec().grid.count() * fluid::Q));
}

/// The mean factor per step over the second half of the run, or of what there is of it while small.
double measured_growth(const StreamStudy& study, Progress& progress) {
  const fluid::Populations undisturbed = fluid::equilibrium(1.0, study.stream);
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(study.fluid);
  fluid->start([&](std::int64_t node) {
    fluid::Populations h = undisturbed;
    for (std::size_t q = 0; q < fluid::Q; ++q) h[q] += study.noise * noise_at(node, q);
    return h;
  });
  std::vector<double> logarithms;
  while (fluid->steps() < study.steps) {
    fluid->collide_and_stream();
    progress.show("steps", static_cast<std::size_t>(fluid->steps()), static_cast<std::size_t>(study.steps));
    const double deviation = deviation_of(*fluid, undisturbed);
    if (!(deviation < no_longer_small)) break;
    logarithms.push_back(std::log(deviation));
  }
  if (logarithms.size() < 10) {
    throw NumericalFailure(
        fmt::format("the noise is no longer small after {} steps: too few for a rate of growth",
                    fluid->steps()),
        FailureMode::NotConverged);
  }
  const std::size_t last = logarithms.size() - 1, half = last / 2;
  return std::exp((logarithms[last] - logarithms[half]) / static_cast<double>(last - half));
}

void run_stream_stability(const StreamStudy& study, Observations& seen, Progress& progress) {
  const analytic::GrowingWave wave =
      analytic::fastest_wave(study.fluid.grid, study.fluid.relaxation_time, study.stream);
  seen.set("growth", wave.factor);
  seen.set("excess", wave.factor - 1.0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    seen.set(fmt::format("waves_{}", "xyz"[axis]), static_cast<double>(wave.waves[axis]));
  }
  seen.set("mach", study.stream.norm() / std::sqrt(fluid::sound_speed_squared));
  if (study.steps == 0) return;
  const double measured = measured_growth(study, progress);
  seen.set("growth_run", measured);
  seen.set("departure", std::abs(std::log(measured) - std::log(wave.factor)));
}

Observations stream_stability_observations(bool with_run) {
  Observations all;
  all.metrics = {
      {"growth", {}, "1", "factor per step of the wave that grows fastest, by eigenvalue; 1 is stable"},
      {"excess", {}, "1", "growth less 1"},
      {"waves_x", {}, "1", "of that wave, in the box along x"},
      {"waves_y", {}, "1", "along y"},
      {"waves_z", {}, "1", "along z"},
      {"mach", {}, "1", "of the stream"}};
  if (!with_run) return all;
  all.metrics.push_back({"growth_run",
                         {},
                         "1",
                         "factor per step of the root mean square deviation, over the run's second half"});
  all.metrics.push_back({"departure", {}, "T^-1", "between the logarithms of both factors"});
  return all;
}

}  // namespace

engine::Study read_stream_stability(const io::Table& top) {
  const io::Table t = top.table("stream_stability");
  StreamStudy study{.fluid = read_periodic_fluid(top),
                    .stream = engine::read_vector(t, "velocity"),
                    .steps = t.has("steps") ? t.integer("steps", 100, 100'000'000) : 0,
                    .noise = 0.0};
  const std::vector<std::int64_t> nodes = t.integers("nodes");
  double waves = 1.0;
  for (const std::int64_t n : nodes) waves *= n >= 1 ? static_cast<double>(n) : most_waves + 1.0;
  if (nodes.size() != 3 || waves > most_waves) {
    t.fail(
        "nodes", "'nodes' is no size of a box",
        fmt::format("three whole numbers, with a product of up to {:.0f}: each wave is a matrix", most_waves),
        "Write for example nodes = [8, 8, 8]");
  }
  study.fluid.grid = {{nodes[0], nodes[1], nodes[2]}};
  if (!(study.stream.norm() <= 10.0)) {
    t.fail("velocity", fmt::format("the stream has a speed of {}", study.stream.norm()),
           "beyond a few nodes per step nothing is left of the scheme", "Give for example [0.1, 0.0, 0.0]");
  }
  if (study.steps > 0) {
    study.noise = t.number("noise", study.fluid.storage == fluid::Storage::Double ? 1e-12 : 1e-6);
    if (!(study.noise > 0.0) || study.noise > 0.1 * no_longer_small) {
      t.fail("noise", fmt::format("'noise' is {}", study.noise),
             fmt::format("it is positive, and small: up to {}", 0.1 * no_longer_small), "Leave it out");
    }
  }
  // Without a run there is no fluid: the eigenvalues of its waves need none.
  const scene::Outline outline =
      study.steps > 0 ? scene::Outline{.fluid = study.fluid, .initial_flow = true} : scene::Outline{};
  return study_of(top, outline, stream_stability_observations(study.steps > 0), study, run_stream_stability);
}

}  // namespace veriflex::measures
