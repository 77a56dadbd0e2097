#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <numeric>

#include "analytic/exact_solid.hpp"
#include "base/reduce.hpp"
#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/for_all.hpp"
#include "measures/solid/beam_section.hpp"
#include "measures/solid/read_statics.hpp"

namespace veriflex::measures {

namespace {

using observe::Observations;

struct ElasticaStudy {
  solid::Material material;
  scene::SolidSpec section;   // its length is set by `length`
  std::int64_t length;        // from the last clamped section to the loaded one, in spacings
  std::int64_t clamped;       // sections that are clamped at the root
  std::vector<double> loads;  // P L^2/B, rising
  solid::Statics statics;

  bool is_harmonic() const { return bond::name_of(material.law) == "harmonic"; }
};

Observations elastica_observations(const ElasticaStudy& study) {
  Observations all;
  all.records = {{"elastica",
                  "Tip of the clamped beam under a dead load",
                  {{"load", "P L^2/B", "1", "tip load, with the lattice's own B", {}},
                   {"deflection", "", "1", "along the load, over the length with the offset of the root", {}},
                   {"reach", "", "1", "along the undeformed axis, over that length", {}},
                   {"error", "", "1", "distance from the elastica's tip, over the length", {}},
                   {"max_strain", "", "1", "of any bond, in magnitude", {}}}},
                 {"elastica_exact",
                  "Tip of the elastica",
                  {{"load", "P L^2/B", "1", "tip load", {}},
                   {"deflection", "", "1", "along the load, over the length", {}},
                   {"reach", "", "1", "along the undeformed axis, over the length", {}}}}};
  all.metrics = {{"spacing_over_length", {}, "1", "r0/L, with the offset of the root"},
                 {"error_min_load", {}, "1", "distance from the elastica's tip over the length, first load"},
                 {"error_max_load", {}, "1", "the same, last load"},
                 {"max_error", {}, "1", "the same, worst of the loads"},
                 {"max_strain", {}, "1", "of any bond under the last load, in magnitude"}};
  if (!study.is_harmonic()) {
    all.metrics.push_back({"departure_from_harmonic",
                           {},
                           "1",
                           "distance of the tip from that of harmonic bonds of the same stiffness under the "
                           "last load, over the length"});
  }
  return all;
}

struct Tip {
  double deflection, reach;  // over the length, mean of the last section
  double max_strain;         // of any bond, in magnitude
};

double distance(const Tip& tip, const auto& other) {
  return std::hypot(tip.deflection - other.deflection, tip.reach - other.reach);
}

// By how much longer than from its last clamped section the beam behaves, to first order. Near the clamp the
// straight angles do not act as in the middle: with one clamped section there is none at it, with two it
// turns from a direction that is fixed half a spacing too early. In pure bending with moments K of the
// springs between the turns p of neighbouring sections, S of the straight angles between those c of
// neighbouring lines along z, and R of the right angles between both,
//   K (p[i+1] - 2 p[i] + p[i-1]) + R (c[i+1/2] + c[i-1/2] - 2 p[i]) = 0
//   S (c[i+3/2] - 2 c[i+1/2] + c[i-1/2]) + R (p[i+1] + p[i] - 2 c[i+1/2]) = 0
// has a part that decays like l^i, l + 1/l - 2 = (2 R (K + S) + R^2)/(K S); the conditions at the clamp are
// p[0] = 0 and c[-1/2] = c[1/2] or 0, and far away p[i] is the curvature times i r0 + the offset.
double root_offset(const BeamSection& section, std::int64_t clamped, double spacing) {
  if (section.right_bending == 0.0) return 0.5 * spacing;  // straight angles alone, two clamped sections
  const double springs = section.spring_bending / spacing;
  const double straight = section.straight_bending / spacing;
  const double right = 2.0 * section.right_bending / spacing;
  const double half = 1.0 + 0.5 * (2.0 * right * (springs + straight) + right * right) / (springs * straight);
  const double decay = 1.0 / (half + std::sqrt(half * half - 1.0));
  const double weight = straight * (1.0 + decay) / (2.0 * springs + right);
  return clamped == 1 ? spacing * weight / (1.0 - decay) : 0.5 * spacing * weight / (1.0 + weight);
}

double max_strain(const solid::Network& network, const Positions& u) {
  double strain = 0.0;
  for (std::size_t b = 0; b < network.bonds.size(); ++b) {
    const solid::Bond& bond = network.bonds[b];
    const auto vector = network.vectors.row(static_cast<Eigen::Index>(b));
    const double r = (vector + (u.row(bond.second) - u.row(bond.first))).norm();
    strain = worse(strain, std::abs(r / network.spacing - 1.0));
  }
  return strain;
}

// The tip under each load, one after the other, each reached in steps small enough for Newton's method.
std::vector<Tip> bend(const ElasticaStudy& study, const solid::Material& material) {
  const double spacing = spacing_of(study.section);
  const BeamSection section = section_of(material, study.section, spacing);
  const solid::Network network = scene::build(with_sections(study.section, study.length + study.clamped));
  const auto per_section = static_cast<Eigen::Index>(section.nodes);
  solid::FixedDofs held = solid::FixedDofs::Constant(network.node_count(), 3, false);
  held.topRows(per_section * study.clamped).setConstant(true);
  held.col(1).setConstant(true);  // bending in the x-z plane
  const double offset = root_offset(section, study.clamped, spacing);
  const double span = static_cast<double>(study.length) * spacing + offset;
  const double root = static_cast<double>(study.clamped - 1) * spacing - offset;
  const double unit = section.bending() / (span * span * section.nodes);
  Positions u = Positions::Zero(network.node_count(), 3);
  std::vector<Tip> tips;
  double reached = 0.0;
  for (const double wanted : study.loads) {
    const double steps = std::ceil(wanted - reached);
    for (double step = 1.0; step <= steps; ++step) {
      Positions load = Positions::Zero(network.node_count(), 3);
      load.col(0).tail(per_section).setConstant(unit * (reached + (wanted - reached) * step / steps));
      u = solid::relax(study.statics, material, network, u, held, load).u;
    }
    reached = wanted;
    const double x = u.col(0).tail(per_section).mean();
    const double z = (network.rest.col(2) + u.col(2)).tail(per_section).mean() - root;
    tips.push_back({x / span, z / span, max_strain(network, u)});
  }
  return tips;
}

// The elastica itself, close enough for a curve.
void record_exact(double max_load, observe::Record& record) {
  constexpr int points = 60;
  for (int i = 0; i <= points; ++i) {
    const double load = max_load * i / points;
    const analytic::ElasticaTip tip = analytic::elastica_tip(load);
    record.append({load, tip.deflection, tip.reach});
  }
}

void run_elastica(const ElasticaStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  const double spacing = spacing_of(study.section);
  const solid::Material same{bond::Harmonic{bond::stiffness(study.material.law, spacing), spacing},
                             study.material.angle_stiffness};
  std::vector<Tip> tips, of_springs;
  for_all(study.is_harmonic() ? 1 : 2, "beams", progress,
          [&](std::size_t i) { (i == 0 ? tips : of_springs) = bend(study, i == 0 ? study.material : same); });
  cost.finish("beams");
  observe::Record& record = seen.open("elastica");
  for (std::size_t p = 0; p < study.loads.size(); ++p) {
    const Tip& tip = tips[p];
    record.append({study.loads[p], tip.deflection, tip.reach,
                   distance(tip, analytic::elastica_tip(study.loads[p])), tip.max_strain});
  }
  record_exact(study.loads.back(), seen.open("elastica_exact"));
  const std::vector<double>& error = record.find("error")->values;
  const double offset =
      root_offset(section_of(study.material, study.section, spacing), study.clamped, spacing);
  seen.set("spacing_over_length", spacing / (static_cast<double>(study.length) * spacing + offset));
  seen.set("error_min_load", error.front());
  seen.set("error_max_load", error.back());
  seen.set("max_error", std::accumulate(error.begin(), error.end(), 0.0, worse));
  seen.set("max_strain", tips.back().max_strain);
  if (!study.is_harmonic()) seen.set("departure_from_harmonic", distance(tips.back(), of_springs.back()));
}

}  // namespace

engine::Study read_elastica(const io::Table& top) {
  const solid::Material material = read_material_with_angles(top);
  const double rest_length = engine::read_derivation(top, material.law).rest_length;
  const io::Table t = top.table("elastica");
  const ElasticaStudy study{.material = material,
                            .section = engine::read_solid_at_rest(top, material.law, rest_length),
                            .length = t.integer("length", 2, 100000),
                            .clamped = t.integer("clamped", 1, 2),
                            .loads = t.numbers("loads"),
                            .statics = read_statics(t)};
  if (study.loads.empty() || !(study.loads.front() > 0.0) || study.loads.back() > 100.0) {
    t.fail("loads", "no load, or one not between 0 and 100",
           "it is P L^2/B; beyond 100 the tip points along the load", "Give for example [1, 5, 10]");
  }
  for (std::size_t i = 1; i < study.loads.size(); ++i) {
    if (study.loads[i] <= study.loads[i - 1])
      t.fail("loads", "loads do not rise", "each is reached from the one before", "Sort them");
  }
  const scene::SolidSpec beam = with_sections(study.section, study.length + study.clamped);
  const auto* chain = std::get_if<solid::Block>(&beam.shape);
  if (study.clamped == 1 && chain != nullptr && chain->nodes[0] == 1) {
    t.fail("clamped", "'clamped' is 1",
           "one clamped layer does not fix the direction of a body one node thick", "Use 2");
  }
  return {.plan = engine::read_plan(
              top, {.law = material.law,
                    .solid = beam,
                    .method = fmt::format("{}, load by load; first sections clamped, last one loaded",
                                          row_of(solid::relaxations, study.statics.method).text),
                    .by = parts_of(study.statics)}),
          .declares = elastica_observations(study),
          .run = std::bind_front(run_elastica, study)};
}

}  // namespace veriflex::measures
