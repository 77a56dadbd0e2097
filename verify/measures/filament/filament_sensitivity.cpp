#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "base/reduce.hpp"
#include "base/stop.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/filament/filament_case.hpp"
#include "measures/filament/filament_compare.hpp"
#include "measures/filament/filament_guard.hpp"

// What the paper leaves open about its filament, varied one at a time: how far each choice moves the centre
// line, and what becomes of the distance between the two laws.

namespace veriflex::measures {

namespace {

using observe::Observations;
using observe::Record;

struct Variant {
  std::string name;   // part of the metrics' names
  std::string label;  // in words
  bool numerical;     // no choice about the scene but about how well it is computed
  Stroke stroke;
  bool changes_compared;  // whether the compared body lives in another scene too
};

struct Sensitivity {
  Stroke base;
  bond::AnyLaw compared;
  std::vector<Variant> variants;
};

struct Pair {
  StrokeResult law, compared;
};

Stroke with(Stroke stroke, const bond::AnyLaw& law) {
  stroke.law = law;
  return stroke;
}

StrokeResult run_with(const Stroke& stroke, const bond::AnyLaw& law, const std::string& label,
                      Progress& progress) {
  return run_guarded(with(stroke, law), fmt::format("{}, {}", label, bond::name_of(law)), "stroke", progress);
}

/// Largest growth of the coupling of both bodies of a variant. That one breaks is an answer, and so it is
/// only warned of.
double growth_of(const Variant& variant, const bond::AnyLaw& compared, Progress& progress) {
  double growth = 0.0;
  std::vector<Stroke> strokes{variant.stroke};
  if (variant.changes_compared) strokes.push_back(with(variant.stroke, compared));
  for (const Stroke& stroke : strokes) {
    engine::check_coupling(stroke.fluid, body_of(stroke),
                           fmt::format("{}, {}", variant.label, bond::name_of(stroke.law)),
                           stroke.node_mass_place, growth, progress, engine::Unstable::Warned);
  }
  return growth;
}

/// The centre lines as they would be at the base's amplitude if they only grew with it.
StrokeResult scaled(StrokeResult seen, double factor) {
  for (CentreLine& line : seen.lines) line *= factor;
  for (Vec3& centre : seen.centre) centre *= factor;
  return seen;
}

struct Effect {
  Deviation law;           // of the law of [bond] against itself in the base's scene
  Deviation between_laws;  // in the varied scene, over the varied amplitude
  double swum;
};

Effect effect_of(const Variant& variant, const Pair& seen, const Sensitivity& study, const Pair& base) {
  const double factor = study.base.amplitude / variant.stroke.amplitude;
  return {worst(scaled(seen.law, factor), base.law, study.base.amplitude),
          worst(seen.law, seen.compared, variant.stroke.amplitude), swum(seen.law)};
}

/// Whether a variant's stroke is smaller than the base's: then the laws' distance is followed down to it.
bool has_smaller(const Sensitivity& study) {
  return std::any_of(study.variants.begin(), study.variants.end(),
                     [&](const Variant& v) { return v.stroke.amplitude < study.base.amplitude; });
}

Observations filament_sensitivity_observations(const Sensitivity& study) {
  Observations all;
  all.records = {
      {"sensitivity",
       "What each open choice moves, and the distance between the laws under it",
       {{"variant", "", "1", "number in the order of the case; 0 is the base", {}},
        {"survived", "", "1", "1, or 0 when the run broke off", {}},
        {"effect_z", "", "1", "max |dz|/z0 from the base, law of [bond], over the figures' phases", {}},
        {"effect_swimming", "", "1", "max |d|/z0 of the same, displacement along y taken out", {}},
        {"law_deviation_z", "", "1", "max |dz|/z0 between the laws", {}},
        {"law_deviation_swimming", "", "1", "max |d|/z0 between the laws, swimming taken out", {}},
        {"swum", "", "L", "along y in the last period, law of [bond]", {}},
        {"coupling_growth", "", "1", "of the linearised exchange in a step, before the run", {}}}}};
  all.metrics = {growth_of_coupling(), {"deviation_z_max", {}, "1", "max |dz|/z0 between the laws, base"}};
  if (study.base.periods > 1) {
    all.metrics.push_back(
        {"period_change", {}, "1", "max |d|/z0 from the period before, base, law of [bond]"});
  }
  for (const Variant& variant : study.variants) {
    all.metrics.push_back(
        {"effect_" + variant.name, {}, "1", "max |dz|/z0 from the base, law of [bond]: " + variant.label});
    all.metrics.push_back(
        {"law_deviation_" + variant.name, {}, "1", "max |dz|/z0 between the laws: " + variant.label});
  }
  all.metrics.push_back({"deviation_uncertainty",
                         {},
                         "1",
                         "most that the variants called numerical change the distance between the laws"});
  all.metrics.push_back({"failures", {}, "1", "variants that broke off"});
  if (has_smaller(study)) {
    all.metrics.push_back({"growth_exponent",
                           {},
                           "1",
                           "|dz| between the laws grows as z0 to this power, smallest amplitude to base"});
  }
  return all;
}

/// The row and the metrics of a variant; one that broke off has no effect.
void report(const Variant& variant, const std::optional<Effect>& effect, double growth, Observations& seen) {
  Record& record = seen.open("sensitivity");
  const auto number = static_cast<double>(record.columns.front().values.size());
  std::vector<double> row{number, 0.0, NAN, NAN, NAN, NAN, NAN, growth};
  if (effect) {
    row = {number,
           1.0,
           effect->law.z_max,
           effect->law.moved_max,
           effect->between_laws.z_max,
           effect->between_laws.moved_max,
           effect->swum,
           growth};
  }
  record.append(row);
  seen.set("effect_" + variant.name, row[2]);
  seen.set("law_deviation_" + variant.name, row[4]);
}

void run_filament_sensitivity(const Sensitivity& study, Observations& seen, Progress& progress,
                              engine::Cost& cost) {
  check_strokes({study.base, with(study.base, study.compared)}, seen, progress);
  const double base_growth = seen.metric("coupling_growth")->value;
  cost.finish("stability of the coupling");
  const Pair base{run_with(study.base, study.base.law, "base", progress),
                  run_with(study.base, study.compared, "base", progress)};
  cost.finish("base");
  const Deviation between = worst(base.law, base.compared, study.base.amplitude);
  seen.set("deviation_z_max", between.z_max);
  if (study.base.periods > 1)
    seen.set("period_change", change_over_last_period(base.law, study.base.amplitude));
  seen.open("sensitivity")
      .append({0.0, 1.0, 0.0, 0.0, between.z_max, between.moved_max, swum(base.law), base_growth});
  double uncertainty = 0.0;
  double failures = 0.0;
  const Variant* smallest = nullptr;
  double deviation_of_smallest = NAN;
  for (const Variant& variant : study.variants) {
    double growth = NAN;
    try {
      growth = growth_of(variant, study.compared, progress);
      Pair now;
      now.law = run_with(variant.stroke, variant.stroke.law, variant.label, progress);
      now.compared = variant.changes_compared
                         ? run_with(variant.stroke, study.compared, variant.label, progress)
                         : base.compared;
      const Effect effect = effect_of(variant, now, study, base);
      report(variant, effect, growth, seen);
      if (variant.numerical)
        uncertainty = worse(uncertainty, std::abs(effect.between_laws.z_max - between.z_max));
      if (variant.stroke.amplitude < (smallest ? smallest->stroke : study.base).amplitude) {
        smallest = &variant;
        deviation_of_smallest = effect.between_laws.z_max;
      }
    } catch (const NumericalFailure& failure) {
      if (stop::was_thrown()) throw;
      failures += 1.0;
      progress.warn(fmt::format("{}: {}", variant.label, failure.what()));
      report(variant, std::nullopt, growth, seen);
    }
    cost.finish(variant.label);
  }
  seen.set("deviation_uncertainty", uncertainty);
  seen.set("failures", failures);
  if (!has_smaller(study)) return;
  seen.set("growth_exponent", smallest == nullptr
                                  ? NAN  // it broke off
                                  : 1.0 + std::log(between.z_max / deviation_of_smallest) /
                                              std::log(study.base.amplitude / smallest->stroke.amplitude));
}

Variant read_variant(const io::Table& table, const Stroke& base) {
  const std::string name = table.text("name");
  if (name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") != std::string::npos) {
    table.fail("name", fmt::format("'{}' is no name for a metric", name),
               "it is made of small letters, digits and underscores", "Write for example name = \"tau_08\"");
  }
  const bool only_law = table.has("bond") && !table.has("fluid") && !table.has("coupling") &&
                        !table.has("solid") && !table.has("filament");
  return {.name = name,
          .label = table.text("label"),
          .numerical = table.flag("numerical", false),
          .stroke = varied(base, table),
          .changes_compared = !only_law};
}

}  // namespace

engine::Study read_filament_sensitivity(const io::Table& top) {
  Sensitivity study{read_stroke(top), engine::read_law(top, "compared_bond"), {}};
  for (const io::Table& table : top.tables("variant")) {
    const Variant read = read_variant(table, study.base);
    for (const Variant& before : study.variants) {
      if (before.name == read.name) {
        table.fail("name", fmt::format("two variants are called '{}'", read.name),
                   "their metrics could not be told apart", "Give each a name of its own");
      }
    }
    study.variants.push_back(read);
  }
  if (study.variants.empty()) {
    top.fail("variant", "the case has no [[variant]]", "there is nothing to compare with the base",
             "Write [[variant]] with a name, a label and what it changes");
  }
  return {.plan = plan_stroke(top, study.base),
          .declares = filament_sensitivity_observations(study),
          .run = std::bind_front(run_filament_sensitivity, study),
          .expects = [study] {
            std::vector<scene::ExpectedWork> all{expected_work(study.base, 2)};
            for (const Variant& variant : study.variants)
              all.push_back(expected_work(variant.stroke, variant.changes_compared ? 2 : 1));
            return all;
          }};
}

}  // namespace veriflex::measures
