#include "studies/sweep.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "engine/convergence.hpp"
#include "engine/verdict.hpp"
#include "repository.hpp"
#include "studies/front.hpp"
#include "studies/grid.hpp"
#include "studies/numbers.hpp"
#include "studies/table.hpp"

namespace veriflex::studies {

namespace {

using observe::Column;
using observe::Observations;
using observe::Record;

// What is worth a look along an axis: of each metric and each combination of the other axes. Orders of what
// is no error mean nothing and do no harm.
Record orders_along(std::size_t axis, const std::vector<Axis>& axes, const Record& sweep,
                    std::size_t metrics_from, std::size_t metrics_to) {
  std::vector<Axis> others = axes;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(axis));
  Record record{"orders_along_" + axes[axis].name(),
                fmt::format("How the metrics follow {}, from coarse to fine", axes[axis].name()),
                columns_of(others)};
  const std::size_t first = record.columns.size();
  record.columns.push_back({"metric", "", "1", "what follows the axis", {}});
  record.columns.push_back({"finest", "", "", "its value in the last row", {}});
  record.columns.push_back({"order", "p", "1", "if it is an error: between the two finest rows", {}});
  record.columns.push_back({"order_of_differences", "p", "1", "of the three finest rows", {}});
  record.columns.push_back({"richardson", "", "", "its limit by that order", {}});
  record.columns.push_back({"gci", "", "", "half-width within which the limit lies", {}});
  const std::vector<double> h = spacings(axes[axis].numbers);
  std::size_t stride = 1;  // between rows that are neighbours along the axis
  for (std::size_t a = axis + 1; a < axes.size(); ++a) stride *= axes[a].size();
  for (const Cell& cell : cells(others)) {
    std::size_t row = 0;
    for (std::size_t a = 0, o = 0; a < axes.size(); ++a)
      row = row * axes[a].size() + (a == axis ? 0 : cell[o++]);
    for (std::size_t m = metrics_from; m < metrics_to; ++m) {
      std::vector<double> values;
      for (std::size_t i = 0; i < h.size(); ++i)
        values.push_back(
            sweep.columns[m].values[row + i * (planted(Mutant::orders_of_other_rows) ? 1 : stride)]);
      const bool whole = std::none_of(values.begin(), values.end(), [](double v) { return std::isnan(v); });
      append(record.columns, others, cell);
      record.columns[first].texts.push_back(sweep.columns[m].name);
      const engine::Convergence found = whole && h.size() > 2
                                            ? engine::converge(h, values)
                                            : engine::Convergence{{not_a_number}, not_a_number, not_a_number};
      const double numbers[] = {values.back(), whole ? engine::orders(h, values).back() : not_a_number,
                                found.order.back(), found.richardson, found.gci};
      for (std::size_t k = 0; k < std::size(numbers); ++k)
        record.columns[first + 1 + k].values.push_back(numbers[k]);
    }
  }
  return record;
}

// An error of rows that no metric is: how far a curve lies from a reference's.
struct CurveError {
  engine::Curve curve;
  double floor;  // errors are never relative to less
  engine::Reference reference;
};

struct Sweep {
  Base base;
  std::vector<Axis> axes;
  Timing timing;
  std::string error;  // metric whose price is asked for, or
  std::optional<CurveError> curve_error;
  bool against_finest;  // its error is its distance from its value in the last row, relative
  std::string work;     // count that is the price
  Questions questions;
  Workspace workspace;
};

// Of each row that came to its end.
Column curve_errors(const Sweep& sweep, const std::vector<Row>& rows) {
  const CurveError& of = *sweep.curve_error;
  Column error{"error",
               "",
               "1",
               fmt::format("largest distance of {}.{} from {}, over max(its magnitude, {})", of.curve.record,
                           of.curve.y, of.reference.id, of.floor),
               {}};
  for (const Row& row : rows) {
    if (row.outcome != "completed") {
      error.values.push_back(not_a_number);
      continue;
    }
    Observations seen;
    seen.records = records_of(sweep.base, row, sweep.workspace, sweep.timing.timed);
    error.values.push_back(engine::max_curve_error(of.curve, of.floor, of.reference, seen));
  }
  return error;
}

// Of each row.
Column errors_of(const Sweep& sweep, const Record& table, const std::vector<Row>& rows) {
  if (sweep.curve_error) return curve_errors(sweep, rows);
  const Column* metric = table.find(sweep.error);
  if (metric == nullptr) {
    throw NumericalFailure(
        fmt::format("no row measured the number '{}', of which the error is", sweep.error));
  }
  if (!sweep.against_finest) return *metric;
  Column error{"error", "", "1",
               fmt::format("distance of {} from its value in the finest row, relative", metric->name),
               metric->values};
  const double finest = error.values.back();
  if (!std::isfinite(finest) || finest == 0.0)
    throw NumericalFailure(fmt::format("the finest row has no {} to measure errors against", metric->name));
  for (double& value : error.values) value = std::abs(value / finest - 1.0);
  // What a row errs along an axis on which it is as fine as the finest is not seen.
  for (const Axis& axis : sweep.axes) {
    if (axis.numbers.empty() || axis.size() == 1) continue;
    const std::vector<double>& at = table.find(axis.name())->values;
    for (std::size_t row = 0; row < at.size(); ++row)
      if (at[row] == at.back()) error.values[row] = not_a_number;
  }
  error.values.back() = not_a_number;
  return error;
}

// What the error costs in work and, where the rows are timed, in seconds.
std::vector<Record> fronts_of(const Sweep& sweep, const std::vector<Cell>& grid, const std::vector<Row>& rows,
                              Record& table, const Record& cost) {
  std::vector<Record> fronts;
  const Column error = errors_of(sweep, table, rows);
  if (table.find(error.name) == nullptr)
    table.columns.insert(table.columns.end() - 1, error);  // before the message
  const auto add = [&](const std::string& name, const Column& work) {
    PricedGrid priced{sweep.axes, grid, {}, error, work};
    for (std::size_t i = 0; i < grid.size(); ++i)
      priced.rows.push_back({std::abs(error.values[i]), work.values[i]});
    priced.error.values.clear();
    priced.work.values.clear();
    for (Record& record : front_records(name, priced)) fronts.push_back(std::move(record));
  };
  add("sweep", *table.find(sweep.work));
  if (sweep.timing.timed) add("sweep_cost", *cost.find("wall_seconds"));
  return fronts;
}

void run(const Sweep& sweep, Observations& seen, Progress& progress, engine::Cost& cost) {
  std::vector<Cell> grid;
  std::size_t all = 0;
  for (const Cell& cell : cells(sweep.axes)) {
    if (is_mine(sweep.workspace, all++)) grid.push_back(cell);
  }
  std::vector<std::vector<std::string>> asked;
  for (const Cell& cell : grid) asked.push_back(settings(sweep.axes, cell));
  const std::vector<Row> rows = run_rows(sweep.base, asked, sweep.workspace, sweep.timing, "rows", progress);
  cost.finish("rows");
  refuse_if_none_was_read(rows);

  std::vector<Column> leading = columns_of(sweep.axes);
  for (const Cell& cell : grid) append(leading, sweep.axes, cell);
  Record table =
      table_of("sweep", fmt::format("{} over {}", sweep.base.id, in_words(sweep.axes)), leading, rows);
  const Record costs = cost_table("sweep", sweep.timing, leading, rows);
  std::vector<Record> fronts;
  const bool has_error = !sweep.error.empty() || sweep.curve_error;
  if (has_error && sweep.workspace.shards == 1) fronts = fronts_of(sweep, grid, rows, table, costs);
  seen.open("sweep") = table;
  for (std::size_t a = 0; a < sweep.axes.size(); ++a) {
    if (sweep.workspace.shards > 1 || spacings(sweep.axes[a].numbers).empty()) continue;
    // Between the outcome and the work stand the metrics.
    const auto work = std::find_if(table.columns.begin(), table.columns.end(),
                                   [](const Column& c) { return c.name == "node_updates"; });
    seen.records.push_back(orders_along(a, sweep.axes, table, leading.size() + 1,
                                        static_cast<std::size_t>(work - table.columns.begin())));
  }
  const auto last =
      std::find_if(rows.rbegin(), rows.rend(), [](const Row& row) { return row.outcome == "completed"; });
  if (last != rows.rend()) {  // by the order of the axes the finest
    for (Record& record : records_of(sweep.base, *last, sweep.workspace, sweep.timing.timed)) {
      record.title += fmt::format("; {}", fmt::join(last->settings, ", "));
      seen.records.push_back(std::move(record));
    }
  }
  seen.records.push_back(costs);
  seen.records.insert(seen.records.end(), fronts.begin(), fronts.end());
  warn_of_failures(rows, progress);
  count_rows(rows, seen);
  sweep.questions.answer(table, seen);
}

std::optional<CurveError> read_curve_error(const io::Table& sweep,
                                           const std::vector<observe::Metric>& measured) {
  if (!sweep.has("curve_error")) return std::nullopt;
  if (sweep.has("error"))
    sweep.fail("curve_error", "both error and curve_error", "a sweep has one error", "Keep one");
  const io::Table t = sweep.table("curve_error");
  CurveError of{{t.text("record"), t.text("x"), t.text("y")}, t.number("floor"), {}};
  const std::vector<std::string> names = engine::names_of(measured);
  for (const std::string& column : {of.curve.x, of.curve.y}) {
    const std::string name = of.curve.record + "." + column;
    if (std::find(names.begin(), names.end(), name) == names.end())
      t.fail("record", fmt::format("no run of this case records '{}'", name), "it is to be compared",
             "See veriflex plan for what is measured");
  }
  if (!(of.floor >= 0.0)) t.fail("floor", "it is negative", "errors are relative to it", "Use 0");
  const std::filesystem::path beside = std::filesystem::path(sweep.place().file).parent_path();
  of.reference =
      engine::find_reference(t.text("reference"), beside, repository::references(), t.place("reference"));
  engine::need_columns(of.reference, {of.curve.x, of.curve.y}, t, "reference");
  return of;
}

}  // namespace

engine::Study read_sweep(const io::Table& table, const std::vector<io::Table>& checks, const Base& base,
                         engine::Study measure, const Workspace& workspace) {
  const std::vector<Axis> axes = read_axes(table);
  if (axes.empty()) {
    table.fail("axes", "there are none", "a sweep changes at least one key",
               "Write for example axes = [{ key = \"fluid.relaxation_time\", values = [0.6, 1.0] }]");
  }
  // For the reader of the report only, who finds it in the case.
  if (table.has("expected_slope") && !(table.number("expected_slope") < 0.0))
    table.fail("expected_slope", "it is not negative", "errors fall with their price",
               "Write for example -0.5");
  const std::vector<observe::Metric> measured = engine::measured(measure);
  std::vector<std::string> counted;
  for (const work::Field& field : work::fields) counted.emplace_back(field.name);
  const Sweep sweep{
      .base = base,
      .axes = axes,
      .timing = read_timing(table),
      .error = table.has("error") ? table.choice("error", engine::names_of(measured)) : "",
      .curve_error = read_curve_error(table, measured),
      .against_finest = table.has("reference") && table.choice("reference", {"finest"}) == "finest",
      .work = table.has("work") ? table.choice("work", counted) : "bytes_moved",
      .questions = read_questions(checks, "sweep", columns_of(axes), measured),
      .workspace = workspace};
  std::vector<std::vector<std::string>> runs;
  for (const Cell& cell : cells(axes)) runs.push_back(settings(axes, cell));
  measure.plan.built.push_back(
      {"sweep", fmt::format("{} runs of the case, over {}", runs.size(), in_words(axes)), 0.0});
  declare(measure, sweep.questions, std::move(runs), sweep.timing);
  measure.run = [sweep](Observations& seen, Progress& progress, engine::Cost& cost) {
    run(sweep, seen, progress, cost);
  };
  return measure;
}

}  // namespace veriflex::studies
