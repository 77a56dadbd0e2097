#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "base/reduce.hpp"
#include "base/root.hpp"
#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/for_all.hpp"
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
using observe::Record;

struct BucklingStudy {
  solid::Material material;
  scene::SolidSpec section;           // its length is set by `lengths`
  std::vector<std::int64_t> lengths;  // in spacings, even, rising
};

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
std::optional<Critical> predicted(const BucklingStudy& study, std::int64_t length,
                                  const LoadOfSection& critical) {
  const double r0 = spacing_of(study.section);
  const double nodes = section_of(study.material, study.section, r0).nodes;
  const auto excess = [&](double strain) {
    const double axial = r0 * (1.0 + strain);
    return load_at(study, nodes, strain) -
           critical(section_of(study.material, study.section, axial), wave_number(length, axial));
  };
  const std::optional<double> strain = first_passage(excess, (bond::domain(study.material.law).lo - r0) / r0);
  if (!strain) return std::nullopt;
  return Critical{*strain, load_at(study, nodes, *strain)};
}

// The strain at which the lowest eigenvalue of the compressed network's Hessian passes zero.
Critical measured(const BucklingStudy& study, std::int64_t length, double expected) {
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

void run(const BucklingStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  const double r0 = spacing_of(study.section);
  const BeamSection at_rest = section_of(study.material, study.section, r0);
  const bool shears = at_rest.shear > 0.0;
  const double kappa = shears ? shear_factor(study.section) : 1.0;
  const BucklingStudy harmonic{
      {bond::Harmonic{bond::stiffness(study.material.law, r0), r0}, study.material.angle_stiffness},
      study.section,
      study.lengths};
  const auto of_engesser = [&](const BeamSection& s, double h) { return engesser(s, kappa, h); };
  const auto of_haringx = [&](const BeamSection& s, double h) { return haringx(s, kappa, h); };
  struct Row {
    double euler;
    Critical engesser, found;
    std::optional<Critical> haringx, of_springs;
  };
  std::vector<Row> rows(study.lengths.size());
  for_all(rows.size(), "columns", progress, [&](std::size_t piece) {
    const std::size_t i = rows.size() - 1 - piece;  // the longest first
    const std::int64_t length = study.lengths[i];
    const double wave = std::numbers::pi / (static_cast<double>(length) * r0);
    Row& row = rows[i];
    row.euler = at_rest.bending() * wave * wave;
    const std::optional<Critical> expected = predicted(study, length, of_engesser);
    if (!expected) {
      throw NumericalFailure(fmt::format(
          "the column of {} spacings never buckles: Engesser's critical load stays above its load at any "
          "compression that the bond law knows",
          length));
    }
    row.engesser = *expected;
    row.haringx = predicted(study, length, of_haringx);
    row.of_springs = predicted(harmonic, length, of_engesser);
    row.found = measured(study, length, row.engesser.strain);
  });
  cost.finish("columns");
  Record record{
      "buckling",
      "Critical load of the pinned column",
      {{"length", "L", "L", "at rest, between the pinned sections", {}},
       {"strain", "", "1", "of the bonds along the axis at the critical load", {}},
       {"load", "P", "M L T^-2", "critical load", {}},
       {"euler", "", "M L T^-2", "pi^2 B/L^2 with the lattice's own B and L at rest", {}},
       {"engesser", "", "M L T^-2", "with shear, thrust along the axis, compressed section", {}},
       {"haringx", "", "M L T^-2", "with shear, thrust normal to the sections, compressed section", {}},
       {"over_harmonic",
        "",
        "1",
        "over Engesser's load of harmonic bonds of the same stiffness; not a number where these never buckle",
        {}},
       {"spacings", "n", "1", "the length in spacings", {}}}};
  Record convergence{
      "convergence",
      "Departure of the critical load",
      {{"spacing_over_length", "r0/L", "1", "", {}}, {"error_euler", "", "1", "from Euler's load", {}}}};
  // What never buckles beside a column that does has no load.
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const auto load_of = [](const std::optional<Critical>& critical) {
    return critical ? critical->load : none;
  };
  double worst_engesser = 0.0;
  double worst_haringx = 0.0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    const double load = row.found.load;
    record.append({static_cast<double>(study.lengths[i]) * r0, row.found.strain, load, row.euler,
                   row.engesser.load, load_of(row.haringx), load / load_of(row.of_springs),
                   static_cast<double>(study.lengths[i])});
    convergence.append({1.0 / static_cast<double>(study.lengths[i]), std::abs(load / row.euler - 1.0)});
    worst_engesser = worse(worst_engesser, std::abs(load / row.engesser.load - 1.0));
    worst_haringx = worse(worst_haringx, std::abs(load / load_of(row.haringx) - 1.0));
  }
  const std::size_t n = rows.size();
  const double ratio = static_cast<double>(study.lengths[n - 1]) / static_cast<double>(study.lengths[n - 2]);
  const auto order = [&](auto error) { return std::log(error(n - 2) / error(n - 1)) / std::log(ratio); };
  const auto over_euler = [&](std::size_t i) { return rows[i].found.load / rows[i].euler; };
  const auto off_euler = [&](std::size_t i) { return std::abs(over_euler(i) - 1.0); };
  const auto off_engesser = [&](std::size_t i) {
    return std::abs(rows[i].found.load / rows[i].engesser.load - 1.0);
  };
  seen.metrics = {
      {"euler_error", off_euler(n - 1), "1", "departure from Euler's load, longest column"},
      {"order_euler", order(off_euler), "1", "order in r0/L of that departure, last two columns"},
      {"extrapolated_error",
       std::abs(over_euler(n - 1) + (over_euler(n - 1) - over_euler(n - 2)) / (ratio * ratio - 1.0) - 1.0),
       "1", "departure from Euler's load after Richardson's extrapolation of order 2"},
      {"engesser_error", worst_engesser, "1", "departure from Engesser's load, worst column"},
      {"order_engesser", order(off_engesser), "1", "order in r0/L of that departure, last two columns"},
      {"shear_factor", kappa, "1", "kappa: shear stiffness of the section over GA; 1 without shear"},
      {"max_strain", -rows[0].found.strain, "1", "compression of the shortest column when it buckles"}};
  if (std::isnan(worst_haringx)) {
    progress.warn("a Haringx column of the same section never buckles: no haringx_error");
  } else {
    seen.metrics.push_back(
        {"haringx_error", worst_haringx, "1", "departure from Haringx's load, worst column"});
  }
  if (rows[0].of_springs) {
    seen.metrics.push_back({"over_harmonic", rows[0].found.load / rows[0].of_springs->load, "1",
                            "load of the shortest column over that of harmonic bonds of the same stiffness"});
  } else {
    progress.warn(
        "a column of harmonic bonds of the same stiffness, as short as the shortest, never buckles: no "
        "over_harmonic");
  }
  seen.records = {record, convergence};
}

}  // namespace

engine::Study read_buckling(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const double rest_length = engine::read_derivation(top, law).rest_length;
  const io::Table t = top.table("buckling");
  const BucklingStudy study{.material = {law, engine::read_angle_stiffness(top)},
                            .section = engine::read_solid_at_rest(top, law, rest_length),
                            .lengths = t.integers("lengths")};
  if (!(study.material.angle_stiffness > 0.0)) {
    top.table("bond").fail("law", "a column of bonds alone", "without angles it buckles under any load",
                           "Add [angle] stiffness");
  }
  if (study.lengths.size() < 2 || study.lengths.front() < 4 || study.lengths.back() > 10000) {
    t.fail("lengths", "fewer than two lengths, or one not between 4 and 10000",
           "an order needs two, a column some sections", "Give for example [16, 32]");
  }
  for (std::size_t i = 0; i < study.lengths.size(); ++i) {
    if (study.lengths[i] % 2 != 0 || (i > 0 && study.lengths[i] <= study.lengths[i - 1])) {
      t.fail("lengths", "lengths are odd or do not rise",
             "the middle section is fixed along the axis, and the order is taken between neighbours",
             "Give even lengths, sorted");
    }
  }
  return {.plan = engine::read_plan(
              top, {.law = law,
                    .solid = with_sections(study.section, study.lengths.back() + 1),
                    .method = "root of the lowest eigenvalue of the compressed column's Hessian (Spectra)",
                    .by = {parts::Kind::Hessian}}),
          .measures = {"euler_error", "order_euler", "extrapolated_error", "engesser_error", "order_engesser",
                       "haringx_error", "shear_factor", "max_strain", "over_harmonic", "buckling.spacings",
                       "buckling.strain", "buckling.load", "buckling.euler", "buckling.engesser",
                       "buckling.haringx", "buckling.over_harmonic"},
          .run = [study](Observations& seen, Progress& progress, engine::Cost& cost) {
            run(study, seen, progress, cost);
          }};
}

}  // namespace veriflex::measures
