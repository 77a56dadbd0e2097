#include "studies/ablate.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/reduce.hpp"
#include "studies/table.hpp"

namespace veriflex::studies {

namespace {

using observe::Column;
using observe::Observations;
using observe::Record;

struct Variant {
  std::string name;
  std::vector<std::string> settings;  // as --set takes them
};

struct Ablation {
  Base base;
  std::vector<Variant> variants;  // the first is the case as it stands
  Timing timing;
  Questions questions;
  Workspace workspace;
};

std::vector<Column> leading_columns() { return {{"variant", "", "1", "what was left out or put in", {}}}; }

// Metric by metric and variant by variant; the case itself has no row.
Record differences(const Ablation& ablation, const Record& table) {
  Record record{"ablate_difference", "How far each variant moves each metric of the case", leading_columns()};
  record.columns.push_back({"metric", "", "1", "which", {}});
  record.columns.push_back({"of_case", "", "", "its value in the case as it stands", {}});
  record.columns.push_back({"of_variant", "", "", "its value in the variant", {}});
  record.columns.push_back({"relative_difference", "", "1", "their difference over the case's value", {}});
  const auto is_work = [](const Column& c) { return c.name == "node_updates"; };
  for (std::size_t v = 1; v < ablation.variants.size(); ++v) {
    for (std::size_t m = 2; m < table.columns.size() && !is_work(table.columns[m]); ++m) {
      const std::vector<double>& values = table.columns[m].values;
      record.columns[0].texts.push_back(ablation.variants[v].name);
      record.columns[1].texts.push_back(table.columns[m].name);
      record.columns[2].values.push_back(values[0]);
      record.columns[3].values.push_back(values[v]);
      record.columns[4].values.push_back(relative_to(values[v] - values[0], std::abs(values[0])));
    }
  }
  return record;
}

void run(const Ablation& ablation, Observations& seen, Progress& progress, engine::Cost& cost) {
  std::vector<std::vector<std::string>> asked;
  std::vector<Column> leading = leading_columns();
  for (std::size_t i = 0; i < ablation.variants.size(); ++i) {
    if (!is_mine(ablation.workspace, i)) continue;
    asked.push_back(ablation.variants[i].settings);
    leading.front().texts.push_back(ablation.variants[i].name);
  }
  const std::vector<Row> rows =
      run_rows(ablation.base, asked, ablation.workspace, ablation.timing, "variants", progress);
  cost.finish("rows");
  const Record table =
      table_of("ablate", fmt::format("{} with parts left out and put in", ablation.base.id), leading, rows);
  seen.open("ablate") = table;
  if (ablation.workspace.shards == 1) seen.records.push_back(differences(ablation, table));
  seen.records.push_back(cost_table("ablate", ablation.timing, leading, rows));
  refuse_if_none_was_read(rows);
  warn_of_failures(rows, progress);
  count_rows(rows, seen);
  ablation.questions.answer(table, seen);
}

std::vector<Variant> read_variants(const io::Table& table) {
  std::vector<Variant> variants{{"as it stands", {}}};
  for (const io::Table& one : table.tables("variants")) {
    Variant variant{one.text("name"), {}};
    if (one.has("without")) {
      for (const std::string& key : one.texts("without")) variant.settings.push_back(key + "=");
    }
    if (one.has("set")) {
      const io::Table set = one.table("set");
      for (const std::string& key : set.keys()) variant.settings.push_back(key + "=" + set.shown_value(key));
    }
    if (variant.settings.empty()) {
      throw InputError(one.place(), fmt::format("variant '{}' changes nothing", variant.name),
                       "it is the case as it stands", "Give 'without' or 'set'");
    }
    const bool known = std::any_of(variants.begin(), variants.end(), [&](const Variant& v) {
      return v.name == variant.name || v.settings == variant.settings;
    });
    if (known) {
      one.fail("name", fmt::format("variant '{}' stands there twice", variant.name),
               "a row has one name, and is run once", "Remove one");
    }
    variants.push_back(std::move(variant));
  }
  if (variants.size() == 1) {
    table.fail("variants", "there are none", "each is a row beside the case", "Write [[ablate.variants]]");
  }
  return variants;
}

}  // namespace

engine::Study read_ablate(const io::Table& table, const std::vector<io::Table>& checks, const Base& base,
                          engine::Study measure, const Workspace& workspace) {
  const Ablation ablation{
      .base = base,
      .variants = read_variants(table),
      .timing = read_timing(table),
      .questions = read_questions(checks, "ablate", leading_columns(), engine::measured(measure)),
      .workspace = workspace};
  std::vector<std::string> names;
  for (std::size_t i = 1; i < ablation.variants.size(); ++i) names.push_back(ablation.variants[i].name);
  measure.plan.built.push_back(
      {"ablate", fmt::format("the case beside {} variants: {}", names.size(), fmt::join(names, ", ")), 0.0});
  declare(measure, ablation.questions);
  measure.run = [ablation](Observations& seen, Progress& progress, engine::Cost& cost) {
    run(ablation, seen, progress, cost);
  };
  return measure;
}

}  // namespace veriflex::studies
