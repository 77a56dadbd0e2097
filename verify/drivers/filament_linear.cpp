#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <numbers>

#include "drivers/beam_section.hpp"
#include "drivers/drivers.hpp"
#include "drivers/filament_case.hpp"
#include "drivers/filament_compare.hpp"
#include "drivers/filament_guard.hpp"
#include "engine/analytic/immersed.hpp"
#include "engine/read_scene.hpp"

// The driven filament at small amplitude against linear theory: a Timoshenko beam with the lattice's own
// stiffness, the inertia of its nodes and of the fluid inside, and Stokes' drag of an oscillating cylinder;
// and against steady resistive-force theory, which leaves out inertia and the age of the flow.

namespace veriflex::drivers {

namespace {

using Complex = std::complex<double>;
using observe::Observations;
using observe::Record;

struct Beam {
  double bending;  // B   [M L^3 T^-2]
  double shear;    // GA  [M L T^-2]
  double length;
  double spacing;  // of the sections, whose mass and drag are lumped there
};

/// w(s)/w(length) at the sections of a beam whose free end is at s = 0, pinned and moved as Re[exp(i omega
/// t)] at the other, where a section w loads the beam by P w per length, P = omega^2 m - i omega Z:
///   GA (w' - theta)' = - P w,   B theta'' + GA (w' - theta) = 0,
/// so that w = sum of exp(lambda s) with lambda^4 + P/GA lambda^2 - P/B = 0. Half a section's load stands
/// beyond the free end.
std::vector<Complex> shape_of(const Beam& beam, Complex load, Eigen::Index sections) {
  const Complex p = load / beam.shear;
  const Complex root = std::sqrt(0.25 * p * p + load / beam.bending);
  const std::array<Complex, 2> squares{-0.5 * p + root, -0.5 * p - root};
  Eigen::Vector4cd lambda;
  lambda << std::sqrt(squares[0]), -std::sqrt(squares[0]), std::sqrt(squares[1]), -std::sqrt(squares[1]);
  const auto wave = [&](Eigen::Index i, double s) {  // of modulus one at most
    return std::exp(lambda[i] * (lambda[i].real() > 0.0 ? s - beam.length : s));
  };
  Eigen::Matrix4cd conditions;
  for (Eigen::Index i = 0; i < 4; ++i) {
    const Complex curvature = lambda[i] * lambda[i] + p;  // theta'
    const Complex shear_force = -load / lambda[i];        // GA (w' - theta)
    conditions(0, i) = curvature * wave(i, 0.0);
    conditions(1, i) = (shear_force + 0.5 * beam.spacing * load) * wave(i, 0.0);
    conditions(2, i) = curvature * wave(i, beam.length);
    conditions(3, i) = wave(i, beam.length);
  }
  const Eigen::Vector4cd amplitude = conditions.fullPivLu().solve(Eigen::Vector4cd{0.0, 0.0, 0.0, 1.0});
  std::vector<Complex> shape;
  for (Eigen::Index s = 0; s < sections; ++s) {
    Complex w = 0.0;
    for (Eigen::Index i = 0; i < 4; ++i) w += amplitude[i] * wave(i, static_cast<double>(s) * beam.spacing);
    shape.push_back(w);
  }
  return shape;
}

/// Load of unit displacement on a filament of nodes that carry `solid_mass` per length and are filled with
/// fluid up to the radius at which the fluid outside feels them.
Complex unsteady_load(double solid_mass, double radius, double omega, double viscosity) {
  const double mass = solid_mass + std::numbers::pi * radius * radius;
  return omega * omega * mass -
         Complex(0.0, omega) * engine::oscillating_cylinder_force(radius, omega, viscosity);
}

/// Steady drag of a slender rod across its axis, 4 pi mu/(ln(L/r) + 1/2), and no inertia.
///                                                                        [wiggins-goldstein-1998]
Complex resistive_load(double length, double radius, double omega, double viscosity) {
  return Complex(0.0, -omega) * 4.0 * std::numbers::pi * viscosity / (std::log(length / radius) + 0.5);
}

/// First harmonic of z over the last period, over that of the drive, z0 sin(omega t) = Re[-i z0 exp(i omega
/// t)].
std::vector<Complex> first_harmonic(const StrokeResult& seen, double z0) {
  const std::size_t first = seen.lines.size() - phases_per_period;
  std::vector<Complex> shape(static_cast<std::size_t>(seen.lines[first].rows()));
  for (std::size_t k = 0; k < phases_per_period; ++k) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(k + 1) / phases_per_period;
    const Complex back = std::polar(2.0 / phases_per_period, -angle) / Complex(0.0, -z0);
    for (std::size_t s = 0; s < shape.size(); ++s)
      shape[s] += back * seen.lines[first + k](static_cast<Eigen::Index>(s), 2);
  }
  return shape;
}

double distance(const std::vector<Complex>& a, const std::vector<Complex>& b) {
  double most = 0.0;
  for (std::size_t s = 0; s < a.size(); ++s) most = std::max(most, std::abs(a[s] - b[s]));
  return most;
}

struct LinearStudy {
  Stroke stroke;
  bond::AnyLaw compared;
  double hydrodynamic_radius;
};

/// The radius that fits best, to a thousandth of a spacing.
double best_radius(const Beam& beam, double solid_mass, double omega, double viscosity,
                   const std::vector<Complex>& measured) {
  double best = 0.0;
  double least = INFINITY;
  const auto sections = static_cast<Eigen::Index>(measured.size());
  for (double radius = 1.0; radius < 6.0; radius += 1e-3) {
    const double off =
        distance(measured, shape_of(beam, unsteady_load(solid_mass, radius, omega, viscosity), sections));
    if (off < least) {
      least = off;
      best = radius;
    }
  }
  return best;
}

Observations run(const LinearStudy& study, Progress& progress, engine::Cost& cost) {
  const Stroke& stroke = study.stroke;
  Stroke other = stroke;
  other.law = study.compared;
  const double growth = check_strokes({stroke, other}, progress);
  cost.finish("stability of the coupling");
  const StrokeResult a = run_guarded(stroke, bond::name_of(stroke.law), growth, progress);
  cost.finish(bond::name_of(stroke.law), parts_of(a.seconds));
  const StrokeResult b = run_guarded(other, bond::name_of(study.compared), growth, progress);
  cost.finish(bond::name_of(study.compared) + " compared", parts_of(b.seconds));

  const scene::SolidSpec spec{.shape = stroke.rod, .angle_stiffness = stroke.angle_stiffness};
  const BeamSection section = section_of({stroke.law, stroke.angle_stiffness}, spec, stroke.rod.spacing);
  const Beam beam{section.bending(), shear_factor(spec) * section.shear, stroke.length(), stroke.rod.spacing};
  const double viscosity = fluid::viscosity(stroke.fluid.relaxation_time);
  const double omega = stroke.omega();
  const double solid_mass = section.nodes * stroke.node_mass / stroke.rod.spacing;
  const auto sections = static_cast<Eigen::Index>(stroke.rod.sections);

  const std::vector<Complex> measured = first_harmonic(a, stroke.amplitude);
  const std::vector<Complex> compared = first_harmonic(b, stroke.amplitude);
  const auto theory = [&](double radius) {
    return shape_of(beam, unsteady_load(solid_mass, radius, omega, viscosity), sections);
  };
  const std::vector<Complex> linear = theory(study.hydrodynamic_radius);
  const std::vector<Complex> resistive =
      shape_of(beam, resistive_load(stroke.length(), stroke.rod.radius, omega, viscosity), sections);
  const double fitted = best_radius(beam, solid_mass, omega, viscosity, measured);

  Record record{"first_harmonic",
                "First harmonic of the stroke along the filament, over the drive",
                {{"section", "", "1", "0 at the free end", {}},
                 {"amplitude", "|W|", "1", "measured, law of [bond]", {}},
                 {"phase", "arg W", "rad", "of the same", {}},
                 {"amplitude_compared", "", "1", "measured, law of [compared_bond]", {}},
                 {"phase_compared", "", "rad", "of the same", {}},
                 {"amplitude_linear", "", "1", "beam, inertia, Stokes' oscillating cylinder", {}},
                 {"phase_linear", "", "rad", "of the same", {}},
                 {"amplitude_resistive", "", "1", "beam in steady resistive-force theory", {}},
                 {"phase_resistive", "", "rad", "of the same", {}}}};
  // Phases run on beyond pi from the driven end, where they are zero.
  std::vector<std::array<double, 4>> phases(static_cast<std::size_t>(sections));
  std::array<double, 4> last{};
  for (std::size_t s = phases.size(); s-- > 0;) {
    const std::array<Complex, 4> w{measured[s], compared[s], linear[s], resistive[s]};
    for (std::size_t i = 0; i < 4; ++i)
      last[i] += std::remainder(std::arg(w[i]) - last[i], 2.0 * std::numbers::pi);
    phases[s] = last;
  }
  for (std::size_t s = 0; s < phases.size(); ++s) {
    record.append({static_cast<double>(s), std::abs(measured[s]), phases[s][0], std::abs(compared[s]),
                   phases[s][1], std::abs(linear[s]), phases[s][2], std::abs(resistive[s]), phases[s][3]});
  }
  Observations seen;
  seen.records = {record};
  seen.metrics = {
      {"linear_error", distance(measured, linear), "1",
       "max |W - W of linear theory| along the filament, law of [bond]"},
      {"linear_error_compared", distance(compared, linear), "1", "the same, law of [compared_bond]"},
      {"resistive_error", distance(measured, resistive), "1", "the same for steady resistive-force theory"},
      {"law_distance", distance(measured, compared), "1", "max |W - W| between the two laws"},
      {"fitted_radius", fitted, "L", "hydrodynamic radius with which linear theory comes nearest"},
      {"fitted_error", distance(measured, theory(fitted)), "1", "linear_error with that radius"},
      {"tip_amplitude", std::abs(measured.front()), "1", "|W| at the free end, measured"},
      {"tip_amplitude_linear", std::abs(linear.front()), "1", "the same in linear theory"},
      {"bending_stiffness", beam.bending, "M L^3 T^-2", "B of the lattice"},
      {"shear_stiffness", beam.shear, "M L T^-2", "kappa GA of the lattice"},
      {"mass", solid_mass + std::numbers::pi * study.hydrodynamic_radius * study.hydrodynamic_radius,
       "M L^-1", "per length: the nodes' and that of the fluid inside the hydrodynamic radius"},
      {"period_change", change_over_last_period(a, stroke.amplitude), "1",
       "max |d|/z0 from the period before, law of [bond]"},
      {"dt_over_limit", std::max(step_over_limit(stroke), step_over_limit(other)), "1",
       "sub-step over the linear limit 2/omega_max at rest"},
      metric_of(growth)};
  return seen;
}

}  // namespace

engine::Study read_filament_linear(const io::Section& top) {
  LinearStudy study{read_stroke(top), engine::read_law(top, "compared_bond"),
                    top.table("linear").number("hydrodynamic_radius")};
  if (!(study.hydrodynamic_radius > 0.0)) {
    top.table("linear").fail("hydrodynamic_radius", fmt::format("it is {}", study.hydrodynamic_radius),
                             "it must be positive", "It is near the radius of the rod");
  }
  return {.plan = plan_stroke(top, study.stroke),
          .measures = {"linear_error", "linear_error_compared", "resistive_error", "law_distance",
                       "fitted_radius", "fitted_error", "tip_amplitude", "tip_amplitude_linear",
                       "bending_stiffness", "shear_stiffness", "mass", "period_change", "dt_over_limit",
                       "coupling_growth", "first_harmonic.amplitude", "first_harmonic.phase"},
          .run = [study](Progress& progress, engine::Cost& cost) { return run(study, progress, cost); }};
}

}  // namespace veriflex::drivers
