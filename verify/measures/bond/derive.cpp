#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/bond/law_records.hpp"
#include "measures/drivers.hpp"

namespace veriflex::measures {

namespace {

using observe::Metric;
using observe::Observations;
using observe::Record;

struct DeriveStudy {
  bond::AnyLaw law;
  bond::Derivation derivation;
  std::optional<double> rounded_rest_length;  // a published, rounded r_eq to evaluate at  [L]
};

// Lengths from 25 % compression to just below the law's limit (or 60 % extension), rising; each kink appears
// twice, just below it and at it.
std::vector<double> sampled_lengths(const DeriveStudy& study) {
  const bond::Derivation& d = study.derivation;
  const Interval domain = bond::domain(study.law);
  const double lo = std::max(0.75 * d.rest_length, domain.lo + 0.02 * (d.rest_length - domain.lo));
  const double hi =
      std::isfinite(domain.hi) ? domain.hi - 0.02 * (domain.hi - d.rest_length) : 1.6 * d.rest_length;
  constexpr int points = 400;
  std::vector<double> lengths;
  for (int i = 0; i <= points; ++i) lengths.push_back(lo + (hi - lo) * i / points);
  for (const bond::Kink& kink : d.kinks) {
    if (kink.length < lo || kink.length > hi) continue;
    lengths.push_back(std::nextafter(kink.length, 0.0));
    lengths.push_back(kink.length);
  }
  lengths.push_back(d.rest_length);
  std::sort(lengths.begin(), lengths.end());
  return lengths;
}

Record potential_record(const DeriveStudy& study) {
  const bond::Derivation& d = study.derivation;
  Record record{
      "potential",
      "Energy of one bond and its derivatives",
      {{"length", "r", "L", "length of the bond", {}},
       {"strain", "", "1", "r/r_eq - 1", {}},
       {"energy", "U", "M L^2 T^-2", "energy of the bond", {}},
       {"tension", "U'", "M L T^-2", "dU/dr, positive when the bond pulls", {}},
       {"stiffness", "U''", "M T^-2", "d2U/dr2", {}},
       {"energy_harmonic", "", "M L^2 T^-2", "harmonic bond of the same rest length and stiffness", {}}}};
  for (const double r : sampled_lengths(study)) {
    const double extension = r - d.rest_length;
    record.append({r, extension / d.rest_length, bond::energy(study.law, r), bond::tension(study.law, r),
                   bond::stiffness(study.law, r), 0.5 * d.stiffness * extension * extension});
  }
  return record;
}

Record moduli_record(const DeriveStudy& study) {
  const bond::Derivation& d = study.derivation;
  Record record{"moduli",
                "Secant and tangent modulus over their value at rest",
                {{"strain", "", "1", "r/r_eq - 1", {}},
                 {"secant_ratio", "", "1", "stress / (E strain)", {}},
                 {"tangent_ratio", "", "1", "U''(r)/U''(r_eq)", {}}}};
  for (const double r : sampled_lengths(study)) {
    const double extension = r - d.rest_length;
    const double secant = extension == 0.0 ? 1.0 : bond::tension(study.law, r) / (d.stiffness * extension);
    for (const bond::Kink& kink : d.kinks) {
      constexpr double gap = std::numeric_limits<double>::quiet_NaN();  // the tangent jumps here
      if (r == kink.length) record.append({kink.strain, secant, gap});
    }
    record.append({extension / d.rest_length, secant, bond::stiffness(study.law, r) / d.stiffness});
  }
  return record;
}

Record kinks_record(const bond::Derivation& d) {
  Record record{"kinks",
                "Lengths at which the stiffness jumps",
                {{"length", "r", "L", "length of the bond", {}},
                 {"strain", "", "1", "r/r_eq - 1", {}},
                 {"tension_jump", "", "M L T^-2", "dU/dr above minus below", {}},
                 {"tangent_below", "", "1", "U''/U''(r_eq), limit from below", {}},
                 {"tangent_above", "", "1", "U''/U''(r_eq), limit from above", {}}}};
  for (const bond::Kink& k : d.kinks) {
    record.append({k.length, k.strain, k.tension_jump, k.tangent_below, k.tangent_above});
  }
  return record;
}

/// What an accuracy of r_eq and E costs: the best length so far, as far as the search has come.
Record search_record(const DeriveStudy& study) {
  Record record{"root_search",
                "Error of the rest length and of Young's modulus against evaluations of the tension",
                {{"evaluations", "", "1", "of the tension so far", {}},
                 {"rest_length_error", "", "1", "of the length with the least tension so far, relative", {}},
                 {"young_modulus_error", "", "1", "of U''(r)/r there, relative", {}}}};
  const bond::Derivation& d = study.derivation;
  const std::vector<double> asked = bond::rest_length_search(study.law);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const double tension = std::abs(bond::tension(study.law, asked[i]));
    if (!(tension < least)) continue;
    least = tension;
    const double young = bond::derive_at(study.law, asked[i]).young_modulus;
    record.append({static_cast<double>(i + 1), std::abs(asked[i] / d.rest_length - 1.0),
                   std::abs(young / d.young_modulus - 1.0)});
  }
  return record;
}

/// What the law says, all of it known before a run; and of what cannot be known, why.
struct Measured {
  Observations seen;
  std::vector<std::string> warnings;
};

Measured measure(const DeriveStudy& study) {
  const bond::Derivation& d = study.derivation;
  std::vector<std::string> warnings;
  std::vector<Metric> metrics{
      {"rest_length", d.rest_length, "L", "r_eq, where the tension vanishes"},
      {"stiffness", d.stiffness, "M T^-2", "U''(r_eq)"},
      {"force_per_strain", d.force_per_strain, "M L T^-2", "-dF/d(strain) = U''(r_eq) r_eq"},
      {"young_modulus", d.young_modulus, "M L^-1 T^-2", "E = U''(r_eq)/r_eq"},
      {"min_tangent_ratio", d.min_tangent_ratio, "1", "infimum of U''(r)/U''(r_eq) in tension"},
      {"min_tangent_strain", d.min_tangent_strain, "1", "strain of that infimum"}};
  if (d.stiffness_over_fene_k) {
    metrics.push_back({"stiffness_over_fene_k", *d.stiffness_over_fene_k, "1", "U''(r_eq)/K"});
  }
  if (d.strain_at_r_max) {
    metrics.push_back(
        {"strain_at_r_max", *d.strain_at_r_max, "1", "strain at which the longest length is reached"});
  }
  if (!d.kinks.empty()) {
    metrics.push_back(
        {"tension_jump", d.kinks.front().tension_jump, "M L T^-2", "jump of dU/dr at the first kink"});
  }
  if (!std::isfinite(d.stiffness_by_differences.value)) {
    warnings.push_back(
        "no stiffness_deviation: the law changes too close to its rest length for differences");
  } else {
    metrics.push_back({"stiffness_deviation", std::abs(d.stiffness_by_differences.value / d.stiffness - 1.0),
                       "1",
                       "U''(r_eq) by differences of the tension (GSL), relative departure from the formula"});
  }
  try {
    constexpr double poisson = 0.3;
    const bond::Calibration again = bond::calibrate(study.law, d.young_modulus, d.rest_length, poisson);
    metrics.push_back({"round_trip_deviation",
                       std::abs(again.derivation.young_modulus / d.young_modulus - 1.0), "1",
                       "E of the law calibrated to this E and spacing, relative departure"});
    const double shear = 4.0 * again.angle_stiffness / std::pow(d.rest_length, 3);
    metrics.push_back({"poisson_round_trip", d.young_modulus / (2.0 * shear) - 1.0, "1",
                       "E/2G - 1 of the law calibrated for nu = 0.3, with G = 4 k_a/r0^3"});
  } catch (const BadParameter& bad) {
    warnings.push_back(fmt::format("no round_trip_deviation: {}", bad.what()));
  }
  for (const bond::Validity& v : d.validity) {
    const int percent = static_cast<int>(std::lround(100.0 * v.tolerance));
    metrics.push_back({fmt::format("secant_valid_to_{}pct", percent), v.secant.hi, "1",
                       fmt::format("strain up to which stress / (E strain) stays within {} %", percent)});
    metrics.push_back({fmt::format("secant_valid_from_{}pct", percent), v.secant.lo, "1",
                       fmt::format("strain down to which stress / (E strain) stays within {} %", percent)});
  }
  if (study.rounded_rest_length) {
    const bond::AtLength at = bond::derive_at(study.law, *study.rounded_rest_length);
    metrics.push_back({"force_per_strain_at_rounded", at.force_per_strain, "M L T^-2",
                       "U''(r) r at the rounded rest length"});
    metrics.push_back(
        {"young_modulus_at_rounded", at.young_modulus, "M L^-1 T^-2", "U''(r)/r at the rounded rest length"});
  }
  Record validity = validity_record();
  record_validity(d, validity);
  Record search = search_record(study);
  metrics.push_back({"rest_length_evaluations", search.columns.front().values.back(), "1",
                     "of the tension until r_eq is known to the last bit"});
  Measured all{
      {.records = {potential_record(study), moduli_record(study), validity, search}, .metrics = metrics},
      warnings};
  if (!d.kinks.empty()) all.seen.records.push_back(kinks_record(d));
  return all;
}

Observations without_rows(Observations seen) {
  for (Record& record : seen.records) {
    for (observe::Column& column : record.columns) column.values.clear();
  }
  return seen;
}

}  // namespace

engine::Study read_derive(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  DeriveStudy study{law, engine::read_derivation(top, law), {}};
  if (top.has("derive")) {
    const io::Table table = top.table("derive");
    study.rounded_rest_length = table.number("rounded_rest_length");
    if (!bond::domain(study.law).contains(*study.rounded_rest_length)) {
      table.fail("rounded_rest_length",
                 fmt::format("'rounded_rest_length' is {}", *study.rounded_rest_length),
                 "the bond law is not defined there", "Give a length inside the law's domain");
    }
  }
  return {.plan = engine::read_plan(top, {.law = study.law}),
          .declares = without_rows(measure(study).seen),
          .run = [study](Observations& seen, Progress& progress, engine::Cost& cost) {
            const Measured measured = measure(study);
            for (const std::string& warning : measured.warnings) progress.warn(warning);
            for (const Metric& metric : measured.seen.metrics) seen.set(metric.name, metric.value);
            seen.records = measured.seen.records;
            cost.finish("law");
          }};
}

}  // namespace veriflex::measures
