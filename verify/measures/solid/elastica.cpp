#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analytic/exact_solid.hpp"
#include "base/reduce.hpp"
#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/for_all.hpp"
#include "measures/solid/beam_section.hpp"
#include "solid/statics.hpp"

namespace veriflex::measures {

namespace {

using observe::Observations;
using observe::Record;

struct ElasticaStudy {
  solid::Material material;
  scene::SolidSpec section;           // its length is set by `lengths`
  std::vector<std::int64_t> lengths;  // from the last clamped section to the loaded one, in spacings, rising
  std::int64_t clamped;               // sections that are clamped at the root
  std::vector<double> loads;          // P L^2/B, rising
};

struct Tip {
  double deflection, reach;  // over the length, mean of the last section
  double max_strain;         // of any bond, in magnitude
};

double distance(const Tip& tip, const analytic::ElasticaTip& exact) {
  return std::hypot(tip.deflection - exact.deflection, tip.reach - exact.reach);
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
std::vector<Tip> bend(const ElasticaStudy& study, const solid::Material& material, std::int64_t length) {
  const double spacing = spacing_of(study.section);
  const BeamSection section = section_of(material, study.section, spacing);
  const solid::Network network = scene::build(with_sections(study.section, length + study.clamped));
  const auto per_section = static_cast<Eigen::Index>(section.nodes);
  solid::FixedDofs held = solid::FixedDofs::Constant(network.node_count(), 3, false);
  held.topRows(per_section * study.clamped).setConstant(true);
  held.col(1).setConstant(true);  // bending in the x-z plane
  const double offset = root_offset(section, study.clamped, spacing);
  const double span = static_cast<double>(length) * spacing + offset;
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
      u = solid::equilibrium(material, network, u, held, load).u;
    }
    reached = wanted;
    const double x = u.col(0).tail(per_section).mean();
    const double z = (network.rest.col(2) + u.col(2)).tail(per_section).mean() - root;
    tips.push_back({x / span, z / span, max_strain(network, u)});
  }
  return tips;
}

double span_of(const ElasticaStudy& study, std::int64_t length) {
  const double spacing = spacing_of(study.section);
  return static_cast<double>(length) * spacing +
         root_offset(section_of(study.material, study.section, spacing), study.clamped, spacing);
}

double order(double coarse, double fine, double ratio) { return std::log(coarse / fine) / std::log(ratio); }

// The elastica itself, close enough for a curve.
Record exact_curve(double max_load) {
  Record record{"elastica_exact",
                "Tip of the elastica",
                {{"load", "P L^2/B", "1", "tip load", {}},
                 {"deflection", "", "1", "along the load, over the length", {}},
                 {"reach", "", "1", "along the undeformed axis, over the length", {}}}};
  constexpr int points = 60;
  for (int i = 0; i <= points; ++i) {
    const double load = max_load * i / points;
    const analytic::ElasticaTip tip = analytic::elastica_tip(load);
    record.append({load, tip.deflection, tip.reach});
  }
  return record;
}

void run(const ElasticaStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  // The last piece is the shortest beam of harmonic bonds of the same stiffness.
  const std::size_t lengths = study.lengths.size();
  const double spacing = spacing_of(study.section);
  const solid::Material same{bond::Harmonic{bond::stiffness(study.material.law, spacing), spacing},
                             study.material.angle_stiffness};
  std::vector<std::vector<Tip>> tips(lengths + 1);
  for_all(lengths + 1, "beams", progress, [&](std::size_t i) {
    const std::size_t piece = lengths - i;  // the longest first
    tips[piece] = piece == lengths ? bend(study, same, study.lengths.front())
                                   : bend(study, study.material, study.lengths[piece]);
  });
  cost.finish("beams");
  std::vector<analytic::ElasticaTip> exact;
  for (const double load : study.loads) exact.push_back(analytic::elastica_tip(load));
  Record record{"elastica",
                "Tip of the clamped beam under a dead load",
                {{"length", "L", "L", "with the offset of the root", {}},
                 {"load", "P L^2/B", "1", "tip load, with the lattice's own B", {}},
                 {"deflection", "", "1", "along the load, over the length", {}},
                 {"reach", "", "1", "along the undeformed axis, over the length", {}},
                 {"error", "", "1", "distance from the elastica's tip, over the length", {}},
                 {"max_strain", "", "1", "of any bond, in magnitude", {}}}};
  // The longest alone, one row per load, to be held against a curve.
  Record longest{"elastica_longest", "Tip of the longest beam under a dead load", record.columns};
  longest.columns.erase(longest.columns.begin());
  Record convergence{"convergence",
                     "Distance of the tip from the elastica's",
                     {{"spacing_over_length", "r0/L", "1", "", {}},
                      {"error_min_load", "", "1", "over the length", {}},
                      {"error_max_load", "", "1", "over the length", {}}}};
  for (std::size_t l = 0; l < lengths; ++l) {
    const double span = span_of(study, study.lengths[l]);
    for (std::size_t p = 0; p < study.loads.size(); ++p) {
      const Tip& tip = tips[l][p];
      record.append(
          {span, study.loads[p], tip.deflection, tip.reach, distance(tip, exact[p]), tip.max_strain});
    }
    if (l + 1 == lengths) {
      for (std::size_t p = 0; p < study.loads.size(); ++p) {
        const Tip& tip = tips[l][p];
        longest.append({study.loads[p], tip.deflection, tip.reach, distance(tip, exact[p]), tip.max_strain});
      }
    }
    convergence.append(
        {spacing / span, distance(tips[l].front(), exact.front()), distance(tips[l].back(), exact.back())});
  }
  const double ratio =
      span_of(study, study.lengths[lengths - 1]) / span_of(study, study.lengths[lengths - 2]);
  double extrapolated = 0.0;
  for (std::size_t p = 0; p < study.loads.size(); ++p) {
    const Tip& coarse = tips[lengths - 2][p];
    const Tip& fine = tips[lengths - 1][p];
    const double weight = 1.0 / (ratio * ratio - 1.0);
    const Tip limit{fine.deflection + weight * (fine.deflection - coarse.deflection),
                    fine.reach + weight * (fine.reach - coarse.reach), 0.0};
    extrapolated = worse(extrapolated, distance(limit, exact[p]));
  }
  const auto last_order = [&](const char* column) {
    const std::vector<double>& error = convergence.find(column)->values;
    return order(error[lengths - 2], error[lengths - 1], ratio);
  };
  const Tip& of_law = tips.front().back();
  const Tip& of_springs = tips.back().back();
  seen.metrics = {
      {"tip_error", distance(tips[lengths - 1].back(), exact.back()), "1",
       "distance from the elastica's tip over the length, longest beam, largest load"},
      {"order_min_load", last_order("error_min_load"), "1", "order in r0/L, last two lengths"},
      {"order_max_load", last_order("error_max_load"), "1", "order in r0/L, last two lengths"},
      {"extrapolated_error", extrapolated, "1",
       "the same distance after Richardson's extrapolation of order 2, worst of the loads"},
      {"shortest_tip_error", distance(of_law, exact.back()), "1", "shortest beam, largest load"},
      {"shortest_strain", of_law.max_strain, "1", "largest strain of a bond there"},
      {"departure_from_harmonic",
       std::hypot(of_law.deflection - of_springs.deflection, of_law.reach - of_springs.reach), "1",
       "shortest beam, largest load: distance of its tip from that of harmonic bonds of the same stiffness, "
       "over the length"}};
  seen.records = {record, exact_curve(study.loads.back()), convergence, longest};
}

}  // namespace

engine::Study read_elastica(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const double rest_length = engine::read_derivation(top, law).rest_length;
  const io::Table t = top.table("elastica");
  ElasticaStudy study{.material = {law, engine::read_angle_stiffness(top)},
                      .section = engine::read_solid_at_rest(top, law, rest_length),
                      .lengths = t.integers("lengths"),
                      .clamped = t.integer("clamped", 1, 2),
                      .loads = t.numbers("loads")};
  if (!(study.material.angle_stiffness > 0.0)) {
    top.table("bond").fail("law", "a beam of bonds alone", "without angles it has no shear stiffness",
                           "Add [angle] stiffness");
  }
  if (study.lengths.size() < 2 || study.lengths.front() < 2 || study.lengths.back() > 100000) {
    t.fail("lengths", "fewer than two lengths, or one below 2 or above 100000",
           "an order needs two, a beam some sections", "Give for example [20, 40]");
  }
  for (std::size_t i = 1; i < study.lengths.size(); ++i) {
    if (study.lengths[i] <= study.lengths[i - 1])
      t.fail("lengths", "lengths do not rise", "the order is taken between neighbours", "Sort them");
  }
  if (study.loads.empty() || !(study.loads.front() > 0.0) || study.loads.back() > 100.0) {
    t.fail("loads", "no load, or one not between 0 and 100",
           "it is P L^2/B; beyond 100 the tip points along the load", "Give for example [1, 5, 10]");
  }
  for (std::size_t i = 1; i < study.loads.size(); ++i) {
    if (study.loads[i] <= study.loads[i - 1])
      t.fail("loads", "loads do not rise", "each is reached from the one before", "Sort them");
  }
  const scene::SolidSpec longest = with_sections(study.section, study.lengths.back() + study.clamped);
  const auto* chain = std::get_if<solid::Block>(&longest.shape);
  if (study.clamped == 1 && chain != nullptr && chain->nodes[0] == 1) {
    t.fail("clamped", "'clamped' is 1",
           "one clamped layer does not fix the direction of a body one node thick", "Use 2");
  }
  return {.plan = engine::read_plan(
              top, {.law = law,
                    .solid = longest,
                    .method = "Newton's method, load by load; first sections clamped, last one loaded",
                    .by = {parts::Kind::Statics}}),
          .measures = {"tip_error", "order_min_load", "order_max_load", "extrapolated_error",
                       "shortest_tip_error", "shortest_strain", "departure_from_harmonic",
                       "elastica_longest.load", "elastica_longest.deflection", "elastica_longest.reach",
                       "elastica_longest.error", "elastica_longest.max_strain"},
          .run = [study](Observations& seen, Progress& progress, engine::Cost& cost) {
            run(study, seen, progress, cost);
          }};
}

}  // namespace veriflex::measures
