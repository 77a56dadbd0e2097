#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>

#include "analytic/immersed.hpp"
#include "analytic/stokeslet_rings.hpp"
#include "base/reduce.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/filament/filament_case.hpp"
#include "measures/filament/filament_compare.hpp"
#include "measures/filament/filament_guard.hpp"
#include "measures/solid/beam_section.hpp"
#include "scene/markers.hpp"

// The driven filament at small amplitude against linear theory: a Timoshenko beam with the lattice's own
// stiffness and the inertia of its nodes, in unsteady Stokes flow. Its drag is taken from sections that feel
// each other's flow; section by section from Stokes' oscillating cylinder, which knows nothing of the wave
// along the filament; and from steady resistive-force theory, which leaves out inertia and the age of the
// flow too.

namespace veriflex::measures {

namespace {

using Complex = std::complex<double>;
using observe::Observations;

struct Beam {
  double bending;  // B         [M L^3 T^-2]
  double shear;    // kappa GA  [M L T^-2]
  double spacing;  // of the sections, whose mass and drag are lumped there
  Eigen::Index sections;
};

using Shape = Eigen::VectorXcd;  // displacement of the sections from the free end on, over that of the drive

/// The sections of a beam that is pinned and moved as Re[exp(i omega t)] at its last one and free at the
/// first: deflections w and rotations theta with energy B/2 sum (dtheta)^2/h + kappa GA/2 sum h (dw/h -
/// theta)^2, a mass per section, and `drag` that gives the forces on the fluid from the velocities of all
/// sections.
Shape shape_of(const Beam& beam, double omega, double mass, const Eigen::MatrixXcd& drag) {
  const Eigen::Index n = beam.sections;
  Eigen::MatrixXcd k = Eigen::MatrixXcd::Zero(2 * n, 2 * n);
  for (Eigen::Index i = 0; i + 1 < n; ++i) {
    Eigen::VectorXcd bent = Eigen::VectorXcd::Zero(2 * n);
    Eigen::VectorXcd sheared = bent;
    bent[n + i] = -1.0;
    bent[n + i + 1] = 1.0;
    sheared[i] = -1.0 / beam.spacing;
    sheared[i + 1] = 1.0 / beam.spacing;
    sheared[n + i] = sheared[n + i + 1] = -0.5;
    k += beam.bending / beam.spacing * bent * bent.transpose();
    k += beam.shear * beam.spacing * sheared * sheared.transpose();
  }
  k.topLeftCorner(n, n) += Complex(0.0, omega) * drag;
  k.topLeftCorner(n, n).diagonal().array() -= omega * omega * mass;
  // The driven section is known: its row becomes w = 1.
  k.row(n - 1).setZero();
  k(n - 1, n - 1) = 1.0;
  const Eigen::VectorXcd load = Eigen::VectorXcd::Unit(2 * n, n - 1);
  return k.partialPivLu().solve(load).head(n);
}

/// What answers the motion of a filament of that radius.
struct Surroundings {
  double radius;      // hydrodynamic  [L]
  double resistance;  // force per section and slip, fluid's velocity sum f c + g/2  [M T^-1]
  double omega;
  double viscosity;
};

/// Each section as a piece of an endless rod that moves evenly. The fluid inside moves with the fluid at the
/// markers, which stays behind the markers by the slip that direct forcing needs: both resistances stand one
/// behind the other.
Eigen::MatrixXcd drag_of_cylinder(const Beam& beam, const Surroundings& around) {
  const Complex i_omega(0.0, around.omega);
  const Complex fluid =
      beam.spacing * (analytic::oscillating_cylinder_force(around.radius, around.omega, around.viscosity) +
                      i_omega * std::numbers::pi * around.radius * around.radius);
  const Complex felt = 1.0 / (1.0 / fluid + 1.0 / around.resistance);
  return felt * Eigen::MatrixXcd::Identity(beam.sections, beam.sections);
}

/// All sections as rings of forces in the flow of each other: what an endless rod that moves evenly misses
/// when the layer of fluid that a section moves is as thick as a fair part of the wave is long.
Eigen::MatrixXcd drag_of_rings(const Beam& beam, const Surroundings& around) {
  std::vector<Complex> at(static_cast<std::size_t>(beam.sections));
  for (std::size_t k = 0; k < at.size(); ++k) {
    at[k] = analytic::ring_on_ring(static_cast<double>(k) * beam.spacing, around.radius, beam.spacing,
                                   around.omega, around.viscosity);
  }
  Eigen::MatrixXcd answer(beam.sections, beam.sections);
  for (Eigen::Index i = 0; i < beam.sections; ++i) {
    for (Eigen::Index j = 0; j < beam.sections; ++j)
      answer(i, j) = at[static_cast<std::size_t>(std::abs(i - j))];
    answer(i, i) += 1.0 / around.resistance;
  }
  return answer.inverse();
}

/// Steady drag of a slender rod across its axis, 4 pi mu/(ln(L/r) + 1/2) per length.
///                                                                        [wiggins-goldstein-1998]
Eigen::MatrixXcd drag_of_slender_rod(const Beam& beam, double radius, double viscosity) {
  const double length = static_cast<double>(beam.sections - 1) * beam.spacing;
  const double drag = beam.spacing * 4.0 * std::numbers::pi * viscosity / (std::log(length / radius) + 0.5);
  return Complex(drag) * Eigen::MatrixXcd::Identity(beam.sections, beam.sections);
}

/// F = V (u_s - u) for each of the markers of a section, u without half of what the force itself adds, S/2 of
/// it when all markers push alike: resistance = N V/(1 - S V/2) [M T^-1].
double resistance_of(const Stroke& stroke) {
  const scene::Body body = body_of(stroke);
  const scene::CouplingSpec& coupling = *body.coupling;
  const std::vector<std::int32_t> coupled = scene::coupled_nodes(body);
  Positions markers(static_cast<Eigen::Index>(coupled.size()), 3);
  std::vector<Eigen::Index> middle;  // section
  const double along = std::floor(0.5 * static_cast<double>(stroke.rod.sections)) * stroke.rod.spacing;
  for (std::size_t i = 0; i < coupled.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    markers.row(row) = body.place.transpose() + body.network.rest.row(coupled[i]);
    if (std::abs(body.network.rest(coupled[i], 1) - along) < 0.5 * stroke.rod.spacing) middle.push_back(row);
  }
  coupling::Transfer transfer(stroke.fluid.grid, fluid::closed(stroke.fluid), coupling.delta,
                              stroke.fluid.obstacle);
  transfer.locate(markers);
  Positions spread, back;
  transfer.spread(Positions::Ones(markers.rows(), 3), spread);
  transfer.interpolate(spread, back);
  double sum = 0.0;
  for (const Eigen::Index row : middle) sum += back(row, 2);
  const auto count = static_cast<double>(middle.size());
  const double self = coupling.marker_volume * sum / count;
  return count * coupling.marker_volume / (1.0 - 0.5 * self);
}

/// First harmonic of z over the last period, over that of the drive, z0 sin(omega t) = Re[-i z0 exp(i omega
/// t)].
Shape first_harmonic(const StrokeResult& seen, double z0) {
  const std::size_t first = seen.lines.size() - phases_per_period;
  Shape shape = Shape::Zero(seen.lines[first].rows());
  for (std::size_t k = 0; k < phases_per_period; ++k) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(k + 1) / phases_per_period;
    const Complex back = std::polar(2.0 / phases_per_period, -angle) / Complex(0.0, -z0);
    shape += back * seen.lines[first + k].col(2).cast<Complex>();
  }
  return shape;
}

double distance(const Shape& a, const Shape& b) { return largest((a - b).cwiseAbs()); }

struct LinearStudy {
  Stroke stroke;
  bond::AnyLaw compared;
  double hydrodynamic_radius;
};

/// Measured with both laws, and in three theories.
using Shapes = std::array<Shape, 5>;

Observations filament_linear_observations(const LinearStudy& study) {
  Observations all;
  all.records = {{"first_harmonic",
                  "First harmonic of the stroke along the filament, over the drive",
                  {{"section", "", "1", "0 at the free end", {}},
                   {"amplitude", "|W|", "1", "measured, law of [bond]", {}},
                   {"phase", "arg W", "1", "of the same [rad]", {}},
                   {"amplitude_compared", "", "1", "measured, law of [compared_bond]", {}},
                   {"phase_compared", "", "1", "of the same [rad]", {}},
                   {"amplitude_rings", "", "1", "beam, inertia, sections in each other's unsteady flow", {}},
                   {"phase_rings", "", "1", "of the same [rad]", {}},
                   {"amplitude_cylinder", "", "1", "beam, inertia, Stokes' oscillating cylinder", {}},
                   {"phase_cylinder", "", "1", "of the same [rad]", {}},
                   {"amplitude_resistive", "", "1", "beam in steady resistive-force theory", {}},
                   {"phase_resistive", "", "1", "of the same [rad]", {}}}}};
  all.metrics = {
      growth_of_coupling(),
      {"rings_error",
       {},
       "1",
       "max |W - W of linear theory|, sections in each other's unsteady flow, law of [bond]"},
      {"rings_error_compared", {}, "1", "the same, law of [compared_bond]"},
      {"rings_error_without_slip", {}, "1", "the same theory if markers moved with the fluid, law of [bond]"},
      {"cylinder_error",
       {},
       "1",
       "max |W - W of linear theory|, Stokes' oscillating cylinder, law of [bond]"},
      {"resistive_error", {}, "1", "the same, steady resistive-force theory"},
      {"law_distance", {}, "1", "max |W - W| between the two laws"},
      {"tip_amplitude", {}, "1", "|W| at the free end, measured"},
      {"tip_amplitude_rings", {}, "1", "the same in linear theory"},
      {"resistance", {}, "M T^-1", "of direct forcing, force per section and slip"},
      {"bending_stiffness", {}, "M L^3 T^-2", "B of the lattice"},
      {"shear_stiffness", {}, "M L T^-2", "kappa GA of the lattice"},
      {"solid_mass", {}, "M", "of a section's nodes; the fluid inside is part of the flow in the theories"},
      {"dt_over_limit", {}, "1", "sub-step over the linear limit 2/omega_max at rest"}};
  if (study.stroke.periods > 1)
    all.metrics.push_back({"period_change", {}, "1", "max |d|/z0 from the period before, law of [bond]"});
  return all;
}

void record_shapes(const Shapes& shapes, observe::Record& record) {
  std::vector<std::vector<double>> rows(static_cast<std::size_t>(shapes[0].size()));
  std::array<double, 5> phase{};  // runs on beyond pi from the driven end, where it is zero
  for (Eigen::Index s = shapes[0].size() - 1; s >= 0; --s) {
    std::vector<double>& row = rows[static_cast<std::size_t>(s)];
    row.push_back(static_cast<double>(s));
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      phase[i] += std::remainder(std::arg(shapes[i][s]) - phase[i], 2.0 * std::numbers::pi);
      row.push_back(std::abs(shapes[i][s]));
      row.push_back(phase[i]);
    }
  }
  for (const std::vector<double>& row : rows) record.append(row);
}

void run_filament_linear(const LinearStudy& study, Observations& seen, Progress& progress,
                         engine::Cost& cost) {
  const Stroke& stroke = study.stroke;
  Stroke other = stroke;
  other.law = study.compared;
  check_strokes({stroke, other}, seen, progress);
  cost.finish("stability of the coupling");
  const StrokeResult a = run_guarded(stroke, bond::name_of(stroke.law), "stroke", progress);
  seen.records.push_back(history_of(a, "stroke", bond::name_of(stroke.law)));
  cost.finish(bond::name_of(stroke.law), parts_of(a.seconds));
  const StrokeResult b = run_guarded(other, bond::name_of(study.compared), "stroke_compared", progress);
  seen.records.push_back(history_of(b, "stroke_compared", bond::name_of(study.compared)));
  cost.finish(bond::name_of(study.compared) + " compared", parts_of(b.seconds));

  const scene::SolidSpec spec{.shape = stroke.rod, .angle_stiffness = stroke.angle_stiffness};
  const BeamSection section = section_of({stroke.law, stroke.angle_stiffness}, spec, stroke.rod.spacing);
  const Beam beam{section.bending(), shear_factor(spec) * section.shear, stroke.rod.spacing,
                  static_cast<Eigen::Index>(stroke.rod.sections)};
  const double viscosity = fluid::viscosity(stroke.fluid.relaxation_time);
  const double omega = stroke.omega();
  const double mass = section.nodes * stroke.node_mass;
  const Surroundings around{study.hydrodynamic_radius, resistance_of(stroke), omega, viscosity};
  Surroundings without_slip = around;
  without_slip.resistance = INFINITY;
  const Shapes shapes{first_harmonic(a, stroke.amplitude), first_harmonic(b, stroke.amplitude),
                      shape_of(beam, omega, mass, drag_of_rings(beam, around)),
                      shape_of(beam, omega, mass, drag_of_cylinder(beam, around)),
                      shape_of(beam, omega, 0.0, drag_of_slender_rod(beam, stroke.rod.radius, viscosity))};
  const auto& [measured, compared, rings, cylinder, resistive] = shapes;
  cost.finish("theory");

  record_shapes(shapes, seen.open("first_harmonic"));
  seen.set("rings_error", distance(measured, rings));
  seen.set("rings_error_compared", distance(compared, rings));
  seen.set("rings_error_without_slip",
           distance(measured, shape_of(beam, omega, mass, drag_of_rings(beam, without_slip))));
  seen.set("cylinder_error", distance(measured, cylinder));
  seen.set("resistive_error", distance(measured, resistive));
  seen.set("law_distance", distance(measured, compared));
  seen.set("tip_amplitude", std::abs(measured[0]));
  seen.set("tip_amplitude_rings", std::abs(rings[0]));
  seen.set("resistance", around.resistance);
  seen.set("bending_stiffness", beam.bending);
  seen.set("shear_stiffness", beam.shear);
  seen.set("solid_mass", mass);
  seen.set("dt_over_limit", worse(step_over_limit(stroke), step_over_limit(other)));
  if (stroke.periods > 1) seen.set("period_change", change_over_last_period(a, stroke.amplitude));
}

}  // namespace

engine::Study read_filament_linear(const io::Table& top) {
  LinearStudy study{read_stroke(top), engine::read_law(top, "compared_bond"),
                    top.table("linear").number("hydrodynamic_radius")};
  const double spacing = study.stroke.rod.spacing;
  const double most = 10.0 * (study.stroke.rod.radius + 1.0) * spacing;
  if (!(study.hydrodynamic_radius >= 0.01 * spacing) || study.hydrodynamic_radius > most) {
    top.table("linear").fail(
        "hydrodynamic_radius", fmt::format("it is {}", study.hydrodynamic_radius),
        fmt::format("sections are rings of it, and it lies between {:.3g} and {:.3g}", 0.01 * spacing, most),
        "It is near the radius of the rod");
  }
  return {.plan = plan_stroke(top, study.stroke),
          .declares = filament_linear_observations(study),
          .run = std::bind_front(run_filament_linear, study),
          .expects = [study] { return std::vector{expected_work(study.stroke, 2)}; }};
}

}  // namespace veriflex::measures
