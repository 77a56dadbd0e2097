#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/error.hpp"
#include "base/reduce.hpp"
#include "engine/check_coupling.hpp"
#include "engine/check_place.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/solid/beam_section.hpp"
#include "observe/run.hpp"
#include "scene/markers.hpp"
#include "scene/simulation.hpp"
#include "solid/modes.hpp"

// A clamped rod in a stream across it. Once it is at rest the fluid's forces on its nodes, as the coupling
// exchanged them, are a static load, and its deflection must be that of a beam under this load.

namespace veriflex::measures {

namespace {

using observe::Observations;

struct Crossflow {
  fluid::Spec fluid;
  solid::Material material;
  solid::Rod rod;
  scene::CouplingSpec coupling;
  double node_mass;
  int substeps;
  std::int64_t clamped;   // sections that are fixed
  Place node_mass_place;  // in the case, where an unstable coupling is reported
  double steady_change;   // of the tip's deflection per step, over it
  std::int64_t step_limit;
  observe::MonitorSpec monitor;

  double length() const { return static_cast<double>(rod.sections - clamped) * rod.spacing; }
};

constexpr std::int64_t between_looks = 100;

/// The rod along y, its clamped end at smaller y, in the middle of the box; the stream along z.
scene::Body body_of(const Crossflow& study) {
  solid::Network network = solid::rod_lattice(study.rod);
  solid::add_angles(network);
  network.rest = scene::turned(network.rest, 1);
  network.vectors = scene::turned(network.vectors, 1);
  solid::Conditions conditions;
  conditions.node_mass = study.node_mass;
  conditions.fixed = solid::FixedDofs::Constant(network.node_count(), 3, false);
  for (Eigen::Index i = 0; i < network.node_count(); ++i) {
    if (network.rest(i, 1) < (static_cast<double>(study.clamped) - 0.5) * study.rod.spacing) {
      conditions.fixed.row(i).setConstant(true);
    }
  }
  const auto& size = study.fluid.grid.size;
  const double extent = static_cast<double>(study.rod.sections - 1) * study.rod.spacing;
  return {.material = study.material,
          .network = std::move(network),
          .conditions = conditions,
          .substeps = {study.substeps, 0.0},
          .place = {static_cast<double>(size[0] / 2), 0.5 * (static_cast<double>(size[1]) - extent),
                    static_cast<double>(size[2] / 2)},
          .axis = 1,
          .coupling = study.coupling};
}

/// What acts on a section, or what it does.
struct Section {
  double place;       // from the last clamped section  [L]
  double force;       // along z  [M L T^-2]
  double couple;      // of the forces along y, towards a positive slope  [M L^2 T^-2]
  double deflection;  // mean of its nodes along z  [L]
};

std::vector<Section> sections_of(const Crossflow& study, const scene::Simulation& simulation) {
  std::vector<Section> sections(static_cast<std::size_t>(study.rod.sections));
  const solid::Network& network = simulation.body().network();
  const auto at = [&](Eigen::Index node) -> Section& {
    return sections[static_cast<std::size_t>(std::llround(network.rest(node, 1) / study.rod.spacing))];
  };
  for (std::size_t s = 0; s < sections.size(); ++s) {
    sections[s].place = (static_cast<double>(s) - static_cast<double>(study.clamped - 1)) * study.rod.spacing;
  }
  const Eigen::Index per_section = network.node_count() / study.rod.sections;
  for (Eigen::Index i = 0; i < network.node_count(); ++i) {
    at(i).deflection += simulation.body().solid().displacement()(i, 2) / static_cast<double>(per_section);
  }
  const std::vector<std::int32_t>& coupled = simulation.body().coupled();
  for (std::size_t i = 0; i < coupled.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    at(coupled[i]).force += simulation.body().exchanged()(row, 2);
    at(coupled[i]).couple -= network.rest(coupled[i], 2) * simulation.body().exchanged()(row, 1);
  }
  sections.erase(sections.begin(), sections.begin() + (study.clamped - 1));
  return sections;
}

/// Timoshenko's beam, clamped at place 0, under the forces and couples of its sections.
double beam_deflection(const std::vector<Section>& sections, double place, double bending, double shear) {
  double sum = 0.0;
  for (const Section& s : sections) {
    const double near = std::min(s.place, place), far = std::max(s.place, place);
    sum += s.force * (near * near * (3.0 * far - near) / (6.0 * bending) + near / shear);
    sum += s.couple * (place < s.place ? place * place : s.place * (2.0 * place - s.place)) / (2.0 * bending);
  }
  return sum;
}

/// Until the tip rests.
void run_to_rest(const Crossflow& study, const scene::Simulation& simulation, observe::Run& run) {
  const auto tip = [&] { return sections_of(study, simulation).back().deflection; };
  double before = 0.0;
  for (;;) {
    run.advance(between_looks, study.step_limit);
    const double now = tip();
    const double change = relative_to(now - before, now) / between_looks;
    if (change <= study.steady_change) return;
    if (simulation.steps() + between_looks > study.step_limit) {
      run.interrupt(NumericalFailure(
          fmt::format(
              "step {}: the tip still moves by {:.3g} of its deflection a step, at rest means at most {:.3g}",
              simulation.steps(), change, study.steady_change),
          FailureMode::NotConverged));
    }
    before = now;
  }
}

/// Refuses a rod that has no room in its box.
void check(const Crossflow& study, const Place& box) {
  const double across = 2.0 * std::floor(study.rod.radius) * study.rod.spacing;
  const double along = static_cast<double>(study.rod.sections - 1) * study.rod.spacing;
  engine::check_images(study.fluid, study.coupling.delta, {across, along, across}, Vec3::Zero(), "the rod",
                       box);
  try {
    engine::check_supports(study.fluid, study.coupling.delta, scene::markers_at_rest(body_of(study)),
                           Vec3::Zero(), "the rod", box);
  } catch (const BadParameter& bad) {  // a listed node that the body has not
    throw InputError(box, bad.problem, bad.why, bad.suggestion);
  }
}

Observations crossflow_observations() {
  return {
      .records =
          {{"deflection",
            "Deflection of the rod in the stream, and of Timoshenko's beam under the forces that it bears",
            {{"place", "y", "L", "from the last clamped section", {}},
             {"deflection", "w", "L", "mean over a section", {}},
             {"beam", "", "L", "Timoshenko's beam", {}},
             {"beam_without_shear", "", "L", "Euler's beam", {}},
             {"force", "", "M L T^-2", "of the fluid on a section, along the stream", {}}}}},
      .metrics = {
          {"coupling_growth", {}, "1", "largest factor a step of the linearised exchange"},
          {"tip_deflection", {}, "L", "along the stream"},
          {"tip_slope", {}, "1", "tip deflection over length"},
          {"tip_ratio", {}, "1", "over Timoshenko's"},
          {"beam_error", {}, "1", "largest distance from Timoshenko's beam, over the tip's deflection"},
          {"lattice_error",
           {},
           "1",
           "largest distance of a node from the lattice's linear statics, over the largest displacement"},
          {"shear_share", {}, "1", "of the tip's deflection that is due to shear"},
          {"end_share", {}, "1", "of the force that acts on the free end's section"},
          {"steps", {}, "T", "until the tip rested"},
          {"dt_over_limit", {}, "1", "sub-step over the linear limit 2/omega_max at rest"}}};
}

void run_crossflow(const Crossflow& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  double growth = 0.0;
  engine::check_coupling(study.fluid, body_of(study), "the rod", study.node_mass_place, growth, progress);
  seen.set("coupling_growth", growth);
  cost.finish("stability of the coupling");
  scene::Simulation simulation({.fluid = study.fluid, .bodies = {body_of(study)}});
  observe::Run stream(simulation, study.monitor, {}, "the stream", progress);
  run_to_rest(study, simulation, stream);
  stream.finish();
  cost.finish("run_steps");

  const scene::SolidSpec spec{.shape = study.rod, .angle_stiffness = study.material.angle_stiffness};
  const BeamSection section = section_of(study.material, spec, study.rod.spacing);
  const double shear = shear_factor(spec) * section.shear;
  const std::vector<Section> sections = sections_of(study, simulation);

  // The lattice's own linear statics under the same forces, node by node.
  const solid::Network& network = simulation.body().network();
  Positions load = Positions::Zero(network.node_count(), 3);
  for (std::size_t i = 0; i < simulation.body().coupled().size(); ++i) {
    load.row(simulation.body().coupled()[i]) =
        simulation.body().exchanged().row(static_cast<Eigen::Index>(i));
  }
  const solid::FixedDofs held = body_of(study).conditions.fixed;
  const double omega = solid::largest_frequency(
      study.material, network, Positions::Zero(network.node_count(), 3), held, study.node_mass);
  const Positions still = solid::linear_response(study.material, network, held, load);
  const Positions& u = simulation.body().solid().displacement();
  const double lattice = largest_magnitude(u - still) / largest_magnitude(u);

  observe::Record& record = seen.open("deflection");
  double worst = 0.0, total = 0.0;
  const double tip = sections.back().deflection;
  for (const Section& s : sections) {
    const double beam = beam_deflection(sections, s.place, section.bending(), shear);
    record.append({s.place, s.deflection, beam,
                   beam_deflection(sections, s.place, section.bending(), INFINITY), s.force});
    worst = worse(worst, std::abs(s.deflection - beam) / std::abs(tip));
    total += s.force;
  }
  const double beam_tip = record.find("beam")->values.back();
  seen.set("tip_deflection", tip);
  seen.set("tip_slope", tip / study.length());
  seen.set("tip_ratio", tip / beam_tip);
  seen.set("beam_error", worst);
  seen.set("lattice_error", lattice);
  seen.set("shear_share", 1.0 - record.find("beam_without_shear")->values.back() / beam_tip);
  seen.set("end_share", sections.back().force / total);
  seen.set("steps", static_cast<double>(simulation.steps()));
  seen.set("dt_over_limit", 0.5 * omega / study.substeps);
}

}  // namespace

engine::Study read_crossflow(const io::Table& top) {
  const solid::Material material = read_material_with_angles(top);
  const scene::SolidSpec solid =
      engine::read_solid(top, material.law, engine::read_derivation(top, material.law).rest_length);
  const auto* rod = std::get_if<solid::Rod>(&solid.shape);
  if (rod == nullptr) {
    top.table("solid").fail("shape", "the body is not a rod", "the stream meets a round section",
                            "Write shape = \"rod\"");
  }
  const io::Table t = top.table("crossflow");
  const Crossflow study{.fluid = engine::read_fluid(top),
                        .material = material,
                        .rod = *rod,
                        .coupling = engine::read_coupling(top),
                        .node_mass = t.number("node_mass"),
                        .substeps = static_cast<int>(t.integer("substeps", 1, 10000)),
                        .clamped = t.integer("clamped", 1, 100),
                        .node_mass_place = t.place("node_mass"),
                        .steady_change = t.number("steady_change"),
                        .step_limit = t.integer("step_limit", between_looks, 1'000'000'000),
                        .monitor = engine::read_monitor(top)};
  engine::need_positive(t, "node_mass", study.node_mass, "1 is the paper's");
  if (!(study.steady_change >= 1e-14)) {
    t.fail("steady_change", fmt::format("'steady_change' is {}", study.steady_change),
           "round-off never comes to rest", "Give for example 1e-7");
  }
  if (study.clamped + 2 > rod->sections) {
    t.fail("clamped", fmt::format("{} of {} sections are clamped", study.clamped, rod->sections),
           "nothing would bend", "Hold fewer");
  }
  const Vec3& g = study.fluid.body_force;
  if (!(g[2] > 0.0) || g[0] != 0.0 || g[1] != 0.0) {
    top.table("fluid").fail("body_force", "it does not drive a stream along z",
                            "the rod lies along y and bends towards z", "Give for example [0.0, 0.0, 1e-8]");
  }
  scene::Plan plan = engine::read_plan(
      top, {.law = material.law,
            .solid = solid,
            .method = fmt::format("leap-frog, {} sub-steps, first sections clamped", study.substeps),
            .by = {parts::Kind::LeapFrog, parts::Kind::Constraints, parts::Kind::Statics},
            .fluid = study.fluid,
            .coupling = study.coupling});
  check(study, top.table("fluid").place("nodes"));
  return {.plan = std::move(plan),
          .declares = crossflow_observations(),
          .run = std::bind_front(run_crossflow, study)};
}

}  // namespace veriflex::measures
