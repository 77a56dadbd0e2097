#include "measures/filament/filament_case.hpp"

#include <fmt/format.h>

#include <cmath>

#include "bond/derive.hpp"
#include "engine/check_place.hpp"
#include "engine/read_scene.hpp"
#include "scene/markers.hpp"

namespace veriflex::measures {

namespace {

int read_substeps(const io::Table& t) { return static_cast<int>(t.integer("substeps", 1, 1000)); }

Driven read_driven(const io::Table& t) {
  return t.choice("driven", {"node", "section"}) == "section" ? Driven::Section : Driven::Node;
}

double read_ramp(const io::Table& t, double otherwise) {
  const double periods = t.number("ramp_periods", otherwise);
  if (periods < 0.0) {
    t.fail("ramp_periods", fmt::format("'ramp_periods' is {}", periods), "a ramp is 0 periods long or more",
           "0 starts abruptly");
  }
  return periods;
}

Vec3 read_offset(const io::Table& t) {
  const Vec3 offset = engine::read_vector(t, "offset");
  for (const double along : offset) {
    if (std::abs(along) <= farthest_offset) continue;
    t.fail("offset", fmt::format("'offset' holds {}", along),
           "so far away a number no longer tells places within a node's spacing apart",
           "Whole box lengths along a periodic axis change nothing: leave them out");
  }
  return offset;
}

/// Refuses a stroke that has no room in its box, or that takes too few or too many steps.
void check(const Stroke& stroke, const Place& box, const Place& frequency) {
  constexpr double min_period = 16.0;  // steps: two from one of the sampled phases to the next
  engine::whole_steps(stroke.period(), min_period, "a period of the stroke takes", frequency);
  engine::whole_steps(stroke.periods * stroke.period(), 1.0, "the stroke takes", frequency);
  const double across = 2.0 * std::floor(stroke.rod.radius) * stroke.rod.spacing;
  const Vec3 driven(0.0, 0.0, stroke.amplitude);
  engine::check_images(stroke.fluid, stroke.coupling.delta, {across, stroke.length(), across}, driven,
                       "the filament", box);
  try {
    engine::check_supports(stroke.fluid, stroke.coupling.delta, scene::markers_at_rest(body_of(stroke)),
                           driven, "the filament", box);
  } catch (const BadParameter& bad) {  // a listed node that the body has not
    throw InputError(box, bad.problem, bad.why, bad.suggestion);
  }
}

}  // namespace

Stroke read_stroke(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const bond::Derivation derivation = engine::read_derivation(top, law);
  const scene::SolidSpec solid = engine::read_solid(top, law, derivation.rest_length);
  const auto* rod = std::get_if<solid::Rod>(&solid.shape);
  if (rod == nullptr || rod->sections < 3) {
    top.table("solid").fail("shape", "the filament is no rod of three sections or more",
                            "its axis must have nodes", "Use shape = \"rod\"");
  }
  const io::Table t = top.table("filament");
  Stroke stroke{.fluid = engine::read_fluid(top),
                .rod = *rod,
                .law = law,
                .angle_stiffness = solid.angle_stiffness,
                .node_mass = t.number("node_mass"),
                .substeps = {.count = read_substeps(t), .safety = 0.0},
                .coupling = engine::read_coupling(top),
                .offset = t.has("offset") ? read_offset(t) : Vec3(Vec3::Zero()),
                .amplitude = t.number("amplitude"),
                .reynolds = t.number("reynolds"),
                .driven = t.has("driven") ? read_driven(t) : Driven::Node,
                .ramp_periods = read_ramp(t, 0.0),
                .periods = static_cast<int>(t.integer("periods", 1, 1000)),
                .monitor = engine::read_monitor(top),
                .node_mass_place = t.place("node_mass")};
  for (const bond::NamedValue& p : bond::parameters_of(law)) {
    if (p.name == "sigma") stroke.short_bond = 1.2 * p.value;
  }
  engine::need_positive(t, "amplitude", stroke.amplitude);
  engine::need_positive(t, "reynolds", stroke.reynolds);
  engine::need_positive(t, "node_mass", stroke.node_mass);
  return stroke;
}

Stroke varied(const Stroke& base, const io::Table& variant) {
  Stroke s = base;
  if (variant.has("fluid")) {
    const io::Table fluid = variant.table("fluid");
    if (fluid.has("relaxation_time") || fluid.has("viscosity"))
      s.fluid.relaxation_time = engine::read_relaxation_time(fluid);
    if (fluid.has("nodes")) s.fluid.grid.size = engine::read_box(fluid);
    if (fluid.flag("closed", false)) s.fluid.walls = {fluid::Walls{}, fluid::Walls{}, fluid::Walls{}};
  }
  if (variant.has("coupling")) s.coupling = engine::read_coupling(variant);
  if (variant.has("bond")) s.law = engine::read_law(variant);
  if (variant.has("solid")) s.rod.sections = variant.table("solid").integer("sections", 3, 1'000'000);
  if (variant.has("filament")) {
    const io::Table t = variant.table("filament");
    if (t.has("substeps")) s.substeps.count = read_substeps(t);
    if (t.has("driven")) s.driven = read_driven(t);
    if (t.has("offset")) s.offset = read_offset(t);
    s.ramp_periods = read_ramp(t, s.ramp_periods);
    if (t.has("amplitude")) {
      const double amplitude = t.number("amplitude");
      engine::need_positive(t, "amplitude", amplitude);
      s.reynolds *= amplitude / s.amplitude;  // the frequency stays
      s.amplitude = amplitude;
    }
  }
  try {
    fluid::require_memory(s.fluid);
  } catch (const BadParameter& bad) {
    throw InputError(variant.place(), bad.problem, bad.why, bad.suggestion);
  }
  check(s, variant.place(), variant.place());
  return s;
}

scene::ExpectedWork expected_work(const Stroke& stroke, std::int64_t runs) {
  const auto steps = std::llround(stroke.periods * stroke.period());
  scene::ExpectedWork work =
      *scene::expected_work({.fluid = stroke.fluid, .bodies = {body_of(stroke)}}, runs * steps);
  work.checked_nodes *= static_cast<double>(runs);
  work.checked_substeps *= static_cast<double>(runs);
  return work;
}

scene::Plan plan_stroke(const io::Table& top, const Stroke& stroke) {
  scene::Plan plan = engine::read_plan(
      top, {.law = stroke.law,
            .solid = scene::SolidSpec{.shape = stroke.rod, .angle_stiffness = stroke.angle_stiffness},
            .method = fmt::format("leap-frog, {} sub-steps, driven at one end", stroke.substeps.count),
            .by = {parts::Kind::LeapFrog, parts::Kind::Drive},
            .fluid = stroke.fluid,
            .coupling = stroke.coupling});
  check(stroke, top.table("fluid").place("nodes"), top.table("filament").place("reynolds"));
  return plan;
}

}  // namespace veriflex::measures
