#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "base/reduce.hpp"
#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/bond/law_records.hpp"
#include "measures/drivers.hpp"
#include "measures/for_all.hpp"
#include "measures/solid/read_statics.hpp"
#include "solid/tension_test.hpp"

namespace veriflex::measures {

namespace {

using observe::Metric;
using observe::Observations;
using observe::Record;
using solid::Block;
using solid::Pulled;

enum class Control { displacement, load };

struct TensileStudy {
  bond::AnyLaw law;
  bond::Derivation derivation;
  Block block;
  bool lateral_held;
  Control control;
  std::vector<double> points;  // strains, or stresses under load control  [1] or [M L^-1 T^-2]
  double modulus_strain;       // the largest strain of the modulus' differences  [1]
  int modulus_levels;          // how often it is halved
  solid::Statics statics;

  bool has_faces() const { return block.nodes[0] > 1 && block.nodes[1] > 1; }
};

Observations tensile_observations(const TensileStudy& study) {
  Observations all;
  if (!study.points.empty()) {
    all.records.push_back(
        {"stress_strain",
         "Static pull along the axis",
         {{"strain", "", "1", "change of length over undeformed length", {}},
          {"stress", "", "M L^-1 T^-2", "axial force over the undeformed section n m r0^2", {}},
          {"secant_ratio", "", "1", "stress / (E strain)", {}},
          {"tangent_ratio", "", "1", "U''(r)/U''(r_eq) at the mean bond length", {}},
          {"iterations", "", "1", "Newton steps, or evaluations of another method", {}},
          {"residual",
           "",
           "1",
           "largest out-of-balance force over the largest tension or that of a strain of 1e-3",
           {}}}});
    all.metrics.push_back(
        {"max_residual",
         {},
         "1",
         "largest out-of-balance force over the largest tension or that of a strain of 1e-3, all states"});
  }
  all.records.push_back(
      {"convergence",
       "Error of the modulus against the strain it is measured at",
       {{"strain_step", "h", "1", "strain of the difference quotient", {}},
        {"error_one_sided", "", "1", "relative error of (stress(h) - stress(0))/h", {}},
        {"error_central", "", "1", "relative error of (stress(h) - stress(-h))/2h", {}},
        {"error_richardson", "", "1", "relative error extrapolated from this and all larger h", {}}}});
  all.records.push_back(validity_record());
  all.metrics.insert(
      all.metrics.end(),
      {{"young_modulus",
        {},
        "M L^-1 T^-2",
        "stress over strain, central differences extrapolated to zero strain"},
       {"derived_young_modulus", {}, "M L^-1 T^-2", "U''(r_eq)/r_eq of the bond law"},
       {"modulus_deviation", {}, "1", "relative departure of the bar's modulus from the bond law's"},
       {"order_one_sided", {}, "1", "order of the error in the strain, last two levels"},
       {"order_central", {}, "1", "order of the error in the strain, last two levels"}});
  if (study.has_faces()) {
    all.metrics.push_back(
        {"outer_face_ratio", {}, "1", "modulus with the area (n-1)(m-1) r0^2, over the law's"});
  }
  return all;
}

// Adds the curve to what was seen, state by state.
void pull_along_curve(const TensileStudy& study, Progress& progress, Observations& seen) {
  Record& record = seen.open("stress_strain");
  const bool displaced = study.control == Control::displacement;
  const bond::Derivation& d = study.derivation;
  std::vector<Pulled> states(study.points.size());
  const auto pull = [&](std::size_t i) {
    try {
      states[i] = displaced ? solid::pull_to_strain(study.law, study.block, study.lateral_held,
                                                    study.points[i], study.statics)
                            : solid::pull_with_stress(study.law, study.block, study.lateral_held,
                                                      study.points[i], study.statics);
    } catch (const NumericalFailure& failure) {
      throw failure.at(fmt::format("at {} {}", displaced ? "strain" : "stress", study.points[i]));
    }
  };
  for_all(states.size(), "curve", progress, pull, [&](std::size_t i) {
    const Pulled& state = states[i];
    const double secant = state.strain == 0.0 ? std::numeric_limits<double>::quiet_NaN()
                                              : state.stress / (d.young_modulus * state.strain);
    record.append({state.strain, state.stress, secant,
                   bond::stiffness(study.law, d.rest_length * (1.0 + state.strain)) / d.stiffness,
                   static_cast<double>(state.iterations), state.residual});
  });
  const std::vector<double>& residual = record.find("residual")->values;
  seen.set("max_residual", std::accumulate(residual.begin(), residual.end(), 0.0, worse));
}

// Difference quotients of the stress at strains h, h/2, h/4, ...
struct Differences {
  std::vector<double> strain, one_sided, central;
  double extrapolated;  // central ones, by Richardson to strain zero
};

// Central differences have an error series in h^2, h^4, ...: each column of the tableau removes one term.
double richardson(std::vector<double> values) {
  double factor = 1.0;
  while (values.size() > 1) {
    factor *= 4.0;
    for (std::size_t i = 0; i + 1 < values.size(); ++i)
      values[i] = (factor * values[i + 1] - values[i]) / (factor - 1.0);
    values.pop_back();
  }
  return values.front();
}

Differences modulus_at_rest(const TensileStudy& study, Progress& progress) {
  const auto levels = static_cast<std::size_t>(study.modulus_levels);
  const auto strain = [&](std::size_t level) {
    return std::ldexp(study.modulus_strain, -static_cast<int>(level));
  };
  std::vector<Pulled> states(2 * levels + 1);
  for_all(states.size(), "modulus", progress, [&](std::size_t i) {
    const double sign = i % 2 == 0 ? 1.0 : -1.0;
    states[i] = solid::pull_to_strain(study.law, study.block, study.lateral_held,
                                      i == 2 * levels ? 0.0 : sign * strain(i / 2), study.statics);
  });
  const double at_rest = states.back().stress;
  Differences d{};
  for (std::size_t level = 0; level < levels; ++level) {
    const double h = strain(level);
    const double up = states[2 * level].stress;
    const double down = states[2 * level + 1].stress;
    d.strain.push_back(h);
    d.one_sided.push_back((up - at_rest) / h);
    d.central.push_back((up - down) / (2.0 * h));
  }
  d.extrapolated = richardson(d.central);
  return d;
}

void record_convergence(const Differences& d, double young_modulus, Record& record) {
  for (std::size_t i = 0; i < d.strain.size(); ++i) {
    const std::vector<double> so_far(d.central.begin(),
                                     d.central.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    record.append({d.strain[i], std::abs(d.one_sided[i] / young_modulus - 1.0),
                   std::abs(d.central[i] / young_modulus - 1.0),
                   std::abs(richardson(so_far) / young_modulus - 1.0)});
  }
}

// The order at which the last two errors fall; not a number where they are at the level of rounding.
double order(const std::vector<double>& errors) {
  const double coarse = errors[errors.size() - 2];
  const double fine = errors[errors.size() - 1];
  if (fine < 1e-11 || coarse < 1e-11) return std::numeric_limits<double>::quiet_NaN();
  return std::log2(coarse / fine);
}

void run_tensile(const TensileStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  if (!study.points.empty()) {
    pull_along_curve(study, progress, seen);
    cost.finish("curve");
  }
  record_validity(study.derivation, seen.open("validity"));
  const double derived = study.derivation.young_modulus;
  const Differences differences = modulus_at_rest(study, progress);
  cost.finish("modulus");
  Record& convergence = seen.open("convergence");
  record_convergence(differences, derived, convergence);
  seen.set("young_modulus", differences.extrapolated);
  seen.set("derived_young_modulus", derived);
  seen.set("modulus_deviation", std::abs(differences.extrapolated / derived - 1.0));
  seen.set("order_one_sided", order(convergence.find("error_one_sided")->values));
  seen.set("order_central", order(convergence.find("error_central")->values));
  if (!study.has_faces()) return;
  const auto n = static_cast<double>(study.block.nodes[0]), m = static_cast<double>(study.block.nodes[1]);
  seen.set("outer_face_ratio", differences.extrapolated * n * m / ((n - 1.0) * (m - 1.0)) / derived);
}

}  // namespace

engine::Study read_tensile(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const bond::Derivation derivation = engine::read_derivation(top, law);
  const io::Table t = top.table("tensile");
  const scene::SolidSpec spec = engine::read_solid(top, law, derivation.rest_length);
  const Block* block = std::get_if<Block>(&spec.shape);
  if (block == nullptr || block->spacing != derivation.rest_length || spec.angle_stiffness != 0.0) {
    top.table("solid").fail(
        "shape", "the tensile driver pulls pairs, chains and bars of bonds at their rest length",
        "it needs neither rods nor angles: lateral contraction is zero", "Leave out [angle] and 'spacing'");
  }
  TensileStudy study{
      .law = law,
      .derivation = derivation,
      .block = *block,
      .lateral_held = top.table("solid").choice("lateral", {"fixed", "free"}) == "fixed",
      .control =
          t.choice("control", {"displacement", "load"}) == "load" ? Control::load : Control::displacement,
      .points = {},
      // Inside what is smooth around rest: differences across a kink have another limit.
      .modulus_strain = t.number("modulus_strain",
                                 std::min(0.004, 0.5 * derivation.smooth_radius / derivation.rest_length)),
      .modulus_levels = t.has("modulus_levels") ? static_cast<int>(t.integer("modulus_levels", 2, 12)) : 4,
      .statics = read_statics(t)};
  const std::string points = study.control == Control::displacement ? "strains" : "stresses";
  if (t.has(points)) study.points = t.numbers(points);
  const Interval domain = bond::domain(law);
  const auto admitted = [&](double strain) {
    return domain.contains(derivation.rest_length * (1.0 + strain));
  };
  for (const double strain : study.control == Control::displacement ? study.points : std::vector<double>{}) {
    if (!admitted(strain)) {
      t.fail("strains", fmt::format("strain {} is outside the domain of {}", strain, bond::name_of(law)),
             fmt::format("bond lengths must lie between {} and {}, the rest length is {}", domain.lo,
                         domain.hi, derivation.rest_length),
             "Leave that strain out");
    }
  }
  if (!(study.modulus_strain > 0.0) || !admitted(study.modulus_strain) || !admitted(-study.modulus_strain)) {
    t.fail("modulus_strain", fmt::format("'modulus_strain' is {}", study.modulus_strain),
           "it must be positive, and bonds strained by it both ways inside the law's domain",
           "Use about 0.004");
  }
  return {.plan = engine::read_plan(
              top, {.law = law,
                    .solid = spec,
                    .method = fmt::format("{}; ends fixed axially, lateral displacements {}",
                                          row_of(solid::relaxations, study.statics.method).text,
                                          study.lateral_held ? "fixed (exact: C12 = 0)" : "free"),
                    .by = parts_of(study.statics)}),
          .declares = tensile_observations(study),
          .run = std::bind_front(run_tensile, study)};
}

}  // namespace veriflex::measures
