#include "studies/table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "studies/numbers.hpp"

namespace veriflex::studies {

namespace {

using observe::Column;
using observe::Metric;
using observe::Record;

// Every metric of any row, as the first row that has it declares it.
std::vector<Metric> declared(const std::vector<Row>& rows) {
  observe::Observations all;
  for (const Row& row : rows) {
    for (const Metric& metric : row.seen.metrics) {
      if (all.metric(metric.name) == nullptr) all.metrics.push_back(metric);
    }
  }
  return all.metrics;
}

Column parts_column() {
  return {"parts_bytes", "", "byte", "memory of all parts of the scene together, at most", {}};
}

}  // namespace

Record table_of(std::string name, std::string title, std::vector<Column> leading,
                const std::vector<Row>& rows) {
  Record table{std::move(name), std::move(title), std::move(leading)};
  Column outcome{"outcome", "", "1", "how the run ended", {}};
  Column message{"message", "", "1", "why it did not come to its end", {}};
  for (const Row& row : rows) {
    outcome.texts.push_back(row.outcome);
    message.texts.push_back(row.message);
  }
  table.columns.push_back(std::move(outcome));
  for (const Metric& metric : declared(rows)) {
    Column column{metric.name, "", metric.dimension, metric.meaning, {}};
    for (const Row& row : rows) {
      // What a run that broke off had measured until then is no answer.
      const Metric* measured = row.outcome == "completed" ? row.seen.metric(metric.name) : nullptr;
      column.values.push_back(measured == nullptr ? not_a_number : measured->value);
    }
    table.columns.push_back(std::move(column));
  }
  for (const work::Field& field : work::fields) {
    Column column{field.name, "", "1", field.meaning, {}};
    for (const Row& row : rows) column.values.push_back(static_cast<double>(row.work.*field.count));
    table.columns.push_back(std::move(column));
  }
  Column bytes = parts_column();
  for (const Row& row : rows) bytes.values.push_back(row.parts_bytes);
  table.columns.push_back(std::move(bytes));
  table.columns.push_back(std::move(message));
  return table;
}

Record cost_table(const std::string& name, const Timing& timing, std::vector<Column> leading,
                  const std::vector<Row>& rows) {
  Record table{
      name + "_cost",
      fmt::format("What each row cost; rows ran {}", timing.timed ? "one after another" : "side by side"),
      std::move(leading)};
  const char* of_repeats = timing.repeats > 0 ? ", median of repeats after a first run" : "";
  Column wall{"wall_seconds", "", "s", fmt::format("without the start of the program{}", of_repeats), {}};
  Column least{"min_wall_seconds", "", "s", "of the fastest repeat", {}};
  Column most{"max_wall_seconds", "", "s", "of the slowest repeat", {}};
  Column cpu{"cpu_seconds", "", "s", fmt::format("of all threads{}", of_repeats), {}};
  Column memory{"peak_memory_bytes", "", "byte", "largest memory of the program", {}};
  for (const Row& row : rows) {
    wall.values.push_back(row.wall_seconds);
    least.values.push_back(row.min_wall_seconds);
    most.values.push_back(row.max_wall_seconds);
    cpu.values.push_back(row.cpu_seconds);
    memory.values.push_back(row.peak_memory_bytes);
  }
  for (Column* column : {&wall, &least, &most, &cpu, &memory}) table.columns.push_back(std::move(*column));
  return table;
}

void Questions::answer(const Record& table, observe::Observations& seen) const {
  for (const engine::Asked& one : asked) {
    if (!one.across.empty()) {
      seen.open(one.name()) = numbers_across(one, table);
    } else if (seen.metric(one.name()) == nullptr) {
      seen.metrics.push_back(number(one, table));
    }
  }
}

Questions read_questions(const std::vector<io::Table>& checks, const std::string& name,
                         const std::vector<Column>& leading, const std::vector<Metric>& measured_by_a_run) {
  Record table{name, "", leading};
  for (const Metric& metric : measured_by_a_run)
    table.columns.push_back({metric.name, "", metric.dimension, metric.meaning, {}});
  for (const work::Field& field : work::fields)
    table.columns.push_back({field.name, "", "1", field.meaning, {}});
  table.columns.push_back(parts_column());
  Questions questions;
  questions.declares.records.push_back(table);
  for (const io::Table& check : checks) {
    if (!check.has("metric") && !engine::is_curve_of_numbers(check)) continue;
    const engine::Asked asked = engine::read_asked(check);
    check_asked(asked, table, check);
    const Column& metric = *table.find(asked.metric);
    if (asked.across.empty()) {
      questions.declares.metrics.push_back({asked.name(), {}, metric.dimension, metric.meaning});
    } else {
      questions.declares.records.push_back({asked.name(),
                                            "",
                                            {{engine::last_part(asked.across), "", "1", "", {}},
                                             {asked.metric, "", metric.dimension, "", {}}}});
    }
    questions.asked.push_back(asked);
    const std::optional<engine::Asked> gci = engine::read_asked_gci(check);
    if (!gci || questions.declares.metric(gci->name()) != nullptr) continue;
    if (table.find(gci->along) == nullptr) {
      check.table("uncertainty")
          .fail("gci_along", fmt::format("the study has no axis '{}'", gci->along),
                "the grids that are compared stand along it", "Name one of its axes");
    }
    questions.declares.metrics.push_back({gci->name(), {}, metric.dimension, metric.meaning});
    questions.asked.push_back(*gci);
  }
  return questions;
}

void refuse_if_none_was_read(const std::vector<Row>& rows) {
  const bool none_read =
      std::all_of(rows.begin(), rows.end(), [](const Row& r) { return r.outcome == "refused"; });
  if (none_read && !rows.empty()) {
    throw InputError(
        {}, fmt::format("no run of the study can be read, the first because of {}", rows.front().message), "",
        "Look at the keys and values of its axes");
  }
}

void count_rows(const std::vector<Row>& rows, observe::Observations& seen) {
  const auto completed =
      std::count_if(rows.begin(), rows.end(), [](const Row& row) { return row.outcome == "completed"; });
  seen.set("rows", static_cast<double>(rows.size()));
  seen.set("rows_completed", static_cast<double>(completed));
}

void warn_of_failures(const std::vector<Row>& rows, Progress& progress) {
  for (const Row& row : rows) {
    if (row.outcome != "completed")
      progress.warn(fmt::format("row {}: {}: {}", fmt::join(row.settings, " "), row.outcome, row.message));
  }
}

void declare(engine::Study& study, const Questions& questions, std::vector<std::vector<std::string>> runs,
             const Timing& timing) {
  study.measures.clear();
  study.declares = questions.declares;
  study.declares.metrics.push_back({"rows", {}, "1", "runs of the case"});
  study.declares.metrics.push_back({"rows_completed", {}, "1", "runs that came to their end"});
  study.runs = engine::Runs{std::move(runs), !timing.timed, 1 + timing.repeats};
}

}  // namespace veriflex::studies
