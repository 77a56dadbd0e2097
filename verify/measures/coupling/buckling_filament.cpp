#include <fmt/format.h>
#include <gsl/gsl_fit.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

#include "analytic/straining_filament.hpp"
#include "base/error.hpp"
#include "base/root.hpp"
#include "engine/check_coupling.hpp"
#include "engine/check_place.hpp"
#include "engine/read_scene.hpp"
#include "fluid/initial.hpp"
#include "fluid/lattice.hpp"
#include "measures/coupling/marker_chain.hpp"
#include "measures/coupling/run_monitored.hpp"
#include "measures/drivers.hpp"
#include "measures/scene/scene.hpp"
#include "scene/moving_body.hpp"

// An elastic filament, free, on the axis of compression between four rolls that a body force drives. A chain
// of nodes, each a marker: its stiffness is that of its angles, its drag that of the markers. It starts a
// little bent, and the growth of its first mode is compared with two theories: that of these markers, whose
// mobility is known, and that of slender bodies, which is published and holds to order 1/ln.

namespace veriflex::measures {

namespace {

using Eigen::VectorXd;
using observe::Observations;

/// Flow between four rolls about the middle of the box, u = rate/k (-sin kx cos kz, 0, cos kx sin kz).
struct Rolls {
  Grid grid;
  double wavenumber;  // k  [L^-1]
  double rate;        // [T^-1]
  double relaxation_time;

  Vec3 velocity(std::int64_t node) const {
    const auto [x, z] = phase(node);
    return rate / wavenumber * Vec3(-std::sin(x) * std::cos(z), 0.0, std::cos(x) * std::sin(z));
  }
  fluid::Populations populations(std::int64_t node) const {
    const auto [x, z] = phase(node);
    Mat3 gradient = Mat3::Zero();  // (a, b) is du_b/dx_a
    gradient(0, 0) = -rate * std::cos(x) * std::cos(z);
    gradient(2, 0) = rate * std::sin(x) * std::sin(z);
    gradient(0, 2) = -gradient(2, 0);
    gradient(2, 2) = -gradient(0, 0);
    return fluid::near_equilibrium(1.0, velocity(node), gradient, relaxation_time);
  }

 private:
  std::array<double, 2> phase(std::int64_t node) const {
    const auto at = grid.node(node);
    return {wavenumber * static_cast<double>(at[0] - grid.size[0] / 2),
            wavenumber * static_cast<double>(at[2] - grid.size[2] / 2)};
  }
};

struct Filament {
  scene::Scene scene;
  double reynolds;   // rate L^2/nu
  double stiffness;  // k_a  [M L^2 T^-2]
  double amplitude;  // at the start  [L]
  double duration;   // rate t at the end
  Place node_mass;   // in the case, where an unstable coupling is reported
  observe::MonitorSpec monitor;

  const fluid::Spec& fluid() const { return *scene.fluid; }
  const solid::Network& network() const { return scene.bodies.front().network; }
  double length() const { return static_cast<double>(network().node_count() - 1); }
  /// By which a marker is faster than the fluid around it, per force: F_int = V (u_f - u_s)  [M^-1 T].
  double slip() const { return 1.0 / scene.bodies.front().coupling->marker_volume; }
  double viscosity() const { return fluid::viscosity(fluid().relaxation_time); }
  double rate() const { return reynolds * viscosity() / (length() * length()); }
  double wavenumber() const { return 2.0 * std::numbers::pi / static_cast<double>(fluid().grid.size[0]); }
  std::int64_t steps() const { return std::llround(duration / rate()); }
  Rolls rolls() const { return {fluid().grid, wavenumber(), rate(), fluid().relaxation_time}; }
};

constexpr double settled = 0.3;  // part of the run in which other modes and the start of the flow die away
constexpr std::int64_t samples = 200;

/// What keeps the rolls turning.
class RollForce {
 public:
  explicit RollForce(const Rolls& rolls)
      : rolls_(rolls), per_velocity_(1.0 / analytic::roll_response(rolls.wavenumber, rolls.relaxation_time)) {
    nodes_.resize(static_cast<std::size_t>(rolls.grid.count()));
    std::iota(nodes_.begin(), nodes_.end(), 0);
    force_.resize(rolls.grid.count(), 3);
    for (const std::int64_t node : nodes_) put(node);
    part_ = {parts::Kind::UniformForce, parts::array_bytes(nodes_, force_)};
  }

  /// A step of the fluid under this force and that of a body.
  void advance(fluid::Fluid& fluid, const fluid::NodeForces& reaction) {
    for (std::size_t i = 0; i < reaction.nodes.size(); ++i)
      force_.row(reaction.nodes[i]) += reaction.force->row(static_cast<Eigen::Index>(i));
    fluid.collide_and_stream({nodes_, &force_});
    for (const std::int64_t node : reaction.nodes) put(node);
  }

 private:
  void put(std::int64_t node) { force_.row(node) = per_velocity_ * rolls_.velocity(node).transpose(); }

  Rolls rolls_;
  double per_velocity_;
  std::vector<std::int64_t> nodes_;
  Positions force_;
  parts::Built part_;
};

analytic::StrainedChain chain_of(const Filament& study) {
  const double k = study.wavenumber(), seen = analytic::interpolated(k);
  const Eigen::Index n = study.network().node_count();
  analytic::StrainedChain chain{analytic::line_mobility(study.fluid().grid, study.fluid().relaxation_time, n),
                                study.stiffness, VectorXd(n), VectorXd(n)};
  chain.mobility.along[0] += study.slip();
  chain.mobility.across[0] += study.slip();
  for (Eigen::Index i = 0; i < n; ++i) {
    const double x = static_cast<double>(i) - 0.5 * static_cast<double>(n - 1);
    chain.stream[i] = -seen * seen * study.rate() / k * std::sin(k * x);
    chain.stretching[i] = seen * analytic::interpolated_slope(k) * study.rate() * std::cos(k * x);
  }
  return chain;
}

/// k_a at which the chain begins to buckle; from the stiff side, because further on it drifts as fast as it
/// buckles.
double critical_stiffness(analytic::StrainedChain chain) {
  const auto growth = [&](double stiffness) {
    chain.angle_stiffness = stiffness;
    return analytic::even_modes(rate_of(chain)).buckling.growth;
  };
  double stiff = 20.0 * chain.angle_stiffness;
  while (growth(stiff / 1.05) < 0.0) stiff /= 1.05;
  return bracketed_root(growth, stiff / 1.05, stiff);
}

double slope_of(const std::vector<double>& x, const std::vector<double>& y, std::size_t from,
                std::size_t to) {
  double at_zero, slope, unused[4];
  gsl_fit_linear(&x[from], 1, &y[from], 1, to - from, &at_zero, &slope, &unused[0], &unused[1], &unused[2],
                 &unused[3]);
  return slope;
}

Observations buckling_filament_observations() {
  return {
      .records =
          {{"buckling_mode",
            "The filament at the end, without what of it drifts off the axis, over its largest displacement",
            {{"place", "s/L", "1", "along the filament from its middle", {}},
             {"measured", "", "1", "displacement across the axis", {}},
             {"theory", "", "1", "mode of the chain of markers", {}}}},
           {"buckling_growth",
            "Share of the buckling mode in the filament's shape",
            {{"strain", "rate t", "1", "since the start", {}},
             {"share", "", "L", "of the mode, whose largest displacement is 1", {}},
             {"theory", "", "L", "exponential from the middle of what is fitted", {}}}}},
      .metrics = {
          {"coupling_growth", {}, "1", "largest factor a step of the linearised coupling"},
          {"growth", {}, "1", "of the buckling mode over the rate of strain, measured"},
          {"growth_markers", {}, "1", "the same of the chain of markers in this flow and box, by theory"},
          {"growth_error", {}, "1", "distance of these two"},
          {"growth_slender", {}, "1", "the same of a slender body in a uniform strain, to order 1/ln"},
          {"growth_change",
           {},
           "1",
           "of the measured growth from the first half of what is fitted to the second"},
          {"shape_error",
           {},
           "1",
           "largest distance of the measured mode from theory, over its largest displacement"},
          {"eta", {}, "1", "8 pi/c mu rate L^4/B, c = -ln((a/L)^2 e)"},
          {"eta_threshold", {}, "1", "the same at which the chain of markers begins to buckle, by theory"},
          {"marker_radius", {}, "L", "a: of a sphere that moves as one marker does by a force, slip and all"},
          {"bond_strain", {}, "1", "by which the middle bonds are shorter at the end"}}};
}

void run_buckling_filament(const Filament& study, Observations& seen, Progress& progress,
                           engine::Cost& cost) {
  const scene::Body& body = study.scene.bodies.front();
  const fluid::Spec& spec = study.fluid();
  double coupling_growth = 0.0;
  engine::check_coupling(spec, body, "the filament", study.node_mass, coupling_growth, progress);
  seen.set("coupling_growth", coupling_growth);

  const double mu = study.viscosity(), L = study.length(), rate = study.rate();
  const Eigen::Index n = study.network().node_count(), middle = n / 2;
  const analytic::StrainedChain chain = chain_of(study);
  const analytic::EvenModes modes = analytic::even_modes(rate_of(chain));
  const double radius = analytic::marker_radius(study.fluid().relaxation_time, study.slip());
  const double eta = analytic::slender_drag(radius / L) * mu * rate * std::pow(L, 4) / study.stiffness;
  seen.set("marker_radius", radius);
  seen.set("eta", eta);
  seen.set("eta_threshold", eta * study.stiffness / critical_stiffness(chain));
  seen.set("growth_slender", analytic::slender_growth(eta)[0]);
  seen.set("growth_markers", modes.buckling.growth / rate);
  cost.finish("theory");

  RollForce rolls(study.rolls());
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(spec);
  fluid->start(study.scene.initial_flow);
  scene::MovingBody filament(body, &spec);
  std::vector<double> strains, shares;
  const std::int64_t every = std::max<std::int64_t>(1, study.steps() / samples);
  const auto across = [&] { return VectorXd(filament.solid().displacement().col(2)); };
  run_monitored(*fluid, study.monitor, "the filament", study.steps(), [&](std::int64_t step) {
    filament.locate();
    filament.interpolate(*fluid);
    filament.move();
    filament.spread();
    rolls.advance(*fluid, filament.reaction());
    if ((step + 1) % every != 0) return;
    strains.push_back(rate * static_cast<double>(step + 1));
    shares.push_back(modes.buckling.dual.dot(across()));
  });
  cost.finish("run");

  std::vector<double> logs;
  for (const double share : shares) logs.push_back(std::log(share));
  const std::size_t end = logs.size(), from = static_cast<std::size_t>(settled * static_cast<double>(end));
  const std::size_t half = (from + end) / 2;
  const double growth = slope_of(strains, logs, from, end);
  seen.set("growth", growth);
  seen.set("growth_error", std::abs(growth - modes.buckling.growth / rate));
  seen.set("growth_change", slope_of(strains, logs, half, end) - slope_of(strains, logs, from, half));

  observe::Record& in_time = seen.open("buckling_growth");
  for (std::size_t i = 0; i < end; ++i)
    in_time.append({strains[i], shares[i],
                    shares[half] * std::exp(modes.buckling.growth / rate * (strains[i] - strains[half]))});
  const VectorXd w = across();
  VectorXd shape = w - modes.drift.dual.dot(w) * modes.drift.shape;
  shape /= shape.cwiseAbs().maxCoeff() * (shape[middle] < 0.0 ? -1.0 : 1.0);
  observe::Record& record = seen.open("buckling_mode");
  for (Eigen::Index i = 0; i < n; ++i)
    record.append({static_cast<double>(i - middle) / L, shape[i], modes.buckling.shape[i]});
  seen.set("shape_error", (shape - modes.buckling.shape).cwiseAbs().maxCoeff());
  const Positions& u = filament.solid().displacement();
  seen.set("bond_strain", -(u(middle + 1, 0) - u(middle, 0)));
}

}  // namespace

engine::Study read_buckling_filament(const io::Table& top) {
  const io::Table t = top.table("buckling_filament");
  const fluid::Spec spec = engine::read_fluid(top);
  check_empty_box(top, spec);
  if (spec.grid.size[0] != spec.grid.size[2]) {
    top.table("fluid").fail("nodes", "the box is not that of four rolls",
                            "they fill a box as long along x as along z", "Give for example [64, 32, 64]");
  }
  scene::Body body = read_marker_chain(top, t, spec);
  if (body.network.node_count() % 2 == 0) {
    t.fail("nodes", fmt::format("'nodes' is {}", body.network.node_count()),
           "the middle node stands in the middle of the flow", "Give an odd number");
  }
  Filament study{.scene = {.fluid = spec, .bodies = {std::move(body)}},
                 .reynolds = engine::need_positive(t, "reynolds", t.number("reynolds")),
                 .stiffness = 0.0,
                 .amplitude = engine::need_positive(t, "amplitude", t.number("amplitude")),
                 .duration = engine::need_positive(t, "strain", t.number("strain")),
                 .node_mass = t.place("node_mass"),
                 .monitor = engine::read_monitor(top)};
  const double elastoviscous = engine::need_positive(t, "elastoviscous", t.number("elastoviscous"));
  study.stiffness = study.viscosity() * study.rate() * std::pow(study.length(), 4) / elastoviscous;
  engine::whole_steps(study.duration / study.rate(), static_cast<double>(samples), "the run takes",
                      t.place("reynolds"));
  scene::Body& filament = study.scene.bodies.front();
  filament.material.angle_stiffness = study.stiffness;
  engine::check_images(spec, filament.coupling->delta, {study.length(), 0.0, 0.0}, Vec3::Zero(),
                       "the filament", top.table("fluid").place("nodes"));
  const Eigen::Index n = filament.network.node_count();
  filament.start = {Positions::Zero(n, 3), Positions::Zero(n, 3)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const double s = 2.0 * static_cast<double>(i) / static_cast<double>(n - 1) - 1.0;
    filament.start.displacement(i, 2) = study.amplitude * (1.0 - 3.0 * s * s);
  }
  study.scene.initial_flow = [rolls = study.rolls()](std::int64_t node) { return rolls.populations(node); };
  scene::Plan plan = plan_of(top, study.scene);
  scene::put_in(plan, {"force of the rolls",
                       "at every node, each step",
                       static_cast<double>(spec.grid.count()) * 4.0 * sizeof(double),
                       {parts::Kind::UniformForce}});
  return {.plan = std::move(plan),
          .declares = buckling_filament_observations(),
          .run = std::bind_front(run_buckling_filament, study)};
}

}  // namespace veriflex::measures
