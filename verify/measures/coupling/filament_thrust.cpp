#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <numeric>

#include "analytic/driven_filament.hpp"
#include "base/mutant.hpp"
#include "base/reduce.hpp"
#include "engine/check_coupling.hpp"
#include "engine/check_place.hpp"
#include "engine/read_scene.hpp"
#include "fluid/lattice.hpp"
#include "measures/coupling/marker_chain.hpp"
#include "measures/coupling/run_monitored.hpp"
#include "measures/drivers.hpp"
#include "measures/scene/scene.hpp"
#include "scene/moving_body.hpp"

// The mean force along its axis on an elastic filament that is driven at one end. A chain of nodes along x,
// each a marker, in a periodic box; a uniform force takes from the fluid what the chain gives it, so that the
// box has no mean flow. The same chain is towed through the same box, across and along: what the law needs
// beside the thrust. Two theories: that of these markers, whose mobility is known, and resistive-force theory
// of a slender body, which is published and holds to order 1/ln.

namespace veriflex::measures {

namespace {

using Eigen::Index;
using Eigen::VectorXcd;
using observe::Observations;

struct Thrust {
  scene::Scene scene;
  analytic::FilamentDrive drive;
  double amplitude;      // y0, or theta0  [L or 1]
  std::int64_t period;   // [T]
  std::int64_t periods;  // of which the last is measured
  Place node_mass;       // in the case, where an unstable coupling is reported
  observe::MonitorSpec monitor;

  const fluid::Spec& fluid() const { return *scene.fluid; }
  const scene::Body& chain() const { return scene.bodies.front(); }
  Index nodes() const { return chain().network.node_count(); }
  double length() const { return static_cast<double>(nodes() - 1); }
  double viscosity() const { return fluid::viscosity(fluid().relaxation_time); }
  double omega() const { return 2.0 * std::numbers::pi / static_cast<double>(period); }
  /// By which a marker is faster than the fluid around it, per force: F_int = V (u_f - u_s)  [M^-1 T].
  double slip() const { return 1.0 / chain().coupling->marker_volume; }
  double stiffness() const { return chain().material.angle_stiffness; }
  double sperm_number(double drag_across) const {
    return length() * std::pow(drag_across * omega() / stiffness(), 0.25);
  }
  /// Y of that thrust.
  double scaled(double thrust, const analytic::RodDrag& drag) const {
    const double bending_length = length() / sperm_number(drag.across);
    return thrust / ((drag.across - drag.along) * omega() * amplitude * amplitude *
                     analytic::endless_thrust(drive, bending_length));
  }
  /// In which the longest wave of the box decays ten times  [T].
  std::int64_t settling_steps() const {
    const auto& size = fluid().grid.size;
    const double side = static_cast<double>(*std::max_element(size.begin(), size.end()));
    return std::llround(10.0 * side * side / (4.0 * std::numbers::pi * std::numbers::pi * viscosity()));
  }
};

/// A fluid without a mean flow, whatever is done to it.
class HeldFluid {
 public:
  explicit HeldFluid(const fluid::Spec& spec) : fluid_(fluid::make_fluid(spec)) {
    nodes_.resize(static_cast<std::size_t>(spec.grid.count()));
    std::iota(nodes_.begin(), nodes_.end(), 0);
    force_.resize(spec.grid.count(), 3);
    part_ = {parts::Kind::UniformForce, parts::array_bytes(nodes_, force_)};
  }

  const fluid::Fluid& operator*() const { return *fluid_; }

  /// A step of the fluid and of a body in it.
  void advance(scene::MovingBody& body) {
    body.locate();
    body.interpolate(*fluid_);
    body.move();
    body.spread();
    const fluid::NodeForces reaction = body.reaction();
    force_.rowwise() = (planted(Mutant::mean_flow_not_held) ? 0.0 : 1.0) * reaction.force->colwise().sum() /
                       -static_cast<double>(force_.rows());
    for (std::size_t i = 0; i < reaction.nodes.size(); ++i)
      force_.row(reaction.nodes[i]) += reaction.force->row(static_cast<Index>(i));
    fluid_->collide_and_stream({nodes_, &force_});
  }

 private:
  std::unique_ptr<fluid::Fluid> fluid_;
  std::vector<std::int64_t> nodes_;
  Positions force_;
  parts::Built part_;
};

/// Drag per length of the chain that is towed along an axis, once its flow is steady  [M L^-1 T^-1].
double towed(const Thrust& study, int axis) {
  constexpr double speed = 1e-4;
  scene::Body body = study.chain();
  body.motion = scene::Motion{.velocity = speed * Vec3::Unit(axis)};
  HeldFluid fluid(study.fluid());
  scene::MovingBody chain(std::move(body), &study.fluid());
  run_monitored(*fluid, study.monitor, "the towed chain", study.settling_steps(),
                [&](std::int64_t) { fluid.advance(chain); });
  return -chain.exchanged().col(axis).sum() / (speed * static_cast<double>(study.nodes()));
}

/// What is seen of a period.
struct Period {
  double thrust;   // mean force on the chain towards its driven end  [M L T^-2]
  VectorXcd wave;  // first harmonic: Re[wave exp(i omega t)]  [L]
};

/// From the periodic motion that theory says, so that the modes of a soft filament, which decay in many
/// periods, are not started.
scene::Body started(const Thrust& study, const VectorXcd& shape) {
  scene::Body body = study.chain();
  body.start = {Positions::Zero(study.nodes(), 3), Positions::Zero(study.nodes(), 3)};
  body.start.displacement.col(2) = study.amplitude * shape.imag();
  body.start.velocity.col(2) = study.amplitude * study.omega() * shape.real();
  return body;
}

std::vector<Period> run_periods(const Thrust& study, const VectorXcd& shape) {
  const double per_step = 1.0 / static_cast<double>(study.period);
  HeldFluid fluid(study.fluid());
  scene::MovingBody chain(started(study, shape), &study.fluid());
  std::vector<Period> seen;
  run_monitored(*fluid, study.monitor, "the filament", study.periods * study.period, [&](std::int64_t step) {
    if (step % study.period == 0) seen.push_back({0.0, VectorXcd::Zero(study.nodes())});
    fluid.advance(chain);
    Period& now = seen.back();
    now.thrust -= per_step * chain.exchanged().col(0).sum();
    const std::complex<double> back = std::polar(
        2.0 * per_step,
        -study.omega() * static_cast<double>(step + (planted(Mutant::harmonic_a_step_early) ? 0 : 1)));
    now.wave += back * chain.solid().displacement().col(2);
  });
  return seen;
}

analytic::DrivenChain chain_of(const Thrust& study) {
  const fluid::Spec& spec = study.fluid();
  analytic::DrivenChain chain{
      .drive = study.drive,
      .steady = analytic::line_mobility(spec.grid, spec.relaxation_time, study.nodes()),
      .mobility =
          analytic::oscillating_line_mobility(spec.grid, spec.relaxation_time, study.nodes(), study.omega()),
      .omega = study.omega(),
      .angle_stiffness = study.stiffness(),
      .node_mass = study.chain().conditions.node_mass};
  chain.steady.along[0] += study.slip();
  chain.steady.across[0] += study.slip();
  chain.mobility.across[0] += study.slip();
  return chain;
}

/// Y by Sp: of slender bodies, and of this chain with its drive.
void record_law(const Thrust& study, analytic::DrivenChain chain, observe::Record& record) {
  const analytic::RodDrag drag = analytic::towed_drags(chain.steady);
  for (int eighths = 4; eighths <= 64; ++eighths) {
    const double sperm_number = 0.125 * eighths, bending_length = study.length() / sperm_number;
    chain.angle_stiffness = drag.across * chain.omega * std::pow(bending_length, 4);
    const double endless =
        (drag.across - drag.along) * chain.omega * analytic::endless_thrust(study.drive, bending_length);
    std::vector<double> row{sperm_number};
    for (const auto& drive : analytic::filament_drives)
      row.push_back(analytic::slender_thrust(drive.value, sperm_number));
    row.push_back(analytic::stroke_of(chain).thrust / endless);
    record.append(row);
  }
}

Observations filament_thrust_observations() {
  return {
      .records = {{"thrust_stroke",
                   "First harmonic of the driven filament, over the drive",
                   {{"place", "s/L", "1", "along the filament from its driven end", {}},
                    {"with", "", "1", "displacement when the drive is at its most", {}},
                    {"after", "", "1", "a quarter of a period later", {}},
                    {"with_theory", "", "1", "the first, of the chain of markers", {}},
                    {"after_theory", "", "1", "the second, of the chain of markers", {}}}},
                  {"thrust_law",
                   "Y: thrust over that of an endless filament",
                   {{"sperm_number", "Sp", "1", "L (xi_perp omega/B)^(1/4)", {}},
                    {"hinged", "", "1", "slender body, to order 1/ln, displaced and free to turn", {}},
                    {"clamped", "", "1", "slender body displaced without turning", {}},
                    {"angle", "", "1", "slender body turned", {}},
                    {"markers",
                     "",
                     "1",
                     "chain of markers in this box, at this frequency and with this drive",
                     {}}}}},
      .metrics = {
          {"coupling_growth", {}, "1", "largest factor a step of the linearised coupling"},
          {"thrust", {}, "M L T^-2", "mean force towards the driven end, over the last period"},
          {"thrust_markers", {}, "M L T^-2", "the same of the chain of markers in this box, by theory"},
          {"thrust_error", {}, "1", "distance of these two, over the thrust of an endless filament"},
          {"thrust_change", {}, "1", "of the mean from the period before, over it"},
          {"scaled_thrust", {}, "1", "Y: thrust over that of an endless filament with the towed drags"},
          {"scaled_thrust_markers", {}, "1", "the same of the chain of markers, by theory"},
          {"scaled_thrust_slender", {}, "1", "the same of a slender body, to order 1/ln"},
          {"stroke_error",
           {},
           "1",
           "largest distance of the first harmonic from that of the chain's theory, over its largest"},
          {"drag_across", {}, "M L^-1 T^-1", "xi_perp: per node and speed, towed through the same box"},
          {"drag_along", {}, "M L^-1 T^-1", "xi_par: the same along the filament"},
          {"drag_across_markers", {}, "M L^-1 T^-1", "xi_perp of the chain of markers, by theory"},
          {"drag_along_markers", {}, "M L^-1 T^-1", "xi_par of the chain of markers, by theory"},
          {"drag_error", {}, "1", "distance of the towed drags from these two, the larger, over them"},
          {"drag_across_slender", {}, "M L^-1 T^-1", "4 pi mu/(ln(L/a) + 1/2)"},
          {"drag_along_slender", {}, "M L^-1 T^-1", "2 pi mu/(ln(L/a) - 1/2)"},
          {"marker_radius", {}, "L", "a: of a sphere that moves as one marker does by a force, slip and all"},
          {"sperm_number", {}, "1", "Sp = L (xi_perp omega/B)^(1/4), with the towed drag"},
          {"period", {}, "T", "2 pi L^2/(Re nu), in whole steps"}}};
}

void run_filament_thrust(const Thrust& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  double coupling_growth = 0.0;
  engine::check_coupling(study.fluid(), study.chain(), "the filament", study.node_mass, coupling_growth,
                         progress);
  seen.set("coupling_growth", coupling_growth);
  cost.finish("stability of the coupling");

  const double square = study.amplitude * study.amplitude;
  const analytic::DrivenChain chain = chain_of(study);
  const analytic::ChainStroke stroke = analytic::stroke_of(chain);
  const analytic::RodDrag of_markers = analytic::towed_drags(chain.steady);
  const double radius = analytic::marker_radius(study.fluid().relaxation_time, study.slip());
  const analytic::RodDrag slender = analytic::slender_drags(radius / study.length());
  const double mu = study.viscosity();
  seen.set("thrust_markers", square * stroke.thrust);
  seen.set("scaled_thrust_markers", study.scaled(square * stroke.thrust, of_markers));
  seen.set("drag_across_markers", of_markers.across);
  seen.set("drag_along_markers", of_markers.along);
  seen.set("drag_across_slender", mu * slender.across);
  seen.set("drag_along_slender", mu * slender.along);
  seen.set("marker_radius", radius);
  seen.set("period", static_cast<double>(study.period));
  record_law(study, chain, seen.open("thrust_law"));
  cost.finish("theory");

  const analytic::RodDrag drag{towed(study, 2), towed(study, 0)};
  const double sperm_number = study.sperm_number(drag.across);
  seen.set("drag_across", drag.across);
  seen.set("drag_along", drag.along);
  seen.set("drag_error", std::max(std::abs(drag.across / of_markers.across - 1.0),
                                  std::abs(drag.along / of_markers.along - 1.0)));
  seen.set("sperm_number", sperm_number);
  seen.set("scaled_thrust_slender", analytic::slender_thrust(study.drive, sperm_number));
  cost.finish("towed");

  const std::vector<Period> periods = run_periods(study, stroke.shape);
  const double thrust = periods.back().thrust;
  seen.set("thrust", thrust);
  seen.set("thrust_error", std::abs(study.scaled(thrust - square * stroke.thrust, of_markers)));
  seen.set("thrust_change", 1.0 - periods[periods.size() - 2].thrust / thrust);
  seen.set("scaled_thrust", study.scaled(thrust, drag));
  cost.finish("driven");

  // The drive, a sin(omega t), is Re[-i a exp(i omega t)].
  const VectorXcd wave = periods.back().wave / std::complex<double>(0.0, -study.amplitude);
  seen.set("stroke_error", largest_magnitude(wave - stroke.shape) / largest_magnitude(stroke.shape));
  observe::Record& record = seen.open("thrust_stroke");
  for (Index i = 0; i < wave.size(); ++i) {
    record.append({static_cast<double>(i) / study.length(), wave[i].real(), -wave[i].imag(),
                   stroke.shape[i].real(), -stroke.shape[i].imag()});
  }
}

}  // namespace

engine::Study read_filament_thrust(const io::Table& top) {
  const io::Table t = top.table("filament_thrust");
  const fluid::Spec spec = engine::read_fluid(top);
  check_empty_box(top, spec);
  Thrust study{
      .scene = {.fluid = spec, .bodies = {read_marker_chain(top, t, spec)}},
      .drive =
          row_named(analytic::filament_drives, t.choice("drive", names_of(analytic::filament_drives))).value,
      .amplitude = engine::need_positive(t, "amplitude", t.number("amplitude")),
      .period = 0,
      .periods = t.integer("periods", 2, 1000),
      .node_mass = t.place("node_mass"),
      .monitor = engine::read_monitor(top)};
  const double reynolds = engine::need_positive(t, "reynolds", t.number("reynolds"));
  study.period = engine::whole_steps(
      2.0 * std::numbers::pi * study.length() * study.length() / (reynolds * study.viscosity()), 100.0,
      "a period takes", t.place("reynolds"));
  scene::Body& filament = study.scene.bodies.front();
  filament.material.angle_stiffness = study.viscosity() * study.omega() * std::pow(study.length(), 4) /
                                      engine::need_positive(t, "elastoviscous", t.number("elastoviscous"));
  filament.conditions.fixed = solid::FixedDofs::Constant(study.nodes(), 3, false);
  filament.conditions.fixed.row(0).setConstant(true);
  filament.conditions.drive = solid::Drive{.nodes = analytic::driven_markers(study.drive),
                                           .axis = 2,
                                           .amplitude = study.amplitude,
                                           .omega = study.omega(),
                                           .ramp = 0.0};
  // The free end may swing out twice as far as a driven one, and as far as the filament is turned.
  const double reach = study.drive == analytic::FilamentDrive::Angle ? study.length() : 2.0;
  engine::check_images(spec, filament.coupling->delta, {study.length(), 0.0, 0.0},
                       {0.0, 0.0, reach * study.amplitude}, "the filament",
                       top.table("fluid").place("nodes"));
  scene::Plan plan = plan_of(top, study.scene);
  scene::put_in(plan, {"force against a mean flow",
                       "at every node, each step",
                       static_cast<double>(spec.grid.count()) * 4.0 * sizeof(double),
                       {parts::Kind::UniformForce}});
  return {.plan = std::move(plan),
          .declares = filament_thrust_observations(),
          .run = std::bind_front(run_filament_thrust, study),
          .expects = [study] {
            const std::int64_t steps = study.periods * study.period + 2 * study.settling_steps();
            return std::vector{*scene::expected_work(study.scene, steps)};
          }};
}

}  // namespace veriflex::measures
