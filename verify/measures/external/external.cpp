// Numbers of another program as the measured side of checks: tables become records, single numbers metrics.
// Nothing is computed here but the exact laws that a table may be held against.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <regex>
#include <vector>

#include "base/reduce.hpp"
#include "io/csv.hpp"
#include "io/file.hpp"
#include "measures/data_file.hpp"
#include "measures/drivers.hpp"
#include "measures/external/exact_law.hpp"

namespace veriflex::measures {

namespace {

using external::ExactLaw;
using observe::Observations;

/// What the case file and the files that it names hold: all that a run hands on.
struct Given {
  std::vector<observe::Record> records;
  std::vector<observe::Metric> metrics;
  std::vector<scene::Built> built;  // where each comes from
};

/// A CSV file of the case, and a checksum that tells this one from a later one.
struct Csv {
  std::vector<io::CsvColumn> columns;
  std::string name, sha256;
};

Csv read_csv(const io::Table& table) {
  const std::filesystem::path file = data_file(table, "file");
  const std::string text = io::read_file(file);
  return {io::parse_csv(text, file.string()), table.text("file"), io::sha256(text)};
}

const io::CsvColumn& column_of(const Csv& csv, const std::string& name, const io::Table& asks,
                               const std::string& key) {
  std::vector<std::string> has;
  for (const io::CsvColumn& column : csv.columns) {
    if (column.name == name) return column;
    has.push_back(column.name);
  }
  asks.fail(key, fmt::format("'{}' has no column '{}'", csv.name, name),
            fmt::format("it has: {}", fmt::join(has, ", ")), "Correct the name here or in the file");
}

std::string read_dimension(const io::Table& table, const std::string& key) {
  static const std::regex powers("1|(?=[MLT])(M(\\^-?[1-9])?)?( ?L(\\^-?[1-9])?)?( ?T(\\^-?[1-9])?)?");
  const std::string dimension = table.text(key);
  if (!std::regex_match(dimension, powers)) {
    table.fail(key, fmt::format("'{}' is no dimension", dimension),
               "a dimension is powers of M, L and T in this order, such as \"M L^-1 T^-2\", or \"1\"",
               "Convert the numbers to one consistent set of units and write their dimension");
  }
  return dimension;
}

// What becomes a data set of the result file, or the name of a metric.
void check_name(const std::string& name, const Place& place) {
  static const std::regex plain("[A-Za-z]\\w*");
  if (std::regex_match(name, plain)) return;
  throw InputError(place, fmt::format("'{}' is no name of a record, column or number", name),
                   "checks and result files know them by letters, digits and '_'", "Rename it");
}

// Adds the law as a column beside the one that is held against it, and how far that is off as a metric.
void hold_against(const ExactLaw& law, const io::Table& exact, observe::Record& record, Given& given) {
  const auto named = [&](const std::string& key, const std::string& dimension) -> const observe::Column& {
    const observe::Column* column = record.find(exact.text(key));
    if (column == nullptr) {
      exact.fail(key, fmt::format("record '{}' has no column '{}'", record.name, exact.text(key)),
                 "the law is evaluated at one column and compared with another", "Name one of [columns]");
    }
    if (column->dimension != dimension) {
      exact.fail(key, fmt::format("'{}' has dimension {}", column->name, column->dimension),
                 fmt::format("{} is {} of the law '{}'", dimension, key, law.name),
                 "Convert the column, or name another");
    }
    return *column;
  };
  const observe::Column& x = named("x", law.x_dimension);
  const observe::Column& y = named("y", law.y_dimension);
  observe::Column wanted{y.name + "_exact", "", y.dimension, "the law '" + law.name + "' at " + x.name, {}};
  if (record.find(wanted.name) != nullptr) {
    exact.fail("y", fmt::format("record '{}' has a column '{}'", record.name, wanted.name),
               "the law's own values get that name", "Leave the column out, or rename it");
  }
  double largest_error = 0.0;
  double largest_wanted = 0.0;
  for (std::size_t row = 0; row < x.values.size(); ++row) {
    if (!law.domain.contains(x.values[row])) {
      exact.fail(
          "x", fmt::format("row {} of '{}' has {} = {}", row + 1, record.name, x.name, x.values[row]),
          fmt::format("the law '{}' holds between {:.6g} and {:.6g}", law.name, law.domain.lo, law.domain.hi),
          "Leave the row out, or look at the units");
    }
    wanted.values.push_back(law.at(x.values[row]));
    largest_error = worse(largest_error, std::abs(y.values[row] - wanted.values.back()));
    largest_wanted = worse(largest_wanted, std::abs(wanted.values.back()));
  }
  given.metrics.push_back(
      {record.name + "_error", relative_to(largest_error, largest_wanted), "1",
       fmt::format("largest distance of {} from the law '{}' over its largest magnitude", y.name, law.name)});
  record.columns.push_back(std::move(wanted));
}

void read_table(const io::Table& top, const io::Table& table, const std::string& code, Given& given) {
  const std::string name = table.text("record");
  if (std::any_of(given.records.begin(), given.records.end(),
                  [&](const observe::Record& other) { return other.name == name; })) {
    table.fail("record", fmt::format("'{}' is the record of two tables", name), "checks ask for it by name",
               "Rename one");
  }
  check_name(name, table.place("record"));
  const Csv csv = read_csv(table);
  observe::Record record{name, fmt::format("{} by {}", name, code), {}};
  const io::Table columns = table.table("columns");
  const std::vector<std::string> names = columns.keys();
  for (const std::string& column : names) {
    check_name(column, columns.place(column));
    column_of(csv, column, columns, column);
  }
  for (const io::CsvColumn& column : csv.columns) {  // in the order of the file: figures take the first as x
    if (std::find(names.begin(), names.end(), column.name) == names.end()) continue;
    record.columns.push_back(
        {column.name, "", read_dimension(columns, column.name), "as given by " + code, column.values});
  }
  if (record.columns.empty()) {
    table.fail("columns", "'columns' is empty", "nothing of the file is used",
               "Name the columns with their dimensions: columns = { strain = \"1\" }");
  }
  if (table.has("exact")) {
    const io::Table exact = table.table("exact");
    hold_against(external::read_exact_law(top, exact), exact, record, given);
  }
  given.built.push_back({"record " + name, fmt::format("{}, SHA-256 {}", csv.name, csv.sha256), 0.0});
  given.records.push_back(std::move(record));
}

double read_number_in_file(const io::Table& number, const std::string& name, Given& given) {
  const Csv csv = read_csv(number);
  const std::vector<double>& values = column_of(csv, name, number, "file").values;
  if (values.size() != 1) {
    number.fail("file", fmt::format("'{}' has {} rows", csv.name, values.size()), "a number needs one",
                "Read it as a [[external.table]], or keep one row");
  }
  given.built.push_back({"number " + name, fmt::format("{}, SHA-256 {}", csv.name, csv.sha256), 0.0});
  return values.front();
}

void read_number(const io::Table& number, const std::string& name, const std::string& code, Given& given) {
  check_name(name, number.place());
  if (number.has("value") == number.has("file")) {
    throw InputError(number.place(),
                     fmt::format("'{}' has {}", name,
                                 number.has("value") ? "both value and file" : "neither value nor file"),
                     "a number stands in one place", "Give value, or file: a CSV file with one row");
  }
  const double value =
      number.has("value") ? number.number("value") : read_number_in_file(number, name, given);
  if (std::any_of(given.metrics.begin(), given.metrics.end(),
                  [&](const observe::Metric& other) { return other.name == name; })) {
    throw InputError(number.place(), fmt::format("'{}' is the error of a table, too", name),
                     "checks ask for it by name", "Rename the number or the record");
  }
  given.metrics.push_back({name, value, read_dimension(number, "dimension"), "as given by " + code});
}

Observations external_observations(const Given& given) {
  Observations all;
  all.metrics = given.metrics;
  all.records = given.records;
  for (observe::Record& record : all.records) {
    for (observe::Column& column : record.columns) column.values.clear();
  }
  return all;
}

void hand_on(const Given& given, Observations& seen) {
  for (const observe::Metric& metric : given.metrics) seen.set(metric.name, metric.value);
  for (const observe::Record& record : given.records) seen.open(record.name) = record;
}

}  // namespace

engine::Study read_external(const io::Table& top) {
  const io::Table t = top.table("external");
  const engine::OtherCode code{t.text("code"), t.text("obtained"), t.text("case", "")};
  Given given;
  for (const io::Table& table : t.tables("table")) read_table(top, table, code.name, given);
  if (t.has("number")) {
    const io::Table numbers = t.table("number");
    for (const std::string& name : numbers.keys()) read_number(numbers.table(name), name, code.name, given);
  }
  if (given.records.empty() && given.metrics.empty()) {
    throw InputError(t.place(), "the case has no numbers", "they are what its checks judge",
                     "Add [[external.table]] or [external.number.<name>]");
  }
  return {.plan = {.built = given.built,
                   .left_out = {{"fluid, solid, coupling",
                                 fmt::format("the numbers are those of {}: {}", code.name, code.obtained)}}},
          .declares = external_observations(given),
          .run = [given](Observations& seen, Progress&, engine::Cost&) { hand_on(given, seen); },
          .other_code = code};
}

}  // namespace veriflex::measures
