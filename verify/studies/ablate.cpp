#include "studies/ablate.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/mutant.hpp"
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
  std::string origin =
      "given";  // by the case; "case": it itself, "kept": by the plan's leaving it out, "offered"
};

struct Ablation {
  Base base;
  std::vector<Variant> variants;  // the first is the case as it stands
  Timing timing;
  Questions questions;
  Workspace workspace;
};

std::vector<Column> leading_columns() { return {{"variant", "", "1", "what was left out or put in", {}}}; }

// What a check may ask of a variant beside what a run measures: how far it moves the case, and what it built.
Column moved_column() {
  return {
      "moved",
      "",
      "1",
      "largest change of a metric that both have, over the largest of the case's metrics of that record and "
      "dimension; not a number where the run ended early",
      {}};
}
std::vector<Column> part_columns() {
  std::vector<Column> columns;
  for (const auto& kind : parts::kinds) {
    columns.push_back(
        {fmt::format("built_{}", kind.id), "", "1", fmt::format("parts built: {}", kind.text), {}});
  }
  return columns;
}

// Of each kind of part that any variant built, its memory.
Record parts_table(std::vector<Column> leading, const std::vector<Row>& rows) {
  Record record{"ablate_parts", "Memory of the parts that each variant built", std::move(leading)};
  for (std::size_t k = 0; k < parts::kinds.size(); ++k) {
    Column column{std::string(parts::kinds[k].id), "", "byte", std::string(parts::kinds[k].text), {}};
    bool any = false;
    for (const Row& row : rows) {
      any = any || row.parts[k].count > 0;
      column.values.push_back(row.parts[k].bytes);
    }
    if (any) record.columns.push_back(std::move(column));
  }
  return record;
}

// The record that a metric is of, and its dimension: what is rounding beside the others of them is no change.
std::pair<std::string, std::string> kind_of(const observe::Metric& metric) {
  return {metric.name.substr(0, metric.name.find('.')), metric.dimension};
}

double moved(const Row& of_case, const Row& variant) {
  if (of_case.outcome != "completed" || variant.outcome != "completed") return not_a_number;
  std::map<std::pair<std::string, std::string>, double> scale;
  for (const observe::Metric& metric : of_case.seen.metrics) {
    double& largest = scale[kind_of(metric)];
    if (std::isfinite(metric.value)) largest = std::max(largest, std::abs(metric.value));
  }
  double most = 0.0;
  for (const observe::Metric& metric : of_case.seen.metrics) {
    const observe::Metric* other = variant.seen.metric(metric.name);
    if (other == nullptr || (std::isnan(metric.value) && std::isnan(other->value))) continue;
    most = worse(planted(Mutant::ablation_sees_last_metric) ? 0.0 : most,
                 relative_to(other->value - metric.value, scale[kind_of(metric)]));
  }
  return most;
}

// Adds these columns to the table of the rows, of which the first is the case as it stands.
void add_columns(Record& table, const std::vector<Variant>& variants, const std::vector<Row>& rows) {
  Column origin{
      "origin", "", "1", "whether the case gives it, the plan leaves it out (kept) or offers it", {}};
  for (const Variant& variant : variants) origin.texts.push_back(variant.origin);
  table.columns.push_back(std::move(origin));
  Column change = moved_column();
  for (const Row& row : rows) change.values.push_back(moved(rows.front(), row));
  table.columns.push_back(std::move(change));
  std::vector<Column> built = part_columns();
  for (std::size_t k = 0; k < built.size(); ++k) {
    for (const Row& row : rows) built[k].values.push_back(static_cast<double>(row.parts[k].count));
    table.columns.push_back(std::move(built[k]));
  }
}

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
  Record table =
      table_of("ablate", fmt::format("{} with parts left out and put in", ablation.base.id), leading, rows);
  if (ablation.workspace.shards == 1) {
    seen.records.push_back(differences(ablation, table));
    add_columns(table, ablation.variants, rows);
  }
  seen.open("ablate") = table;
  seen.records.push_back(parts_table(leading, rows));
  seen.records.push_back(cost_table("ablate", ablation.timing, leading, rows));
  refuse_if_none_was_read(rows);
  warn_of_failures(rows, progress);
  count_rows(rows, seen);
  ablation.questions.answer(table, seen);
}

// `left_out`: a variant for each part that the plan leaves out and that can be kept.
void add_left_out(const scene::Plan& plan, std::vector<Variant>& variants) {
  for (const scene::LeftOut& part : plan.left_out) {
    if (!part.put_in.empty()) variants.push_back({"with " + part.module, {part.put_in}, "kept"});
  }
}

std::vector<Variant> read_variants(const io::Table& table, const engine::Study& measure) {
  std::vector<Variant> variants{{"as it stands", {}, "case"}};
  if (table.flag("left_out", false)) add_left_out(measure.plan, variants);
  if (table.flag("offered", false) && measure.offers) {
    for (const scene::Offer& offer : measure.offers())
      variants.push_back({offer.what, {offer.setting}, "offered"});
  }
  const std::vector<io::Table> given =
      table.has("variants") ? table.tables("variants") : std::vector<io::Table>{};
  for (const io::Table& one : given) {
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
    table.fail("variants", "there are none",
               "each is a row beside the case, and this one has nothing to keep or to offer",
               "Write [[ablate.variants]]");
  }
  return variants;
}

std::vector<observe::Metric> asked_of(const engine::Study& measure) {
  std::vector<observe::Metric> all = engine::measured(measure);
  std::vector<Column> columns = part_columns();
  columns.push_back(moved_column());
  for (const Column& column : columns) all.push_back({column.name, {}, column.dimension, column.meaning});
  return all;
}

}  // namespace

engine::Study read_ablate(const io::Table& table, const std::vector<io::Table>& checks, const Base& base,
                          engine::Study measure, const Workspace& workspace) {
  const Ablation ablation{.base = base,
                          .variants = read_variants(table, measure),
                          .timing = read_timing(table),
                          .questions = read_questions(checks, "ablate", leading_columns(), asked_of(measure)),
                          .workspace = workspace};
  std::vector<std::string> names;
  std::vector<std::vector<std::string>> runs;
  for (const Variant& variant : ablation.variants) {
    names.push_back(variant.name);
    runs.push_back(variant.settings);
  }
  measure.plan.built.push_back({"ablate",
                                fmt::format("the case beside {} variants: {}", names.size() - 1,
                                            fmt::join(names.begin() + 1, names.end(), ", ")),
                                0.0});
  declare(measure, ablation.questions, std::move(runs), ablation.timing);
  measure.run = [ablation](Observations& seen, Progress& progress, engine::Cost& cost) {
    run(ablation, seen, progress, cost);
  };
  return measure;
}

}  // namespace veriflex::studies
