#include <fmt/format.h>

#include <cmath>
#include <complex>

#include "analytic/lattice_wave.hpp"
#include "measures/drivers.hpp"
#include "measures/fluid/periodic_fluid.hpp"
#include "measures/fluid/steady.hpp"

namespace veriflex::measures {

namespace {

using analytic::Complex;
using analytic::DecayingFlow;
using observe::Observations;

// Of the vortices: what their squares do is far below what the stream does, rounding is farther below.
constexpr double vortex_amplitude = 1e-6;

struct Galilean {
  fluid::Spec fluid;
  DecayingFlow flow;  // on a stream along the first axis of its plane
  double speed;       // of the stream  [L T^-1]
  observe::MonitorSpec monitor;
};

// Taylor-Green vortices are four plane shear waves; this is the one along (1, 1) in the plane.
struct DiagonalWave {
  Vec3 k = Vec3::Zero();
  Vec3 along = Vec3::Zero();
};

DiagonalWave diagonal_wave(const DecayingFlow& flow) {
  DiagonalWave wave;
  for (const int axis : {flow.a, flow.b}) wave.k[axis] = flow.wavenumber;
  wave.along[flow.a] = std::sqrt(0.5);
  wave.along[flow.b] = -std::sqrt(0.5);
  return wave;
}

double strength(const fluid::Fluid& fluid, const DiagonalWave& wave) {
  const Grid& grid = fluid.spec().grid;
  Complex sum = 0.0;
  in_parts(grid, [&](std::span<const std::int64_t> nodes) {
    const Positions u = velocities_of(fluid, nodes);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      sum += u.row(static_cast<Eigen::Index>(i)).dot(wave.along) *
             std::polar(1.0, -wave.k.dot(position(grid, nodes[i])));
    }
  });
  return std::abs(sum);
}

// Between half an e-folding, when what the start left out of the lattice's own wave is gone, and one and a
// half.
double measured_decay(const Galilean& study, const DiagonalWave& wave, Progress& progress) {
  scene::Simulation simulation(starting(study.fluid, study.flow, Start::Balanced));
  const auto half = std::max<std::int64_t>(1, std::llround(0.5 / study.flow.decay_rate()));
  observe::Run run(simulation, study.monitor, {}, "", progress);
  run.advance(half, 3 * half);
  const double before = strength(simulation.fluid(), wave);
  run.advance(2 * half, 3 * half);
  run.finish();
  return std::log(before / strength(simulation.fluid(), wave)) / static_cast<double>(2 * half);
}

void run_galilean(const Galilean& study, Observations& seen, Progress& progress) {
  const DiagonalWave wave = diagonal_wave(study.flow);
  const double measured = measured_decay(study, wave, progress);
  const auto exact = [&](const Vec3& stream) {
    return analytic::lattice_wave(wave.k, study.fluid.relaxation_time, {0.0, wave.along}, stream)
        .decay_rate();
  };
  const double carried = exact(study.flow.stream), at_rest = exact(Vec3::Zero());
  const double squared = study.speed * study.speed;
  seen.set("error_viscosity", 1.0 - measured / at_rest);
  seen.set("error_viscosity_exact", 1.0 - carried / at_rest);
  seen.set("error_viscosity_long_waves", 1.5 * squared);
  seen.set("constant", (1.0 - measured / at_rest) / squared);
  seen.set("departure", std::abs(measured / carried - 1.0));
}

Observations galilean_observations() {
  Observations all;
  all.metrics = {
      {"error_viscosity",
       {},
       "1",
       "what the stream takes of the viscosity, over that without one by eigenvalue"},
      {"error_viscosity_exact", {}, "1", "the same by eigenvalues of the collide-and-stream matrix"},
      {"error_viscosity_long_waves", {}, "1", "3 (U.k)^2/k^2 of the equilibrium's missing cubic term"},
      {"constant", {}, "L^-2 T^2", "error_viscosity over U^2"},
      {"departure", {}, "1", "of the decay rate from its eigenvalue, relative"}};
  return all;
}

}  // namespace

engine::Study read_galilean(const io::Table& top) {
  const io::Table t = top.table("galilean");
  Galilean study{.fluid = read_periodic_fluid(top),
                 .flow = {},
                 .speed = t.number("speed"),
                 .monitor = engine::read_monitor(top)};
  const double fastest = study.monitor.mach_limit * std::sqrt(fluid::sound_speed_squared);
  if (!(study.speed > 0.0) || study.speed > fastest) {
    t.fail("speed", fmt::format("'speed' is {}", study.speed),
           fmt::format("it is positive and stays below the monitor's limit, {:.3g}", fastest),
           "Give for example 0.05");
  }
  const std::array<int, 2> plane = read_plane(t);
  const std::int64_t nodes = read_nodes(t, 4);
  study.fluid.grid = plane_box(nodes, plane);
  study.flow = {.pattern = analytic::Pattern::TaylorGreen,
                .a = plane[0],
                .b = plane[1],
                .wavenumber = wavenumber(nodes),
                .amplitude = vortex_amplitude,
                .viscosity = fluid::viscosity(study.fluid.relaxation_time)};
  study.flow.stream[plane[0]] = study.speed;
  require_steps(top.table("fluid"), 1.5 / study.flow.decay_rate());
  return study_of(top, {.fluid = study.fluid, .initial_flow = true}, galilean_observations(), study,
                  run_galilean);
}

}  // namespace veriflex::measures
