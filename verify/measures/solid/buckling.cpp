#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>

#include "base/root.hpp"
#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/solid/beam_section.hpp"
#include "solid/modes.hpp"

// A column of n spacings, pinned at both ends: the end sections are fixed across the axis and free to turn, a
// dead load P presses on each, spread evenly over its N nodes. Nothing widens (C12 = 0), so that the
// compressed column is homogeneous: every bond along the axis has the length a with tension(a) = -P/N.
//
// Its energy to second order in the deflection w and the turn p of the sections, per section,
//   1/2 k sum x^2 (p[i+1] - p[i])^2         springs, k = stiffness(a)
//   1/2 k_a N (w[i+1] - 2 w[i] + w[i-1])^2/a^2                straight angles
//   k_a N_x ((w[i+1] - w[i])/a - p[i])^2, and with w[i] - w[i-1]   right angles
//   - 1/2 P (w[i+1] - w[i])^2/a                           the compressed bonds
// is stationary for w = sin(q i), p = cos(q i), q = pi/n. With h = 2 sin(q/2)/a it has a second solution at
//   P = B_straight h^2 + (B_spring + B_right) h^2/(1 + B_spring h^2/GA),
// exactly while sections stay plane (up to two nodes across); thicker ones warp, which lowers GA
// (shear_factor()). The compressed bonds follow the axis of the column, w', not the normal of its sections,
// p: that is Engesser's column. In Haringx's, P (1 + P/GA) = B h^2, the thrust stays normal to the sections.
namespace veriflex::measures {

namespace {

using observe::Observations;

struct BucklingStudy {
  solid::Material material;
  scene::SolidSpec section;  // its length is set by `length`
  std::int64_t length;       // in spacings, even
};

Observations buckling_observations() {
  return {.records = {},
          .metrics = {
              {"strain", {}, "1", "of the bonds along the axis at the critical load"},
              {"load", {}, "M L T^-2", "critical load"},
              {"euler", {}, "M L T^-2", "pi^2 B/L^2 with the lattice's own B and L at rest"},
              {"engesser", {}, "M L T^-2", "with shear, thrust along the axis, compressed section"},
              {"haringx", {}, "M L T^-2", "with shear, thrust normal to the sections, compressed section"},
              {"over_euler", {}, "1", "critical load over Euler's"},
              {"euler_error", {}, "1", "departure from Euler's load"},
              {"engesser_error", {}, "1", "departure from Engesser's load"},
              {"haringx_error", {}, "1", "departure from Haringx's load"},
              {"over_harmonic", {}, "1", "over Engesser's load of harmonic bonds of the same stiffness"},
              {"shear_factor", {}, "1", "kappa: shear stiffness of the section over GA; 1 without shear"}}};
}

// The compressed column at which some critical load is reached.
struct Critical {
  double strain;  // of the bonds along the axis, negative
  double load;    // P  [M L T^-2]
};

using LoadOfSection = std::function<double(const BeamSection&, double h)>;

// sin(q/2) 2/a of the first buckle
double wave_number(std::int64_t length, double axial) {
  return 2.0 * std::sin(0.5 * std::numbers::pi / static_cast<double>(length)) / axial;
}

double euler(const BeamSection& section, double h) { return section.bending() * h * h; }

double engesser(const BeamSection& section, double kappa, double h) {
  const double straight = section.straight_bending * h * h;
  const double springs = section.spring_bending * h * h;
  if (!(section.shear > 0.0)) return straight;
  const double with_right = springs + section.right_bending * h * h;
  // Sections warp for the springs' part of the moment alone.
  const double warping = (1.0 / kappa - 1.0) * springs / with_right;
  return straight + with_right / (1.0 + springs * (1.0 + warping) / section.shear);
}

double haringx(const BeamSection& section, double kappa, double h) {
  const double straight = section.straight_bending * h * h;
  const double shear = kappa * section.shear;
  if (!(shear > 0.0)) return straight;
  return straight + 0.5 * shear * (std::sqrt(1.0 + 4.0 * (euler(section, h) - straight) / shear) - 1.0);
}

double load_at(const BucklingStudy& study, double nodes, double strain) {
  return -nodes * bond::tension(study.material.law, spacing_of(study.section) * (1.0 + strain));
}

// The first strain from zero towards `limit`, not reached, at which f passes from below zero to above.
std::optional<double> first_passage(const Function& f, double limit) {
  constexpr int cells = 2000;
  constexpr int halvings = 40;  // of what is left to the limit after the last whole cell
  std::vector<double> at{0.0};
  for (int i = 1; i < cells; ++i) at.push_back(limit * i / cells);
  for (int i = 0; i < halvings; ++i) at.push_back(0.5 * (at.back() + limit));
  std::vector<double> value;
  for (std::size_t i = 0; i < at.size(); ++i) {
    value.push_back(f(at[i]));
    if (i > 0 && value[i] >= 0.0) return bracketed_root(f, at[i], at[i - 1]);
    if (i < 2 || !(value[i - 1] > value[i - 2] && value[i - 1] > value[i])) continue;
    // It comes near to zero between: it may pass there and back.
    const double peak = bracketed_minimum([&](double x) { return -f(x); }, at[i], at[i - 1], at[i - 2]);
    if (f(peak) >= 0.0) return bracketed_root(f, peak, at[i - 2]);
  }
  return std::nullopt;
}

// The strain at which the load is what `critical` says of the section so compressed; nothing where the load
// stays below that as far as the law goes.
std::optional<Critical> predicted(const BucklingStudy& study, const LoadOfSection& critical) {
  const double r0 = spacing_of(study.section);
  const double nodes = section_of(study.material, study.section, r0).nodes;
  const auto excess = [&](double strain) {
    const double axial = r0 * (1.0 + strain);
    return load_at(study, nodes, strain) -
           critical(section_of(study.material, study.section, axial), wave_number(study.length, axial));
  };
  const std::optional<double> strain = first_passage(excess, (bond::domain(study.material.law).lo - r0) / r0);
  if (!strain) return std::nullopt;
  return Critical{*strain, load_at(study, nodes, *strain)};
}

// The strain at which the lowest eigenvalue of the compressed network's Hessian passes zero.
Critical measured(const BucklingStudy& study, double expected) {
  const std::int64_t length = study.length;
  const solid::Network network = scene::build(with_sections(study.section, length + 1));
  const auto per_section = network.node_count() / (length + 1);
  solid::FixedDofs held = solid::FixedDofs::Constant(network.node_count(), 3, false);
  held.col(1).setConstant(true);  // buckling in the x-z plane
  held.col(0).head(per_section).setConstant(true);
  held.col(0).tail(per_section).setConstant(true);
  // The middle section is a plane of symmetry of the buckle, and would else be free to move along the axis.
  held.col(2).segment(length / 2 * per_section, per_section).setConstant(true);
  const auto lowest = [&](double strain) {
    Positions u = Positions::Zero(network.node_count(), 3);
    u.col(2) = strain * network.rest.col(2);
    const double omega = solid::lowest_frequencies(study.material, network, u, held, 1.0, 1)[0];
    return std::copysign(omega * omega, omega);
  };
  const double limit = (bond::domain(study.material.law).lo - network.spacing) / network.spacing;
  // Engesser's load is exact or near. The second buckle takes about four times the load: in between, the
  // eigenvalue nearest zero is the first. A stiff column may straighten again a little further on, so the
  // bracket grows from the expected strain.
  for (const double width : {1e-3, 1e-2, 0.1, 0.4, 0.6}) {
    const double before = expected * (1.0 - std::min(width, 0.4));
    const double after = std::max(expected * (1.0 + width), 0.5 * (expected + limit));
    if (!(lowest(before) > 0.0) || !(lowest(after) < 0.0)) continue;
    const double strain = bracketed_root(lowest, after, before);
    return {strain, load_at(study, static_cast<double>(per_section), strain)};
  }
  throw NumericalFailure(
      fmt::format("the column of {} spacings does not buckle near a strain of {}, where Engesser's does",
                  length, expected));
}

void run_buckling(const BucklingStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  const double r0 = spacing_of(study.section);
  const BeamSection at_rest = section_of(study.material, study.section, r0);
  const bool shears = at_rest.shear > 0.0;
  const double kappa = shears ? shear_factor(study.section) : 1.0;
  const BucklingStudy harmonic{
      {bond::Harmonic{bond::stiffness(study.material.law, r0), r0}, study.material.angle_stiffness},
      study.section,
      study.length};
  const auto of_engesser = [&](const BeamSection& s, double h) { return engesser(s, kappa, h); };
  const auto of_haringx = [&](const BeamSection& s, double h) { return haringx(s, kappa, h); };
  const double wave = std::numbers::pi / (static_cast<double>(study.length) * r0);
  const double of_euler = at_rest.bending() * wave * wave;
  const std::optional<Critical> expected = predicted(study, of_engesser);
  if (!expected) {
    throw NumericalFailure(
        fmt::format("the column of {} spacings never buckles: Engesser's critical load stays above its load "
                    "at any compression that the bond law knows",
                    study.length));
  }
  cost.finish("theories");
  const Critical found = measured(study, expected->strain);
  cost.finish("column");
  // What never buckles beside a column that does has no load.
  const auto load_beside = [&](const std::optional<Critical>& critical, const std::string& what) {
    if (critical) return critical->load;
    progress.warn(fmt::format("{} never buckles: it has no load to compare with", what));
    return std::numeric_limits<double>::quiet_NaN();
  };
  const double haringx_load =
      load_beside(predicted(study, of_haringx), "a Haringx column of the same section");
  const double harmonic_load = load_beside(predicted(harmonic, of_engesser),
                                           "a column of harmonic bonds of the same stiffness and length");
  seen.set("strain", found.strain);
  seen.set("load", found.load);
  seen.set("euler", of_euler);
  seen.set("engesser", expected->load);
  seen.set("haringx", haringx_load);
  seen.set("over_euler", found.load / of_euler);
  seen.set("euler_error", std::abs(found.load / of_euler - 1.0));
  seen.set("engesser_error", std::abs(found.load / expected->load - 1.0));
  seen.set("haringx_error", std::abs(found.load / haringx_load - 1.0));
  seen.set("over_harmonic", found.load / harmonic_load);
  seen.set("shear_factor", kappa);
}

}  // namespace

engine::Study read_buckling(const io::Table& top) {
  const solid::Material material = read_material_with_angles(top);
  const double rest_length = engine::read_derivation(top, material.law).rest_length;
  const io::Table t = top.table("buckling");
  const BucklingStudy study{.material = material,
                            .section = engine::read_solid_at_rest(top, material.law, rest_length),
                            .length = t.integer("length", 4, 10000)};
  if (study.length % 2 != 0) {
    t.fail("length", fmt::format("'length' is {}", study.length),
           "the middle section is fixed along the axis", "Give an even one");
  }
  return {.plan = engine::read_plan(
              top, {.law = material.law,
                    .solid = with_sections(study.section, study.length + 1),
                    .method = "root of the lowest eigenvalue of the compressed column's Hessian (Spectra)",
                    .by = {parts::Kind::Hessian}}),
          .declares = buckling_observations(),
          .run = std::bind_front(run_buckling, study)};
}

}  // namespace veriflex::measures
