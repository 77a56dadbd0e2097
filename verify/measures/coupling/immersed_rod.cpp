#include <fmt/format.h>

#include <Eigen/QR>
#include <cmath>
#include <complex>
#include <exception>
#include <numbers>

#include "analytic/immersed.hpp"
#include "base/error.hpp"
#include "base/reduce.hpp"
#include "base/root.hpp"
#include "engine/check_place.hpp"
#include "engine/read_scene.hpp"
#include "measures/coupling/immersed.hpp"
#include "measures/coupling/run_monitored.hpp"
#include "measures/for_all.hpp"
#include "solid/network.hpp"

// A slice of a rigid rod that oscillates across its axis: the boundary nodes of the lattice's section, in a
// box of one node along the axis, against Stokes' cylinder in an unbounded fluid.
//
// The body is filled with fluid, which its motion carries along: what the markers exchange contains, beside
// viscous drag and added mass of the fluid outside, the inertia of the fluid inside, pi a^2 per length. The
// rod's own mass is not in it. Forces are compared per velocity of the fluid at the markers, which stays
// behind the rod's by the slip that direct forcing needs. The radius a is fitted to the amplitude at the
// first period in the largest box; phases, and other periods and boxes, are predictions.

namespace veriflex::measures::immersed {

namespace {

using Complex = std::complex<double>;
using observe::Observations;
using observe::Record;

struct Rod {
  fluid::Spec fluid;
  scene::Forcing forcing;
  double radius;                      // of the lattice's section, in spacings
  std::vector<std::int64_t> boxes;    // nodes along both sides
  std::vector<std::int64_t> periods;  // of the oscillation  [T]
  std::vector<double> amplitudes;  // z0; the first everywhere, all at the first period in the largest box [L]
  std::int64_t cycles;             // run; the last is measured
  observe::MonitorSpec monitor;
};

constexpr std::int64_t max_period = 200'000;
constexpr double max_layer = 25.0;  // boxes
constexpr std::int64_t unlimited = 1'000'000'000;

struct Piece {
  std::int64_t box;
  std::int64_t period;
  double amplitude;
};

fluid::Spec box_of(const Rod& study, std::int64_t nodes) {
  fluid::Spec spec = study.fluid;
  spec.grid.size = {nodes, nodes, 1};
  return spec;
}

/// The section's nodes with fewer than four neighbours in it, around the origin.
Positions ring_of(double radius) {
  const solid::Network network = solid::rod_lattice({radius, 3, 1.0});
  std::vector<std::int32_t> ring;
  for (const std::int32_t node : solid::boundary_nodes(network)) {
    if (network.rest(node, 2) == 1.0) ring.push_back(node);  // the section in the middle has no end cap
  }
  Positions markers(static_cast<Eigen::Index>(ring.size()), 3);
  for (std::size_t i = 0; i < ring.size(); ++i) {
    markers.row(static_cast<Eigen::Index>(i)) << network.rest(ring[i], 0), network.rest(ring[i], 1), 0.0;
  }
  return markers;
}

struct Motion {
  double at, velocity;
};

/// z0 sin(omega t), risen smoothly over the first cycle: an abrupt start would leave a stream in the box.
Motion motion_at(double time, const Piece& piece) {
  const auto period = static_cast<double>(piece.period);
  const double omega = 2.0 * std::numbers::pi / period;
  const double part = std::min(time / period, 1.0);
  const double rise = part * part * (3.0 - 2.0 * part);
  const double rising = time < period ? 6.0 * part * (1.0 - part) / period : 0.0;
  return {piece.amplitude * rise * std::sin(omega * time),
          piece.amplitude * (rising * std::sin(omega * time) + rise * omega * std::cos(omega * time))};
}

struct Answer {
  Complex force;    // that keeps the rod moving, per velocity and length  [M L^-1 T^-1]
  Complex carried;  // mean velocity of the fluid at the markers, sum f c + g/2, over the rod's
  double residual;  // of the force from its first harmonic, root mean square over its amplitude
  double slip;      // root mean square over markers and cycle, of sum f c + g/2, over the largest velocity
};

Answer oscillate(const Rod& study, const Piece& piece) {
  const fluid::Spec spec = box_of(study, piece.box);
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(spec);
  scene::PrescribedBody rod(spec, study.forcing);
  const Positions ring = ring_of(study.radius);
  const auto middle = static_cast<double>(piece.box / 2);
  const double omega = 2.0 * std::numbers::pi / static_cast<double>(piece.period);
  const std::int64_t start = (study.cycles - 1) * piece.period;

  Eigen::MatrixXd basis(piece.period, 4);
  Eigen::VectorXd force(piece.period), carried(piece.period);
  double slip = 0.0;
  const auto advance = [&](std::int64_t step) {
    const Motion motion = motion_at(static_cast<double>(step), piece);
    rod.place(ring.rowwise() + Vec3(middle, middle + motion.at, 0.0).transpose());
    rod.advance(*fluid, {0.0, motion.velocity, 0.0});
    if (step < start) return;
    const std::int64_t row = step - start;
    const double angle = omega * static_cast<double>(row);
    // A constant and a slope: the rest of the stream that the start left.
    basis.row(row) << std::cos(angle), -std::sin(angle), 1.0,
        static_cast<double>(row) / static_cast<double>(piece.period);
    force[row] = -rod.total_force()[1];
    const Positions left = rod.slip_of_fluid();
    carried[row] = motion.velocity + left.col(1).mean();
    slip += left.squaredNorm() / static_cast<double>(ring.rows() * piece.period);
  };
  run_monitored(*fluid, study.monitor,
                fmt::format("box of {} nodes, period {}, z0 = {}", piece.box, piece.period, piece.amplitude),
                study.cycles * piece.period, advance);
  const auto harmonics = basis.colPivHouseholderQr();
  const Eigen::VectorXd fit = harmonics.solve(force);
  const Eigen::VectorXd fit_carried = harmonics.solve(carried);
  const double velocity = piece.amplitude * omega;
  const double amplitude = std::hypot(fit[0], fit[1]);
  return {Complex(fit[0], fit[1]) / velocity, Complex(fit_carried[0], fit_carried[1]) / velocity,
          std::sqrt((force - basis * fit).squaredNorm() / static_cast<double>(piece.period)) / amplitude,
          std::sqrt(slip) / velocity};
}

/// Of a cylinder filled with fluid: outside, and what is carried along inside.
Complex unbounded(double radius, double omega, double viscosity) {
  return analytic::oscillating_cylinder_force(radius, omega, viscosity) +
         Complex(0.0, omega) * std::numbers::pi * radius * radius;
}

/// Velocity that the box gives back per force: of the images, and of the sound that the fluid carries.
Complex answer_of_box(double radius, double side, double omega, double viscosity) {
  return analytic::backflow_of_images(side, omega, viscosity) +
         analytic::compression_of_box(side, radius, omega, fluid::sound_speed_squared);
}

/// In a periodic box, to first order in what it gives back.
Complex in_box(double radius, double side, double omega, double viscosity) {
  const Complex alone = unbounded(radius, omega, viscosity);
  return alone / (1.0 + alone * answer_of_box(radius, side, omega, viscosity));
}

double omega_of(const Piece& piece) { return 2.0 * std::numbers::pi / static_cast<double>(piece.period); }

double fitted_radius(const Rod& study, const Piece& piece, const Answer& seen) {
  const double nu = fluid::viscosity(study.fluid.relaxation_time);
  const auto side = static_cast<double>(piece.box);
  const auto excess = [&](double radius) {
    return std::abs(in_box(radius, side, omega_of(piece), nu)) - std::abs(seen.force / seen.carried);
  };
  const double low = 0.5 * study.radius, high = 2.0 * study.radius;
  if (excess(low) > 0.0 || excess(high) < 0.0) {
    throw NumericalFailure(
        fmt::format("the force's amplitude, {} per velocity, is that of no radius from {} to {}",
                    std::abs(seen.force / seen.carried), low, high));
  }
  return bracketed_root(excess, low, high);
}

std::vector<Piece> pieces_of(const Rod& study) {
  std::vector<Piece> pieces;  // the largest box first: it takes longest
  for (auto box = study.boxes.rbegin(); box != study.boxes.rend(); ++box) {
    for (const std::int64_t period : study.periods)
      pieces.push_back({*box, period, study.amplitudes.front()});
  }
  for (std::size_t i = 1; i < study.amplitudes.size(); ++i) {
    pieces.push_back({study.boxes.back(), study.periods.front(), study.amplitudes[i]});
  }
  return pieces;
}

/// What was measured before one of the pieces broke off.
Record forces_of(const std::vector<Piece>& pieces, const std::vector<std::optional<Answer>>& answers) {
  Record record{"rod_forces",
                "Force that keeps the rod moving, of the pieces that came to their end",
                {{"box", "", "L", "side of the periodic box", {}},
                 {"period", "", "T", "", {}},
                 {"amplitude", "z0", "L", "", {}},
                 {"force", "", "M L^-1 T^-1", "amplitude per velocity and length", {}},
                 {"phase", "", "1", "before the velocity [rad]", {}}}};
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (!answers[i]) continue;
    record.append({static_cast<double>(pieces[i].box), static_cast<double>(pieces[i].period),
                   pieces[i].amplitude, std::abs(answers[i]->force), std::arg(answers[i]->force)});
  }
  return record;
}

Observations rod_observations(const Rod& study) {
  Observations all;
  all.records = {
      {"rod",
       "Force per velocity of the fluid at the rod, over that of Stokes' cylinder of the fitted radius",
       {{"box", "", "L", "side of the periodic box", {}},
        {"period", "", "T", "", {}},
        {"amplitude", "z0", "L", "", {}},
        {"ratio_unbounded", "", "1", "amplitude over that in an unbounded fluid", {}},
        {"lead_unbounded", "", "1", "phase before that in an unbounded fluid [rad]", {}},
        {"ratio", "", "1", "amplitude over that in the box, with images and sound", {}},
        {"lead", "", "1", "phase before that in the box [rad]", {}},
        {"slip", "", "1", "of sum f c + g/2 over the largest velocity", {}},
        {"carried", "", "1", "amplitude of the fluid's velocity at the markers over the rod's", {}},
        {"residual", "", "1", "what is not the first harmonic, over its amplitude", {}}}}};
  all.metrics = {
      {"radius", {}, "L", "fitted to the amplitude at the first period in the largest box"},
      {"offset", {}, "L", "fitted radius beyond the section's nominal one"},
      {"lead", {}, "1", "phase before theory where the radius is fitted [rad]"},
      {"amplitude_error", {}, "1", "largest, of the amplitudes against theory for the box"},
      {"phase_error", {}, "1", "largest, of the phases [rad]"},
      {"box_effect", {}, "1", "complex distance from the unbounded fluid, largest box"},
      {"inside_mass",
       {},
       "1",
       "inertia beside that of the fluid outside, over pi a^2; where the radius is fitted"},
      {"carried",
       {},
       "1",
       "amplitude of the fluid's velocity at the markers over the rod's, where the radius is fitted"},
      {"slip", {}, "1", "of sum f c + g/2 over the largest velocity"},
      {"residual", {}, "1", "largest, of small amplitudes: what is not the first harmonic"}};
  for (std::size_t i = 1; i < study.amplitudes.size(); ++i) {
    all.metrics.push_back(
        {fmt::format("large_ratio_{}", i),
         {},
         "1",
         fmt::format("amplitude of the force over theory at z0 = {}", study.amplitudes[i])});
  }
  return all;
}

void run_rod(const Rod& study, Observations& seen, Progress& progress) {
  const std::vector<Piece> pieces = pieces_of(study);
  std::vector<std::optional<Answer>> answers(pieces.size());
  try {
    for_all(pieces.size(), "oscillations", progress,
            [&](std::size_t i) { answers[i] = oscillate(study, pieces[i]); });
  } catch (const NumericalFailure&) {
    seen.records.push_back(forces_of(pieces, answers));
    throw;
  }
  std::vector<Answer> found;
  for (const std::optional<Answer>& answer : answers) found.push_back(*answer);

  const double radius = fitted_radius(study, pieces.front(), found.front());
  const double nu = fluid::viscosity(study.fluid.relaxation_time);
  Record& record = seen.open("rod");
  double worst_ratio = 0.0, worst_lead = 0.0, residual = 0.0;
  const std::size_t linear = study.boxes.size() * study.periods.size();
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Complex force = found[i].force / found[i].carried;
    const Complex free = force / unbounded(radius, omega_of(pieces[i]), nu);
    const Complex boxed = force / in_box(radius, static_cast<double>(pieces[i].box), omega_of(pieces[i]), nu);
    record.append({static_cast<double>(pieces[i].box), static_cast<double>(pieces[i].period),
                   pieces[i].amplitude, std::abs(free), std::arg(free), std::abs(boxed), std::arg(boxed),
                   found[i].slip, std::abs(found[i].carried), found[i].residual});
    if (i >= linear) continue;
    worst_ratio = worse(worst_ratio, std::abs(std::abs(boxed) - 1.0));
    worst_lead = worse(worst_lead, std::abs(std::arg(boxed)));
    residual = worse(residual, found[i].residual);
  }
  const double omega = omega_of(pieces.front());
  const Complex first = found.front().force / found.front().carried;
  const Complex alone =
      first / (1.0 - first * answer_of_box(radius, static_cast<double>(pieces.front().box), omega, nu));
  const double inside = (alone - analytic::oscillating_cylinder_force(radius, omega, nu)).imag() / omega /
                        (std::numbers::pi * radius * radius);

  seen.set("radius", radius);
  seen.set("offset", radius - study.radius);
  seen.set("lead", record.find("lead")->values.front());
  seen.set("amplitude_error", worst_ratio);
  seen.set("phase_error", worst_lead);
  seen.set("box_effect", std::abs(first / unbounded(radius, omega, nu) - 1.0));
  seen.set("inside_mass", inside);
  seen.set("carried", std::abs(found.front().carried));
  seen.set("slip", found.front().slip);
  seen.set("residual", residual);
  for (std::size_t i = linear; i < pieces.size(); ++i)
    seen.set(fmt::format("large_ratio_{}", i - linear + 1), record.find("ratio")->values[i]);
}

}  // namespace

engine::Study read_rod(const io::Table& top) {
  const io::Table t = top.table("immersed");
  const Rod study{.fluid = read_fluid(top),
                  .forcing = read_forcing(top, Volume::Given),
                  .radius = read_positive(t, "radius", 2.5),
                  .boxes = read_rising(t, "boxes", 8, 4096),
                  .periods = t.integers("oscillation_periods"),
                  .amplitudes = t.numbers("amplitudes"),
                  .cycles = t.integer("periods", 2, 10000),
                  .monitor = engine::read_monitor(top)};
  if (study.periods.empty() || *std::min_element(study.periods.begin(), study.periods.end()) < 8 ||
      *std::max_element(study.periods.begin(), study.periods.end()) > max_period) {
    t.fail("oscillation_periods",
           fmt::format("none, or one of fewer than 8 or more than {} steps", max_period),
           "a step would be a large part of a period, or a period without end", "Give for example [923]");
  }
  if (study.amplitudes.empty() ||
      *std::min_element(study.amplitudes.begin(), study.amplitudes.end()) <= 0.0) {
    t.fail("amplitudes", "none, or one that is not positive", "the rod would not move",
           "Give for example [0.1]");
  }
  for (const std::int64_t box : study.boxes) {
    const double stroke = box == study.boxes.back()
                              ? *std::max_element(study.amplitudes.begin(), study.amplitudes.end())
                              : study.amplitudes.front();
    fluid::Spec slice = box_of(study, box);
    slice.grid.size[2] = unlimited;  // the rod has no ends
    const double layer =
        std::sqrt(fluid::viscosity(study.fluid.relaxation_time) *
                  static_cast<double>(*std::max_element(study.periods.begin(), study.periods.end())) /
                  std::numbers::pi);
    if (layer > max_layer * static_cast<double>(box)) {
      t.fail(
          "boxes", fmt::format("the Stokes layer is {:.4g} thick in a box of {} nodes", layer, box),
          fmt::format("images count as far as it reaches, and it reaches farther than {} boxes", max_layer),
          "Use a larger box, a smaller relaxation time or a shorter period");
    }
    engine::check_images(slice, study.forcing.delta, Vec3(2.0, 2.0, 0.0) * std::floor(study.radius),
                         {0.0, stroke, 0.0}, "the rod", t.place("boxes"));
  }
  return {.plan = engine::read_plan(
              top, {.fluid = box_of(study, study.boxes.back()),
                    .coupling = engine::read_coupling(top),
                    .exchange = "boundary nodes of a section as markers, moved across the rod's axis"}),
          .declares = rod_observations(study),
          .run = [study](Observations& seen, Progress& progress, engine::Cost&) {
            run_rod(study, seen, progress);
          }};
}

}  // namespace veriflex::measures::immersed
