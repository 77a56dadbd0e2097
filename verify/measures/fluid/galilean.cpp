#include <fmt/format.h>

#include <cmath>
#include <complex>
#include <limits>

#include "analytic/lattice_wave.hpp"
#include "base/reduce.hpp"
#include "engine/convergence.hpp"
#include "measures/drivers.hpp"
#include "measures/fluid/periodic_fluid.hpp"
#include "measures/fluid/run_fluid.hpp"
#include "measures/for_all.hpp"

namespace veriflex::measures {

namespace {

using analytic::Complex;
using analytic::DecayingFlow;
using observe::Observations;
using observe::Record;

// Of the vortices: what their squares do is far below what the stream does, rounding is farther below.
constexpr double amplitude = 1e-6;

struct GalileanStudy {
  fluid::Spec fluid;
  std::array<int, 2> plane;  // the stream is along the first axis
  std::int64_t nodes;        // along a side
  std::vector<double> speeds;
  observe::MonitorSpec monitor;
};

// Decay rates of Taylor-Green vortices that a stream carries.
struct Decay {
  double measured, exact;
};

// Taylor-Green vortices are four plane shear waves; this is the one along (1, 1) in the plane.
struct DiagonalWave {
  Vec3 k = Vec3::Zero();
  Vec3 along = Vec3::Zero();
};

DiagonalWave diagonal_wave(const GalileanStudy& study) {
  DiagonalWave wave;
  for (const int axis : study.plane) wave.k[axis] = wavenumber(study.nodes);
  wave.along[study.plane[0]] = std::sqrt(0.5);
  wave.along[study.plane[1]] = -std::sqrt(0.5);
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

DecayingFlow flow_of(const GalileanStudy& study, double speed) {
  DecayingFlow flow{.pattern = analytic::Pattern::TaylorGreen,
                    .a = study.plane[0],
                    .b = study.plane[1],
                    .wavenumber = wavenumber(study.nodes),
                    .amplitude = amplitude,
                    .viscosity = fluid::viscosity(study.fluid.relaxation_time)};
  flow.stream[flow.a] = speed;
  return flow;
}

// Between half an e-folding, when what the start left out of the lattice's own wave is gone, and one and a
// half.
Decay measure(const GalileanStudy& study, double speed) {
  const double tau = study.fluid.relaxation_time;
  const DecayingFlow flow = flow_of(study, speed);
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(study.fluid);
  start(*fluid, flow, Start::Balanced);
  const DiagonalWave wave = diagonal_wave(study);
  const auto half = std::max<std::int64_t>(1, std::llround(0.5 / flow.decay_rate()));
  observe::Monitor monitor(*fluid, study.monitor);
  run_steps(half, monitor);
  const double before = strength(*fluid, wave);
  run_steps(2 * half, monitor);
  monitor.at_end();
  const double after = strength(*fluid, wave);
  return {std::log(before / after) / static_cast<double>(2 * half),
          analytic::lattice_wave(wave.k, tau, {0.0, wave.along}, flow.stream).decay_rate()};
}

void run(const GalileanStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  std::vector<double> speeds{0.0};
  speeds.insert(speeds.end(), study.speeds.begin(), study.speeds.end());
  seen.records.push_back(
      {"galilean",
       "Viscosity of Taylor-Green vortices that a stream carries",
       {{"speed", "U", "L T^-1", "of the stream, along an axis", {}},
        {"viscosity_ratio", "", "1", "measured, over that without a stream", {}},
        {"error", "", "1", "1 - measured ratio", {}},
        {"error_exact", "", "1", "the same by eigenvalues of the collide-and-stream matrix", {}},
        {"error_theory", "", "1", "3 (U.k)^2/k^2 of the equilibrium's missing cubic term", {}}}});
  Record& record = seen.records.front();
  std::vector<Decay> decays(speeds.size());
  double worst = 0.0;
  double at_rest = std::numeric_limits<double>::quiet_NaN();  // decay rate without a stream
  for_all(
      speeds.size(), "streams", progress, [&](std::size_t i) { decays[i] = measure(study, speeds[i]); },
      [&](std::size_t i) {
        worst = worse(worst, std::abs(decays[i].measured / decays[i].exact - 1.0));
        if (i == 0) at_rest = decays[i].measured;
        if (i == 0 || std::isnan(at_rest)) return;  // nothing to hold it against
        const double ratio = decays[i].measured / at_rest;
        record.append({speeds[i], ratio, 1.0 - ratio, 1.0 - decays[i].exact / decays[0].exact,
                       1.5 * speeds[i] * speeds[i]});
      });
  cost.finish("streams");
  const std::vector<double>& error = record.columns[2].values;
  const engine::PowerLaw law = engine::power_law(study.speeds, error);
  seen.metrics = {
      {"order", law.exponent, "1", "exponent of the viscosity's error in the stream's speed, least squares"},
      {"constant", error.front() / (study.speeds.front() * study.speeds.front()), "L^-2 T^2",
       "error over U^2 at the lowest speed"},
      {"error_fastest", error.back(), "1", "relative error of the viscosity at the highest speed"},
      {"worst_departure", worst, "1", "largest relative departure of a decay rate from its eigenvalue"}};
}

}  // namespace

engine::Study read_galilean(const io::Table& top) {
  const io::Table t = top.table("galilean");
  GalileanStudy study{.fluid = read_periodic_fluid(top, engine::Varied::Nodes),
                      .plane = axes_of(t.choice("plane", {"xy", "yz", "zx"})),
                      .nodes = t.integer("side", 4, 4096),
                      .speeds = t.numbers("speeds"),
                      .monitor = engine::read_monitor(top)};
  const double fastest = study.monitor.mach_limit * std::sqrt(fluid::sound_speed_squared);
  study.fluid.grid = plane_box(study.nodes, study.plane);
  if (study.speeds.size() < 2)
    t.fail("speeds", "fewer than two", "an order needs two", "Give for example [0.02, 0.05, 0.1]");
  for (std::size_t i = 0; i < study.speeds.size(); ++i) {
    if (!(study.speeds[i] > (i == 0 ? 0.0 : study.speeds[i - 1])) || study.speeds[i] > fastest) {
      t.fail("speeds", fmt::format("'speeds' holds {}", study.speeds[i]),
             fmt::format("they are positive, rise, and stay below the monitor's limit, {:.3g}", fastest),
             "Give for example [0.02, 0.05, 0.1]");
    }
  }
  require_steps(top.table("fluid"), 1.5 / flow_of(study, 0.0).decay_rate());
  return {.plan = plan_at_once(top, std::vector(study.speeds.size() + 1, study.fluid)),
          .measures = {"order", "constant", "error_fastest", "worst_departure"},
          .run = [study](Observations& seen, Progress& progress, engine::Cost& cost) {
            run(study, seen, progress, cost);
          }};
}

}  // namespace veriflex::measures
