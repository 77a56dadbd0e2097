#include <fmt/format.h>

#include <cmath>
#include <complex>
#include <exception>
#include <numbers>
#include <optional>

#include "analytic/immersed.hpp"
#include "engine/check_place.hpp"
#include "engine/read_scene.hpp"
#include "measures/coupling/immersed.hpp"
#include "measures/coupling/run_monitored.hpp"
#include "measures/for_all.hpp"
#include "observe/field.hpp"

// A plane of markers, one per node, that oscillates along itself in a periodic box: Stokes' second problem
// with images. Three answers are compared: the run, a plate without thickness, and a plate as thick as its
// kernel with the slip that its force needs.

namespace veriflex::measures::immersed {

namespace {

using Complex = std::complex<double>;
using observe::Observations;
using observe::Record;

constexpr std::int64_t breadth = 4;  // nodes along and across the motion, over which nothing varies
constexpr double beside = 0.25;      // of the plate from a plane of nodes  [L]

struct Plate {
  fluid::Spec fluid;
  scene::Forcing forcing;
  std::vector<std::int64_t> resolutions;  // nodes from the plate to its image
  std::int64_t period;                    // at the first resolution  [T]
  std::int64_t periods;
  double velocity;              // at the first resolution  [L T^-1]
  std::vector<int> iterations;  // plotted against run time, at the last resolution
  observe::MonitorSpec monitor;

  /// Grows as nodes^2, as diffusion takes.
  std::int64_t period_at(std::int64_t nodes) const {
    const std::int64_t first = resolutions.front();
    return period * nodes * nodes / (first * first);
  }
  double omega_at(std::int64_t nodes) const {
    return 2.0 * std::numbers::pi / static_cast<double>(period_at(nodes));
  }
};

fluid::Spec box(const Plate& study, std::int64_t nodes) {
  fluid::Spec spec = study.fluid;
  spec.grid.size = {breadth, nodes, breadth};
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

Harmonics oscillate(const Plate& study, std::int64_t nodes, int iterations) {
  const fluid::Spec spec = box(study, nodes);
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(spec);
  scene::Forcing forcing = study.forcing;
  forcing.forcing_iterations = iterations;
  scene::PrescribedBody plate(spec, forcing);
  const auto middle = static_cast<double>(nodes / 2);
  plate.place(plane_of_markers(middle + beside));

  const double omega = study.omega_at(nodes);
  const double velocity =
      study.velocity * static_cast<double>(study.resolutions.front()) / static_cast<double>(nodes);
  const std::int64_t period = study.period_at(nodes);
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
  run_monitored(*fluid, study.monitor, fmt::format("{} nodes, {} forcing iterations", nodes, iterations),
                [&](const std::function<void()>& look_when_due) {
                  for (std::int64_t step = 0; step < study.periods * period; ++step) {
                    advance(step);
                    look_when_due();
                  }
                });
  return seen;
}

/// Of a node from the nearest image of the plate  [L].
double distance(std::int64_t nodes, std::size_t j) {
  const double d = std::abs(static_cast<double>(j) - (static_cast<double>(nodes / 2) + beside));
  return std::min(d, static_cast<double>(nodes) - d);
}

struct Compared {
  double profile;  // error of the velocity, L2 over the nodes, against the plate without thickness
  double force;    // |measured/exact - 1| of the force, likewise
  double theory;   // the same against the plate of markers
  double slip;     // over the plate's velocity
  double offset;   // from the plate to where an exact one would have the velocity that is seen  [L]
  Complex ratio;   // force over that of the plate without thickness
};

Compared compare(const Plate& study, std::int64_t nodes, int iterations, const Harmonics& seen) {
  const double nu = fluid::viscosity(study.fluid.relaxation_time);
  const double omega = study.omega_at(nodes);
  const auto height = static_cast<double>(nodes);
  double error = 0.0, size = 0.0;
  for (std::size_t j = 0; j < seen.velocity.size(); ++j) {
    const Complex exact = analytic::oscillating_plate(distance(nodes, j), height, omega, nu);
    error += std::norm(seen.velocity[j] - exact);
    size += std::norm(exact);
  }
  // Where a quarter of the height away the flow is, to first order, that of a plate nearer by the offset.
  const auto probe = static_cast<std::size_t>(nodes / 4);
  const double y = distance(nodes, probe);
  const Complex exact = analytic::oscillating_plate(y, height, omega, nu);
  const double h = 1e-4;
  const Complex slope = (analytic::oscillating_plate(y + h, height, omega, nu) -
                         analytic::oscillating_plate(y - h, height, omega, nu)) /
                        (2.0 * h * exact);
  std::vector<double> weights(static_cast<std::size_t>(nodes));
  coupling::visit(study.forcing.delta, [&](auto kernel) {
    for (std::int64_t j = 0; j < nodes; ++j) {
      weights[static_cast<std::size_t>(j)] = kernel.phi(static_cast<double>(j - nodes / 2) - beside);
    }
  });
  const Complex ratio = seen.force / analytic::oscillating_plate_force(height, omega, nu);
  return {std::sqrt(error / size),
          std::abs(ratio - 1.0),
          std::abs(seen.force / analytic::marker_plate_force(weights, iterations, omega, nu) - 1.0),
          std::abs(seen.slip),
          -((seen.velocity[probe] / exact - 1.0) / slope).real(),
          ratio};
}

Record profile_of(const Plate& study, std::int64_t nodes, const Harmonics& seen) {
  Record record{"profile",
                "Velocity beside the plate at the finest resolution, in phase with it and a quarter before",
                {{"position", "y/H", "1", "from the plate, over the height of the box", {}},
                 {"in_phase", "", "1", "over the plate's velocity", {}},
                 {"in_phase_exact", "", "1", "of a plate without thickness", {}},
                 {"quarter_before", "", "1", "over the plate's velocity", {}},
                 {"quarter_before_exact", "", "1", "of a plate without thickness", {}}}};
  const double nu = fluid::viscosity(study.fluid.relaxation_time);
  const auto height = static_cast<double>(nodes);
  for (std::size_t j = 0; j < seen.velocity.size(); ++j) {
    const Complex exact = analytic::oscillating_plate(distance(nodes, j), height, study.omega_at(nodes), nu);
    const double from = static_cast<double>(j) - static_cast<double>(nodes / 2) - beside;
    record.append(
        {from / height, seen.velocity[j].real(), exact.real(), seen.velocity[j].imag(), exact.imag()});
  }
  return record;
}

/// What more forcing iterations buy; run time of row i, with one thread, is the phase `iterations/i`.
Record iterations_of(const Plate& study, Progress& progress, engine::Cost& cost) {
  Record record{"iterations",
                "Rounds of direct forcing: slip, and error of the force",
                {{"iterations", "", "1", "forcing iterations in each step", {}},
                 {"slip", "", "1", "of sum f c + g/2 over the plate's velocity", {}},
                 {"error_force", "", "1", "against a plate without thickness", {}},
                 {"error_profile", "", "1", "against a plate without thickness, L2", {}},
                 {"error_theory", "", "1", "of the force, against a plate of markers", {}},
                 {"offset", "", "L", "by which the plate is thicker on each side", {}}}};
  const std::int64_t nodes = study.resolutions.back();
  for (std::size_t i = 0; i < study.iterations.size(); ++i) {
    cost.finish("else");
    Harmonics seen;
    for_all(1, "forcing iterations", progress,
            [&](std::size_t) { seen = oscillate(study, nodes, study.iterations[i]); });
    cost.finish(fmt::format("iterations/{}", i));
    const Compared c = compare(study, nodes, study.iterations[i], seen);
    record.append({static_cast<double>(study.iterations[i]), c.slip, c.force, c.profile, c.theory, c.offset});
  }
  return record;
}

void run(const Plate& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  const std::size_t count = study.resolutions.size();
  std::vector<std::optional<Harmonics>> found(count);
  std::exception_ptr broken;
  try {
    for_all(count, "boxes", progress, [&](std::size_t i) {  // the finest first: it takes longest
      const std::size_t at = count - 1 - i;
      found[at] = oscillate(study, study.resolutions[at], study.forcing.forcing_iterations);
    });
  } catch (const NumericalFailure&) {
    broken = std::current_exception();
  }
  cost.finish("resolutions");
  Record convergence{"convergence",
                     "Error against a plate without thickness",
                     {{"spacing", "", "1", "1/nodes from the plate to its image", {}},
                      {"error_profile", "", "1", "velocity, L2 over the nodes", {}},
                      {"error_force", "", "1", "relative, complex", {}},
                      {"error_theory", "", "1", "of the force, against a plate of markers", {}}}};
  std::vector<Compared> all;
  for (std::size_t i = 0; i < count; ++i) {
    if (!found[i]) continue;
    const std::int64_t nodes = study.resolutions[i];
    all.push_back(compare(study, nodes, study.forcing.forcing_iterations, *found[i]));
    convergence.append(
        {1.0 / static_cast<double>(nodes), all.back().profile, all.back().force, all.back().theory});
  }
  if (broken) {
    seen.records.push_back(convergence);
    std::rethrow_exception(broken);
  }
  const Compared& coarse = all[count - 2];
  const Compared& fine = all[count - 1];
  const double refined = std::log(static_cast<double>(study.resolutions[count - 1]) /
                                  static_cast<double>(study.resolutions[count - 2]));
  const auto order = [refined](double a, double b) { return std::log(a / b) / refined; };
  seen = {
      .records = {profile_of(study, study.resolutions.back(), *found.back()), convergence},
      .metrics = {
          {"order_profile", order(coarse.profile, fine.profile), "1", "in the spacing, last two rows"},
          {"order_force", order(coarse.force, fine.force), "1", "in the spacing, last two rows"},
          {"order_theory", order(coarse.theory, fine.theory), "1", "in the spacing, last two rows"},
          {"error_profile", fine.profile, "1", "of the finest resolution"},
          {"error_force", fine.force, "1", "of the finest resolution, complex"},
          {"error_theory", fine.theory, "1", "of the finest resolution, against a plate of markers"},
          {"force_ratio", std::abs(fine.ratio), "1", "amplitude over the exact one, finest resolution"},
          {"force_lead", std::arg(fine.ratio), "1", "phase before the exact one, finest resolution [rad]"},
          {"slip", fine.slip, "1", "of sum f c + g/2 over the plate's velocity"},
          {"offset", fine.offset, "L", "by which the plate is thicker on each side"}}};
  if (!study.iterations.empty()) {
    const Record record = iterations_of(study, progress, cost);
    for (std::size_t i = 0; i < study.iterations.size(); ++i) {
      const std::string name = fmt::format("_{}", study.iterations[i]);
      seen.metrics.push_back(
          {"slip" + name, record.find("slip")->values[i], "1", "with so many forcing iterations"});
      seen.metrics.push_back({"error_force" + name, record.find("error_force")->values[i], "1",
                              "with so many forcing iterations"});
      seen.metrics.push_back({"error_theory" + name, record.find("error_theory")->values[i], "1",
                              "with so many forcing iterations"});
    }
    seen.records.push_back(record);
  }
}

}  // namespace

engine::Study read_plate(const io::Table& top) {
  const io::Table t = top.table("immersed");
  Plate study{.fluid = read_fluid(top, false),
              .forcing = read_forcing(top),
              .resolutions = read_rising(t, "resolutions", 8, 4096),
              .period = t.integer("period", 8, 200'000),
              .periods = t.integer("periods", 1, 10000),
              .velocity = read_positive(t, "velocity", 0.01),
              .iterations = {},
              .monitor = engine::read_monitor(top)};
  if (t.has("forcing_iterations")) {
    for (const std::int64_t count : t.integers("forcing_iterations")) {
      if (count < 1 || count > 100) {
        t.fail("forcing_iterations", fmt::format("'forcing_iterations' holds {}", count),
               "a step has 1 to 100 forcing iterations", "Give for example [1, 2, 4]");
      }
      if (std::find(study.iterations.begin(), study.iterations.end(), count) != study.iterations.end()) {
        t.fail("forcing_iterations", fmt::format("'forcing_iterations' holds {} twice", count),
               "their metrics could not be told apart", "Leave one out");
      }
      study.iterations.push_back(static_cast<int>(count));
    }
  }
  if (top.has("coupling") && top.table("coupling").has("marker_volume")) {
    top.table("coupling")
        .fail("marker_volume", "'marker_volume' is set", "a marker stands for its share of the plate times h",
              "Leave it out");
  }
  for (const std::int64_t nodes : study.resolutions) {
    const std::int64_t first = study.resolutions.front();
    if (study.period * nodes * nodes % (first * first) != 0) {
      t.fail("period", fmt::format("at {} nodes a period is not a whole number of steps", nodes),
             "it grows with the square of the resolution", "Let resolutions be multiples of the first");
    }
  }
  engine::whole_steps(
      static_cast<double>(study.periods) * static_cast<double>(study.period_at(study.resolutions.back())),
      1.0, "the finest plate takes", t.place("periods"));
  std::vector<std::string> measures{"order_profile", "order_force",  "order_theory", "error_profile",
                                    "error_force",   "error_theory", "force_ratio",  "force_lead",
                                    "slip",          "offset"};
  for (const int count : study.iterations) {
    for (const char* what : {"slip", "error_force", "error_theory"})
      measures.push_back(fmt::format("{}_{}", what, count));
  }
  return {.plan = engine::read_plan(top, {.fluid = box(study, study.resolutions.back()),
                                          .coupling = engine::read_coupling(top),
                                          .exchange = "markers of a plane, moved along itself"}),
          .measures = measures,
          .run = [study](Observations& seen, Progress& progress, engine::Cost& cost) {
            run(study, seen, progress, cost);
          }};
}

}  // namespace veriflex::measures::immersed
