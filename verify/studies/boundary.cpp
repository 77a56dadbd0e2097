#include "studies/boundary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/mutant.hpp"
#include "base/reduce.hpp"
#include "studies/grid.hpp"
#include "studies/table.hpp"

namespace veriflex::studies {

namespace {

using observe::Column;
using observe::Observations;
using observe::Record;

// When a row counts as good: it comes to its end, and this metric stays within its bound.
struct Criterion {
  std::string metric;  // empty: none
  double at_most = INFINITY;

  // "completed", a failure, or "beyond" the bound.
  std::string outcome(const Row& row) const {
    if (row.outcome != "completed" || metric.empty()) return row.outcome;
    const observe::Metric* measured = row.seen.metric(metric);
    return measured != nullptr && (measured->value <= at_most || planted(Mutant::criterion_ignored))
               ? row.outcome
               : "beyond";
  }
};

struct Boundary {
  Base base;
  std::string key;
  double from, to;
  bool logarithmic, whole_numbers;
  std::size_t points;
  double accuracy;  // of the key, relative
  Criterion criterion;
  std::vector<Axis> axes;
  Timing timing;
  Questions questions;
  Workspace workspace;
};

// One place along the key.
struct Look {
  double x;
  Row row;
  std::string outcome;
  bool good() const { return outcome == "completed"; }
};

// What is known at one combination of the axes, in the direction from `from` to `to`.
struct Line {
  Cell cell;
  std::vector<Look> looks;

  // The first look whose outcome differs in kind from the one before it; 0 when none does.
  std::size_t first_change() const {
    for (std::size_t i = 1; i < looks.size(); ++i) {
      if (looks[i].good() != looks[i - 1].good()) return i;
    }
    return 0;
  }
  int changes() const {
    int count = 0;
    for (std::size_t i = 1; i < looks.size(); ++i) count += looks[i].good() != looks[i - 1].good();
    return count;
  }
};

double between(const Boundary& b, double x, double y, double share) {
  const double z = b.logarithmic ? x * std::pow(y / x, share) : x + (y - x) * share;
  return b.whole_numbers ? std::round(z) : z;
}

// The next place to look at on this line; nothing when its boundary is known well enough.
std::optional<double> next(const Boundary& b, const Line& line) {
  const std::size_t change = line.first_change();
  if (change == 0) return std::nullopt;
  const double x = line.looks[change - 1].x, y = line.looks[change].x;
  // Where it is near zero no bisection would end: a thousandth of the range stands for its value then.
  const double least = b.logarithmic ? 0.0 : 1e-3 * std::abs(b.to - b.from);
  if (std::abs(y - x) <= b.accuracy * std::max({std::abs(x), std::abs(y), least})) return std::nullopt;
  const double middle = between(b, x, y, 0.5);
  if (middle == x || middle == y) return std::nullopt;
  return middle;
}

std::string text_of(const Boundary& b, double x) {
  return b.whole_numbers ? fmt::format("{:.0f}", x) : io::toml_text(x);
}

void add(const Boundary& b, Line& line, Look look) {
  const auto behind = std::upper_bound(
      line.looks.begin(), line.looks.end(), look,
      [&](const Look& one, const Look& other) { return b.to > b.from ? one.x < other.x : one.x > other.x; });
  line.looks.insert(behind, std::move(look));
}

std::vector<std::string> settings_at(const Boundary& b, const Cell& cell, double x) {
  std::vector<std::string> all = settings(b.axes, cell);
  all.push_back(b.key + "=" + text_of(b, x));
  return all;
}

// Looks at one place of each of the lines, side by side.
void look(const Boundary& b, std::vector<Line>& lines,
          const std::vector<std::pair<std::size_t, double>>& places, const std::string& phase,
          Progress& progress) {
  std::vector<std::vector<std::string>> asked;
  for (const auto& [line, x] : places) asked.push_back(settings_at(b, lines[line].cell, x));
  std::vector<Row> rows = run_rows(b.base, asked, b.workspace, b.timing, phase, progress);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto [line, x] = places[i];
    const std::string outcome = b.criterion.outcome(rows[i]);
    add(b, lines[line], {x, std::move(rows[i]), outcome});
  }
}

std::vector<double> first_places(const Boundary& b) {
  std::vector<double> places;
  for (std::size_t p = 0; p < b.points; ++p) {
    const double x = between(b, b.from, b.to, static_cast<double>(p) / static_cast<double>(b.points - 1));
    if (places.empty() || x != places.back()) places.push_back(x);
  }
  return places;
}

std::vector<Line> search(const Boundary& b, Progress& progress) {
  std::vector<Line> lines;
  const std::vector<Cell> all = cells(b.axes);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (is_mine(b.workspace, i)) lines.push_back({all[i], {}});
  }
  std::vector<std::pair<std::size_t, double>> places;
  for (std::size_t line = 0; line < lines.size(); ++line) {
    for (const double x : first_places(b)) places.emplace_back(line, x);
  }
  look(b, lines, places, "bracketing", progress);
  for (;;) {
    places.clear();
    for (std::size_t line = 0; line < lines.size(); ++line) {
      if (const std::optional<double> x = next(b, lines[line])) places.emplace_back(line, *x);
    }
    if (places.empty()) return lines;
    look(b, lines, places, "bisection", progress);
  }
}

// As if on each line the boundary were in the middle.
std::vector<std::vector<std::string>> expected_runs(const Boundary& b) {
  const double middle = between(b, b.from, b.to, 0.5);
  const auto look_at = [&](double x) {
    return Look{x, {}, std::abs(x - b.from) < std::abs(middle - b.from) ? "completed" : "beyond"};
  };
  std::vector<std::vector<std::string>> runs;
  for (const Cell& cell : cells(b.axes)) {
    Line line{cell, {}};
    for (const double x : first_places(b)) add(b, line, look_at(x));
    while (const std::optional<double> x = next(b, line)) add(b, line, look_at(*x));
    for (const Look& look : line.looks) runs.push_back(settings_at(b, cell, look.x));
  }
  return runs;
}

std::vector<Column> leading_columns(const std::vector<Axis>& axes) {
  std::vector<Column> columns = columns_of(axes);
  columns.push_back(
      {"boundary", "", "1", "middle of the two places between which the outcome first changes", {}});
  columns.push_back({"before", "", "1", "the last place before it, from where the search starts", {}});
  columns.push_back({"behind", "", "1", "the first place behind it", {}});
  columns.push_back(
      {"changes", "", "1", "of the outcome over all places looked at; more than 1: not monotonic", {}});
  columns.push_back({"runs", "", "1", "places looked at", {}});
  return columns;
}

Record boundary_record(const Boundary& b, const std::vector<Line>& lines) {
  Record record{"outcome_boundary",
                fmt::format("Where the outcome of {} changes along {}, from {} on", b.base.id, b.key, b.from),
                leading_columns(b.axes)};
  record.columns.push_back({"outcome_before", "", "1", "how the run before it ended", {}});
  record.columns.push_back({"outcome_behind", "", "1", "how the run behind it ended", {}});
  for (const Line& line : lines) {
    append(record.columns, b.axes, line.cell);
    const std::size_t change = line.first_change();
    const Look& before = line.looks[change == 0 ? line.looks.size() - 1 : change - 1];
    const double x = change == 0 ? not_a_number : before.x;
    const double y = change == 0 ? not_a_number : line.looks[change].x;
    const double numbers[] = {planted(Mutant::boundary_at_near_end) ? x : 0.5 * (x + y), x, y,
                              static_cast<double>(line.changes()), static_cast<double>(line.looks.size())};
    for (std::size_t k = 0; k < std::size(numbers); ++k)
      record.columns[b.axes.size() + k].values.push_back(numbers[k]);
    record.columns[record.columns.size() - 2].texts.push_back(before.outcome);
    record.columns.back().texts.push_back(change == 0 ? before.outcome : line.looks[change].outcome);
  }
  return record;
}

void run(const Boundary& b, Observations& seen, Progress& progress, engine::Cost& cost) {
  const std::vector<Line> lines = search(b, progress);
  cost.finish("rows");
  const Record boundary = boundary_record(b, lines);
  seen.open("outcome_boundary") = boundary;

  std::vector<Row> rows;
  std::vector<Column> leading = columns_of(b.axes);
  leading.push_back({b.key, "", "1", "the key along which the boundary lies, in its unit", {}});
  leading.push_back({"counts_as", "", "1", "completed, or what ended the run, or beyond its criterion", {}});
  for (const Line& line : lines) {
    for (const Look& look : line.looks) {
      append(leading, b.axes, line.cell);
      leading[b.axes.size()].values.push_back(look.x);
      leading.back().texts.push_back(look.outcome);
      rows.push_back(look.row);
    }
  }
  seen.records.push_back(table_of("outcome_boundary_rows", "Every run of the search", leading, rows));
  seen.records.push_back(cost_table("outcome_boundary", b.timing, leading, rows));
  refuse_if_none_was_read(rows);
  count_rows(rows, seen);
  for (const Line& line : lines) {
    if (line.first_change() == 0) {
      progress.warn(fmt::format("no change of the outcome between {} = {} and {}{}{}: every run is '{}'",
                                b.key, b.from, b.to, b.axes.empty() ? "" : " at ",
                                fmt::join(settings(b.axes, line.cell), " "), line.looks.front().outcome));
    }
  }
  b.questions.answer(boundary, seen);
}

Criterion read_criterion(const io::Table& table, const std::vector<std::string>& measured) {
  Criterion criterion;
  if (!table.has("criterion")) return criterion;
  const io::Table t = table.table("criterion");
  criterion.metric = t.choice("metric", measured);
  criterion.at_most = t.number("at_most");
  return criterion;
}

}  // namespace

engine::Study read_boundary(const io::Table& table, const std::vector<io::Table>& checks, const Base& base,
                            engine::Study measure, const Workspace& workspace) {
  Boundary b{
      .base = base,
      .key = table.text("key"),
      .from = table.number("from"),
      .to = table.number("to"),
      .logarithmic = table.has("scale") && table.choice("scale", {"linear", "logarithmic"}) == "logarithmic",
      .whole_numbers = table.flag("whole_numbers", false),
      .points = static_cast<std::size_t>(table.has("points") ? table.integer("points", 2, 10'000) : 5),
      .accuracy = table.number("accuracy", 0.01),
      .criterion = read_criterion(table, engine::names_of(engine::measured(measure))),
      .axes = read_axes(table),
      .timing = read_timing(table),
      .questions = {},
      .workspace = workspace};
  if (b.from == b.to)
    table.fail("to", "'from' and 'to' are the same", "nothing lies between", "Give a range");
  if (b.logarithmic && !(b.from > 0.0 && b.to > 0.0)) {
    table.fail("scale", "a logarithmic scale with a value of 0 or less", "it has no logarithm", "Use linear");
  }
  if (!(b.accuracy >= 1e-12)) {
    table.fail("accuracy", fmt::format("'accuracy' is {}", b.accuracy), "it is relative, at least 1e-12",
               "Give for example 0.01");
  }
  b.questions = read_questions(checks, "outcome_boundary", leading_columns(b.axes), {});
  measure.plan.built.push_back(
      {"boundary",
       fmt::format("runs of the case along {} from {} to {}{}{}, {} to begin with", b.key, b.from, b.to,
                   b.axes.empty() ? "" : ", over ", in_words(b.axes), b.points * cells(b.axes).size()),
       0.0});
  declare(measure, b.questions, expected_runs(b), b.timing);
  measure.run = [b](Observations& seen, Progress& progress, engine::Cost& cost) {
    run(b, seen, progress, cost);
  };
  return measure;
}

}  // namespace veriflex::studies
