#include <cmath>
#include <complex>
#include <numbers>

#include "analytic/immersed.hpp"
#include "engine/check_place.hpp"
#include "engine/read_scene.hpp"
#include "measures/coupling/immersed.hpp"
#include "measures/coupling/run_monitored.hpp"
#include "observe/field.hpp"

// A plane of markers, one per node, that oscillates along itself in a periodic box: Stokes' second problem
// with images. Three answers are compared: the run, a plate without thickness, and a plate as thick as its
// kernel with the slip that its force needs.

namespace veriflex::measures::immersed {

namespace {

using Complex = std::complex<double>;
using observe::Observations;

constexpr std::int64_t breadth = 4;  // nodes along and across the motion, over which nothing varies
constexpr double beside = 0.25;      // of the plate from a plane of nodes  [L]

struct Plate {
  fluid::Spec fluid;
  scene::Forcing forcing;
  std::int64_t nodes;   // from the plate to its image
  std::int64_t period;  // [T]
  std::int64_t periods;
  double velocity;  // amplitude  [L T^-1]
  observe::MonitorSpec monitor;

  double omega() const { return 2.0 * std::numbers::pi / static_cast<double>(period); }
  double viscosity() const { return fluid::viscosity(fluid.relaxation_time); }
  auto height() const { return static_cast<double>(nodes); }
};

Observations plate_observations() {
  return {.records = {{"profile",
                       "Velocity beside the plate, in phase with it and a quarter before",
                       {{"position", "y/H", "1", "from the plate, over the height of the box", {}},
                        {"in_phase", "", "1", "over the plate's velocity", {}},
                        {"in_phase_exact", "", "1", "of a plate without thickness", {}},
                        {"quarter_before", "", "1", "over the plate's velocity", {}},
                        {"quarter_before_exact", "", "1", "of a plate without thickness", {}}}}},
          .metrics = {{"error_profile", {}, "1", "of the velocity, L2 over the nodes, against a thin plate"},
                      {"error_force", {}, "1", "of the force, complex, against a thin plate"},
                      {"error_theory", {}, "1", "of the force, complex, against a plate of markers"},
                      {"force_ratio", {}, "1", "amplitude over that of a thin plate"},
                      {"force_lead", {}, "1", "phase before that of a thin plate [rad]"},
                      {"slip", {}, "1", "of sum f c + g/2 over the plate's velocity"},
                      {"offset", {}, "L", "by which the plate is thicker on each side"}}};
}

fluid::Spec box(const Plate& study) {
  fluid::Spec spec = study.fluid;
  spec.grid.size = {breadth, study.nodes, breadth};
  return spec;
}

Positions plane_of_markers(double y) {
  Positions markers(breadth * breadth, 3);
  for (std::int64_t i = 0; i < markers.rows(); ++i) {
    markers.row(i) << static_cast<double>(i % breadth), y, static_cast<double>(i / breadth);
  }
  return markers;
}

/// First harmonics over the last period, over the plate's velocity.
struct Harmonics {
  std::vector<Complex> velocity;  // of the nodes across, sum f c + g/2
  Complex force;                  // that keeps the plate moving, per area  [M L^-2 T^-1]
  Complex slip;                   // of sum f c + g/2
};

Harmonics oscillate(const Plate& study) {
  const fluid::Spec spec = box(study);
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(spec);
  scene::PrescribedBody plate(spec, study.forcing);
  plate.place(plane_of_markers(static_cast<double>(study.nodes / 2) + beside));

  const double omega = study.omega(), velocity = study.velocity;
  const std::int64_t period = study.period;
  const std::vector<std::int64_t> across = observe::line(spec.grid, 1, {0, 0, 0});
  const fluid::NodeForces given = plate.spread();
  std::vector<std::int64_t> forced(across.size(), -1);  // rows of the nodes across among those
  for (std::size_t j = 0; j < across.size(); ++j) {
    for (std::size_t n = 0; n < given.nodes.size(); ++n) {
      if (given.nodes[n] == across[j]) forced[j] = static_cast<std::int64_t>(n);
    }
  }

  Harmonics seen{std::vector<Complex>(across.size()), 0.0, 0.0};
  Positions u;
  const auto advance = [&](std::int64_t step) {
    const bool last = step >= (study.periods - 1) * period;
    const double angle = omega * static_cast<double>(step % period);
    if (last) fluid->velocities(across, u);
    plate.advance(*fluid, {velocity * std::cos(angle), 0.0, 0.0});
    if (!last) return;
    const Complex part = std::polar(2.0 / (static_cast<double>(period) * velocity), -angle);
    for (std::size_t j = 0; j < across.size(); ++j) {
      const double half = forced[j] < 0 ? 0.0 : 0.5 * (*given.force)(forced[j], 0);
      seen.velocity[j] += part * (u(static_cast<Eigen::Index>(j), 0) + half);
    }
    seen.force -= part * plate.total_force()[0] / static_cast<double>(breadth * breadth);
    seen.slip += part * plate.slip_of_fluid()(0, 0);
  };
  run_monitored(*fluid, study.monitor, "the plate", study.periods * period, advance);
  return seen;
}

/// Of a node from the nearest image of the plate  [L].
double distance(std::int64_t nodes, std::size_t j) {
  const double d = std::abs(static_cast<double>(j) - (static_cast<double>(nodes / 2) + beside));
  return std::min(d, static_cast<double>(nodes) - d);
}

/// Against a plate without thickness: error of the velocity, L2 over the nodes.
double profile_error(const Plate& study, const Harmonics& seen) {
  double error = 0.0, size = 0.0;
  for (std::size_t j = 0; j < seen.velocity.size(); ++j) {
    const Complex exact = analytic::oscillating_plate(distance(study.nodes, j), study.height(), study.omega(),
                                                      study.viscosity());
    error += std::norm(seen.velocity[j] - exact);
    size += std::norm(exact);
  }
  return std::sqrt(error / size);
}

/// From the plate to where an exact one would have the velocity that is seen  [L]. A quarter of the height
/// away the flow is, to first order, that of a plate nearer by the offset.
double offset_of(const Plate& study, const Harmonics& seen) {
  const auto exact_at = [&](double y) {
    return analytic::oscillating_plate(y, study.height(), study.omega(), study.viscosity());
  };
  const auto probe = static_cast<std::size_t>(study.nodes / 4);
  const double y = distance(study.nodes, probe);
  const double h = 1e-4;
  const Complex exact = exact_at(y), slope = (exact_at(y + h) - exact_at(y - h)) / (2.0 * h * exact);
  return -((seen.velocity[probe] / exact - 1.0) / slope).real();
}

/// Of a plate as thick as its kernel, with the slip that its force needs.
Complex force_of_markers(const Plate& study) {
  std::vector<double> weights(static_cast<std::size_t>(study.nodes));
  coupling::visit(study.forcing.delta, [&](auto kernel) {
    for (std::int64_t j = 0; j < study.nodes; ++j) {
      weights[static_cast<std::size_t>(j)] = kernel.phi(static_cast<double>(j - study.nodes / 2) - beside);
    }
  });
  return analytic::marker_plate_force(weights, study.forcing.forcing_iterations, study.omega(),
                                      study.viscosity());
}

void record_profile(const Plate& study, const Harmonics& seen, observe::Record& record) {
  for (std::size_t j = 0; j < seen.velocity.size(); ++j) {
    const Complex exact = analytic::oscillating_plate(distance(study.nodes, j), study.height(), study.omega(),
                                                      study.viscosity());
    const double from = static_cast<double>(j) - static_cast<double>(study.nodes / 2) - beside;
    record.append({from / study.height(), seen.velocity[j].real(), exact.real(), seen.velocity[j].imag(),
                   exact.imag()});
  }
}

void run_plate(const Plate& study, Observations& seen, engine::Cost& cost) {
  const Harmonics found = oscillate(study);
  cost.finish("oscillation");
  const Complex ratio =
      found.force / analytic::oscillating_plate_force(study.height(), study.omega(), study.viscosity());
  record_profile(study, found, seen.open("profile"));
  seen.set("error_profile", profile_error(study, found));
  seen.set("error_force", std::abs(ratio - 1.0));
  seen.set("error_theory", std::abs(found.force / force_of_markers(study) - 1.0));
  seen.set("force_ratio", std::abs(ratio));
  seen.set("force_lead", std::arg(ratio));
  seen.set("slip", std::abs(found.slip));
  seen.set("offset", offset_of(study, found));
}

}  // namespace

engine::Study read_plate(const io::Table& top) {
  const io::Table t = top.table("immersed");
  const Plate study{.fluid = read_fluid(top),
                    .forcing = read_forcing(top, Volume::OfSurface),
                    .nodes = t.integer("nodes", 8, 4096),
                    .period = t.integer("period", 8, 100'000'000),
                    .periods = t.integer("periods", 1, 10000),
                    .velocity = read_positive(t, "velocity", 0.01),
                    .monitor = engine::read_monitor(top)};
  engine::whole_steps(static_cast<double>(study.periods) * static_cast<double>(study.period), 1.0,
                      "the plate takes", t.place("periods"));
  return {
      .plan = engine::read_plan(top, {.fluid = box(study),
                                      .coupling = engine::read_coupling(top),
                                      .exchange = "markers of a plane, moved along itself"}),
      .declares = plate_observations(),
      .run = [study](Observations& seen, Progress&, engine::Cost& cost) { run_plate(study, seen, cost); }};
}

}  // namespace veriflex::measures::immersed
