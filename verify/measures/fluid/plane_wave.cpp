#include <fmt/format.h>

#include <cmath>

#include "analytic/lattice_wave.hpp"
#include "base/error.hpp"
#include "measures/drivers.hpp"
#include "measures/fluid/periodic_fluid.hpp"
#include "measures/fluid/steady.hpp"

namespace veriflex::measures {

namespace {

using analytic::Complex;
using analytic::LatticeWave;
using observe::Observations;

// Populations are deviations from rest, so that a small wave keeps all its digits, and what the equilibrium's
// squares add to it is of the order of its square.
constexpr double wave_amplitude = 1e-8;

struct PlaneWave {
  fluid::Spec fluid;
  bool sound;                        // or shear
  Vec3 k = Vec3::Zero();             // [L^-1]
  Vec3 polarization = Vec3::Zero();  // of shear, across k
  std::int64_t nodes;                // along each side that k has a component along
  std::int64_t steps;

  double continuum_decay() const { return fluid::viscosity(fluid.relaxation_time) * std::pow(k.norm(), 2); }
  double continuum_frequency() const { return k.norm() * std::sqrt(fluid::sound_speed_squared); }
};

// What a factor per step says over what the continuum says: it must become 1 as waves get long.
struct Quantity {
  std::string name, meaning;
  double (*of)(const PlaneWave&, const Complex& factor);
};

std::vector<Quantity> quantities(bool sound) {
  const auto damping = [](const PlaneWave& wave, const Complex& factor) {
    return -std::log(std::abs(factor)) / wave.continuum_decay();
  };
  const auto speed = [](const PlaneWave& wave, const Complex& factor) {
    return -std::arg(factor) / wave.continuum_frequency();
  };
  if (!sound) return {{"viscosity", "decay rate over nu k^2", damping}};
  return {{"speed", "of sound, over 1/sqrt(3)", speed}, {"attenuation", "decay rate over nu k^2", damping}};
}

// The share of this wave in the fluid.
Complex share(const fluid::Fluid& fluid, const Vec3& k, const LatticeWave& wave) {
  const Grid& grid = fluid.spec().grid;
  Complex sum = 0.0;
  in_parts(grid, [&](std::span<const std::int64_t> nodes) {
    std::vector<fluid::Populations> h(nodes.size());
    fluid.populations(nodes, h);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      Complex here = 0.0;
      for (std::size_t q = 0; q < fluid::Q; ++q) here += wave.projection[static_cast<int>(q)] * h[i][q];
      sum += here * std::polar(1.0, -k.dot(position(grid, nodes[i])));
    }
  });
  return sum / static_cast<double>(grid.count());
}

// Steps until a wave is a ten-thousandth of itself at the most: what rounding leaves behind decays slower
// than a strongly damped wave.
std::int64_t steps_of(const PlaneWave& study, const LatticeWave& wave) {
  const double most = std::log(1e4) / wave.decay_rate();
  if (!(most < static_cast<double>(study.steps))) return study.steps;
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(most));
}

LatticeWave exact_wave(const PlaneWave& study) {
  const double tau = study.fluid.relaxation_time;
  const analytic::ContinuumWave like =
      study.sound ? analytic::ContinuumWave{1.0, std::sqrt(fluid::sound_speed_squared) * study.k.normalized()}
                  : analytic::ContinuumWave{0.0, study.polarization.normalized()};
  const LatticeWave wave = lattice_wave(study.k, tau, like);
  // At tau = 1 some short waves are gone after one step: their factor is 0, of which rounding leaves 1e-16.
  if (std::abs(wave.factor) < 1e-12) {
    throw NumericalFailure(
        fmt::format("tau = {}, {} nodes: the wave is gone after one step and has no decay rate. Leave this "
                    "resolution out",
                    tau, study.nodes));
  }
  return wave;
}

Observations plane_wave_observations(bool sound) {
  Observations all;
  all.metrics = {{"wavenumber", {}, "L^-1", "|k|, 2 pi over the wave length"},
                 {"departure", {}, "1", "of ln(factor per step) from the eigenvalue's, relative"}};
  for (const Quantity& q : quantities(sound)) {
    all.metrics.insert(
        all.metrics.end(),
        {{q.name, {}, "1", q.meaning},
         {q.name + "_exact", {}, "1", "the same by eigenvalue of the collide-and-stream matrix"},
         {"error_" + q.name, {}, "1", "distance from the continuum's, 1"},
         {"constant_" + q.name, {}, "L^2", "C of value = 1 + C k^2"}});
  }
  return all;
}

void run_plane_wave(const PlaneWave& study, Observations& seen, Progress& progress) {
  const LatticeWave wave = exact_wave(study);
  const Vec3& k = study.k;
  scene::Simulation simulation(
      {.fluid = study.fluid, .initial_flow = [&](std::int64_t node) {
         const Complex phase = wave_amplitude * std::polar(1.0, k.dot(position(study.fluid.grid, node)));
         fluid::Populations h;
         for (std::size_t q = 0; q < fluid::Q; ++q) h[q] = (phase * wave.shape[static_cast<int>(q)]).real();
         return h;
       }});
  const Complex before = share(simulation.fluid(), k, wave);
  const std::int64_t steps = steps_of(study, wave);
  observe::Run run(simulation, {}, {}, "", progress);
  run.advance(steps, steps);
  run.finish();
  // Over the exact factor, so that no whole turns of the phase are lost.
  const Complex ratio =
      share(simulation.fluid(), k, wave) / (before * std::pow(wave.factor, static_cast<double>(steps)));
  const Complex difference = std::log(ratio) / static_cast<double>(steps);
  const Complex measured = wave.factor * std::exp(difference);

  seen.set("wavenumber", k.norm());
  seen.set("departure", std::abs(difference) / std::abs(std::log(wave.factor)));
  for (const Quantity& q : quantities(study.sound)) {
    const double value = q.of(study, measured);
    seen.set(q.name, value);
    seen.set(q.name + "_exact", q.of(study, wave.factor));
    seen.set("error_" + q.name, std::abs(value - 1.0));
    seen.set("constant_" + q.name, (value - 1.0) / k.squaredNorm());
  }
}

Vec3 read_direction(const io::Table& table, const std::string& key) {
  const std::vector<std::int64_t> given = table.integers(key);
  Vec3 direction = Vec3::Zero();
  for (std::size_t i = 0; i < given.size() && i < 3; ++i)
    direction[static_cast<int>(i)] = static_cast<double>(given[i]);
  if (given.size() != 3 || direction.isZero(0.0) || direction.cwiseAbs().maxCoeff() > 1.0) {
    table.fail(key, fmt::format("'{}' is no direction", key),
               "it has three numbers -1, 0 or 1 that are not all 0", "Write for example [0, 1, 1]");
  }
  return direction;
}

}  // namespace

engine::Study read_plane_wave(const io::Table& top) {
  const io::Table t = top.table("plane_wave");
  const Vec3 direction = read_direction(t, "direction");
  PlaneWave study{.fluid = read_periodic_fluid(top),
                  .sound = t.choice("kind", {"shear", "sound"}) == "sound",
                  .nodes = read_nodes(t, 3),
                  .steps = t.integer("steps", 1, 10'000'000)};
  study.k = wavenumber(study.nodes) * direction;
  for (int axis = 0; axis < 3; ++axis)
    study.fluid.grid.size[static_cast<std::size_t>(axis)] = direction[axis] == 0.0 ? 1 : study.nodes;
  if (!study.sound) {
    study.polarization = read_direction(t, "polarization");
    if (study.polarization.dot(direction) != 0.0) {
      t.fail("polarization", "it is not across 'direction'", "a shear wave moves across its wave vector",
             "Choose one whose scalar product with 'direction' is 0");
    }
  }
  return study_of(top, {.fluid = study.fluid, .initial_flow = true}, plane_wave_observations(study.sound),
                  study, run_plane_wave);
}

}  // namespace veriflex::measures
