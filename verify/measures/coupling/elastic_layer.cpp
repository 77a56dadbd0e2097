#include <fmt/format.h>

#include <cmath>
#include <complex>
#include <functional>
#include <numbers>

#include "analytic/elastic_layer.hpp"
#include "base/error.hpp"
#include "base/mutant.hpp"
#include "base/reduce.hpp"
#include "engine/check_coupling.hpp"
#include "engine/check_place.hpp"
#include "engine/read_scene.hpp"
#include "fluid/lattice.hpp"
#include "measures/drivers.hpp"
#include "measures/scene/scene.hpp"
#include "observe/run.hpp"
#include "scene/markers.hpp"
#include "scene/periodic_body.hpp"
#include "scene/simulation.hpp"

// An elastic layer on an oscillating plate, and a fluid between it and a wall at rest. The scene is that and
// its mirror image: a layer of twice the thickness whose middle nodes are driven. Along the plate the layer
// goes on through the periodic box, and its bonds with it: it shears as the infinite lattice does, with G =
// 4 k_a/r0^3, and nothing depends on anything but the distance from the plate.

namespace veriflex::measures {

namespace {

using Complex = std::complex<double>;
using observe::Observations;

constexpr std::int64_t across = 2;  // nodes along each side of the box that is parallel to the plate

struct LayerStudy {
  scene::Scene scene;
  analytic::ElasticLayer exact;
  double plate_speed;   // V  [L T^-1]
  std::int64_t period;  // [T]
  std::int64_t periods;
  observe::MonitorSpec monitor;
  Place density_place;  // in the case, where an unstable coupling is reported
};

/// What the case says, all of it without dimensions but for the layers: they are the resolution.
struct Asked {
  std::int64_t layers;  // of nodes, the driven one among them: h = layers - 1/2
  std::int64_t depth;   // (H - h)/h
  double stiffness;     // G h^2/(rho_f nu^2)
  double density;       // rho_s/rho_f
  double period;        // T nu/h^2
  double stroke;        // of the plate, over h

  double thickness() const { return static_cast<double>(layers) - 0.5; }
  double height() const { return thickness() * static_cast<double>(depth + 1); }
  std::int64_t nodes() const { return (depth + 1) * (2 * layers - 1); }  // of the box, from wall to wall
};

scene::Body body_of(const bond::AnyLaw& law, const Asked& asked, double angle_stiffness, double omega,
                    int substeps, const scene::CouplingSpec& coupling) {
  const std::int64_t layers = 2 * asked.layers - 1, per_layer = across * across;
  solid::Network network = solid::cubic_lattice({{across, across, layers}, 1.0});
  scene::bond_across(network, 0);
  scene::bond_across(network, 1);
  solid::add_angles(network);
  network.rest = scene::turned(network.rest, 0);
  network.vectors = scene::turned(network.vectors, 0);
  solid::Drive drive{
      .nodes = {}, .axis = 1, .amplitude = asked.stroke * asked.thickness(), .omega = omega, .ramp = 0.0};
  for (std::int64_t i = 0; i < per_layer; ++i)
    drive.nodes.push_back(static_cast<std::int32_t>((asked.layers - 1) * per_layer + i));
  solid::Conditions conditions;
  conditions.node_mass = asked.density;
  conditions.drive = std::move(drive);
  return {.material = {law, angle_stiffness},
          .network = std::move(network),
          .conditions = std::move(conditions),
          .substeps = {substeps, 0.0},
          .place = {static_cast<double>((asked.nodes() - layers) / 2), 0.0, 0.0},
          .axis = 0,
          .coupling = coupling};
}

/// Displacement of each layer from the driven one on, mean along the plate  [L].
Eigen::VectorXd displacements(const scene::MovingBody& body) {
  const Positions& u = body.solid().displacement();
  const Eigen::Index per_layer = across * across, layers = (u.rows() / per_layer + 1) / 2;
  Eigen::VectorXd mean(layers);
  for (Eigen::Index j = 0; j < layers; ++j)
    mean[j] = u.col(1).segment((layers - 1 + j) * per_layer, per_layer).mean();
  return mean;
}

/// Velocity of each layer over the plate's, as complex amplitudes over one period of the run. The plate is at
/// A sin(omega t): its velocity is the real part of exp(i omega t).
Eigen::VectorXcd amplitudes(const LayerStudy& study, scene::Simulation& simulation, observe::Run& run) {
  const double omega = study.exact.omega;
  Eigen::VectorXcd sum = Eigen::VectorXcd::Zero(displacements(simulation.body()).size());
  for (std::int64_t n = 0; n < study.period; ++n) {
    run.advance(1, study.period * study.periods);
    sum += displacements(simulation.body()) *
           std::polar(1.0, -omega * static_cast<double>(simulation.steps() % study.period));
  }
  return sum * Complex(0.0, omega) * 2.0 / (static_cast<double>(study.period) * study.plate_speed);
}

/// The interface is half a cell outside of the last layer of nodes.
Complex at_interface(const Eigen::VectorXcd& v) {
  const Eigen::Index last = v.size() - 1;
  return v[last] + (planted(Mutant::interface_at_last_layer) ? 0.0 : 0.5) * (v[last] - v[last - 1]);
}

Observations elastic_layer_observations() {
  Observations seen;
  seen.metrics = {{"coupling_growth", {}, "1", "largest factor a step of the linearised coupling"},
                  {"amplitude", {}, "1", "of the interface's velocity, over the plate's"},
                  {"phase", {}, "1", "of the interface's velocity, ahead of the plate's [rad]"},
                  {"exact_amplitude", {}, "1", "of the continuum"},
                  {"exact_phase", {}, "1", "of the continuum [rad]"},
                  {"amplitude_ratio", {}, "1", "measured over exact"},
                  {"phase_difference", {}, "1", "measured less exact [rad]"},
                  {"error", {}, "1", "distance of the complex amplitudes, over the exact one's magnitude"},
                  {"shear_ratio",
                   {},
                   "1",
                   "of the interface's velocity less the plate's: magnitude, measured over exact"},
                  {"shear_error",
                   {},
                   "1",
                   "distance of the complex amplitudes, over that of the exact one from the plate's"},
                  {"unsettled", {}, "1", "change of the amplitude from the last period but one, over it"},
                  {"strain", {}, "1", "largest shear of the layer"}};
  seen.records = {{"layer",
                   "Velocity amplitude of the layer, over the plate's",
                   {{"height", "y", "L", "above the driven nodes", {}},
                    {"amplitude", "", "1", "measured", {}},
                    {"phase", "", "1", "measured [rad]", {}},
                    {"exact_amplitude", "", "1", "of the continuum", {}},
                    {"exact_phase", "", "1", "of the continuum [rad]", {}}}}};
  return seen;
}

void run_elastic_layer(const LayerStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  double growth = 0.0;
  engine::check_coupling(*study.scene.fluid, study.scene.bodies.front(), "the layer", study.density_place,
                         growth, progress);
  seen.set("coupling_growth", growth);
  cost.finish("stability of the coupling");
  scene::Simulation simulation(study.scene);
  observe::Run run(simulation, study.monitor, {}, "", progress);
  run.advance(study.period * (study.periods - 2), study.period * study.periods);
  const Complex before = at_interface(amplitudes(study, simulation, run));
  const Eigen::VectorXcd v = amplitudes(study, simulation, run);
  run.finish();
  cost.finish("run");

  observe::Record& record = seen.open("layer");
  double strain = 0.0;
  for (Eigen::Index j = 0; j < v.size(); ++j) {
    const auto y = static_cast<double>(j);
    const Complex exact = layer_velocity(study.exact, y);
    record.append({y, std::abs(v[j]), std::arg(v[j]), std::abs(exact), std::arg(exact)});
    if (j > 0) strain = worse(strain, std::abs(v[j] - v[j - 1]) * study.plate_speed / study.exact.omega);
  }
  const Complex measured = at_interface(v), exact = interface_velocity(study.exact);
  seen.set("amplitude", std::abs(measured));
  seen.set("phase", std::arg(measured));
  seen.set("exact_amplitude", std::abs(exact));
  seen.set("exact_phase", std::arg(exact));
  seen.set("amplitude_ratio", std::abs(measured / exact));
  seen.set("phase_difference", std::arg(measured / exact));
  seen.set("error", std::abs(measured / exact - 1.0));
  seen.set("shear_ratio", std::abs((measured - 1.0) / (exact - 1.0)));
  seen.set("shear_error", std::abs((measured - exact) / (exact - 1.0)));
  seen.set("unsettled", std::abs(measured / before - 1.0));
  seen.set("strain", strain);
}

Asked read_asked(const io::Table& t) {
  const auto positive = [&](const char* key) { return engine::need_positive(t, key, t.number(key)); };
  const Asked asked{.layers = t.integer("layers", 3, 100'000),
                    .depth = t.integer("depth", 2, 100),
                    .stiffness = positive("stiffness"),
                    .density = positive("density"),
                    .period = positive("period"),
                    .stroke = positive("stroke")};
  if (asked.depth % 2 != 0) {
    t.fail("depth", fmt::format("'depth' is {}", asked.depth),
           "the walls stand half-way between nodes where it is even", "Use an even number");
  }
  return asked;
}

bond::AnyLaw read_law_at_one(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const double rest_length = engine::read_derivation(top, law).rest_length;
  if (std::abs(rest_length - 1.0) > 1e-6) {
    top.table("bond").fail("law", fmt::format("its rest length is {}", rest_length),
                           "the layer's lattice goes on through the box of the fluid, whose spacing is 1",
                           "Use a law that rests at 1");
  }
  return law;
}

}  // namespace

engine::Study read_elastic_layer(const io::Table& top) {
  const io::Table t = top.table("elastic_layer");
  const Asked asked = read_asked(t);
  fluid::Spec spec = engine::read_fluid(top, engine::Varied::Nodes);
  for (const auto& walls : spec.walls) {
    if (walls)
      top.table("fluid").fail("relaxation_time", "walls are given", "the study has its own",
                              "Leave them out");
  }
  spec.grid.size = {asked.nodes(), across, across};
  spec.walls[0] = fluid::Walls{};
  const double h = asked.thickness(), nu = fluid::viscosity(spec.relaxation_time);
  const std::int64_t period =
      engine::whole_steps(asked.period * h * h / nu, 4.0, "a period takes", t.place("period"));
  const std::int64_t periods = t.integer("periods", 3, 100'000);
  engine::whole_steps(static_cast<double>(period) * static_cast<double>(periods), 1.0, "the run takes",
                      t.place("periods"));
  const double omega = 2.0 * std::numbers::pi / static_cast<double>(period);
  const double shear_modulus = asked.stiffness * nu * nu / (h * h);
  const scene::CouplingSpec coupling = engine::read_coupling(top);
  if (coupling.coupled != scene::Coupled::Boundary && coupling.coupled != scene::Coupled::All) {
    top.table("coupling")
        .fail("nodes", "neither the boundary nodes nor all nodes are coupled",
              "the exact answer is that of these", "Use \"boundary\" or \"all\"");
  }
  LayerStudy study{
      .scene = {.fluid = spec,
                .bodies = {body_of(read_law_at_one(top), asked, 0.25 * shear_modulus, omega,
                                   static_cast<int>(t.integer("substeps", 1, 10000)), coupling)}},
      .exact = {.thickness = h,
                .height = asked.height(),
                .shear_modulus = shear_modulus,
                .density = asked.density,
                .fluid_density = 1.0,
                .viscosity = nu,
                .omega = omega,
                .filling = coupling.coupled == scene::Coupled::All ? analytic::Filling::Moving
                                                                   : analytic::Filling::Between},
      .plate_speed = asked.stroke * h * omega,
      .period = period,
      .periods = periods,
      .monitor = engine::read_monitor(top),
      .density_place = t.place("density")};
  scene::Plan plan = plan_of(top, study.scene);
  return {.plan = std::move(plan),
          .declares = elastic_layer_observations(),
          .run = std::bind_front(run_elastic_layer, study)};
}

}  // namespace veriflex::measures
