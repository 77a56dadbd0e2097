#include "show_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/say.hpp"
#include "engine/columns.hpp"
#include "engine/result.hpp"
#include "io/hdf5.hpp"
#include "observe/record.hpp"
#include "print_metrics.hpp"
#include "run_cases.hpp"

namespace veriflex {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using observe::Column;
using observe::Record;

struct ShowOptions {
  std::string result, record;
  std::string out = "results";
  bool csv = false, json = false;
};

// A result file by its path, or by the id of what ran.
fs::path result_named(const ShowOptions& o) {
  std::error_code unknown;
  if (fs::is_regular_file(o.result, unknown)) return o.result;
  const fs::path stored = fs::path(o.out) / (o.result + ".h5");
  if (fs::is_regular_file(stored, unknown)) return stored;
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(o.out, unknown)) {
    if (entry.path().extension() == ".h5") names.push_back(entry.path().stem().string());
  }
  const std::string near = nearest_name(o.result, names);
  throw InputError(
      {}, fmt::format("no result '{}'", o.result), fmt::format("neither a file nor a result in {}", o.out),
      near.empty() ? "Run the case first, or give another --out" : fmt::format("Did you mean '{}'?", near));
}

Record table_named(const io::Hdf5File& file, const std::string& name, const fs::path& path) {
  std::vector<std::string> known = file.names("/records");
  if (std::find(known.begin(), known.end(), name) != known.end()) return engine::read_record(file, name);
  const std::vector<std::string> always{"checks", "metrics", "timing", "parts"};
  if (std::find(always.begin(), always.end(), name) != always.end())
    return engine::read_table(file, "/" + name);
  known.insert(known.end(), always.begin(), always.end());
  const std::string near = nearest_name(name, known);
  throw InputError({path.string()}, fmt::format("has no record '{}'", name),
                   fmt::format("it has: {}", fmt::join(known, ", ")),
                   near.empty() ? "Name one of these" : fmt::format("Did you mean '{}'?", near));
}

std::size_t rows_of(const Record& record) {
  return record.columns.empty() ? 0 : record.columns.front().size();
}

std::string cell(const Column& column, std::size_t row, bool in_full) {
  if (!column.texts.empty()) return column.texts[row];
  return in_full ? fmt::format("{}", column.values[row]) : fmt::format("{:.10g}", column.values[row]);
}

// Columns under each other; the last is not filled up.
void print_aligned(const std::vector<std::vector<std::string>>& lines) {
  std::vector<std::size_t> widths;
  for (const std::vector<std::string>& line : lines) {
    widths.resize(std::max(widths.size(), line.size()));
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], line[c].size());
  }
  for (const std::vector<std::string>& line : lines) {
    std::string text;
    for (std::size_t c = 0; c < line.size(); ++c) {
      text += c + 1 < line.size() ? fmt::format("{:<{}}  ", line[c], widths[c]) : line[c];
    }
    say("  {}\n", text);
  }
}

void print_table(const Record& record) {
  if (!record.title.empty()) say("{}: {}\n", record.name, record.title);
  for (const Column& column : record.columns) {
    if (!column.dimension.empty()) say("  {} [{}] {}\n", column.name, column.dimension, column.meaning);
  }
  std::vector<std::vector<std::string>> lines(1 + rows_of(record));
  for (const Column& column : record.columns) {
    lines[0].push_back(column.name);
    for (std::size_t row = 0; row < rows_of(record); ++row)
      lines[row + 1].push_back(cell(column, row, false));
  }
  print_aligned(lines);
}

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

// Comments say what the columns are; then names and rows, numbers with all their digits.
void print_csv(const Record& record) {
  if (!record.title.empty()) say("# {}\n", record.title);
  for (const Column& column : record.columns) {
    if (!column.dimension.empty()) say("# {} [{}] {}\n", column.name, column.dimension, column.meaning);
  }
  std::vector<std::string> cells;
  for (const Column& column : record.columns) cells.push_back(csv_cell(column.name));
  say("{}\n", fmt::join(cells, ","));
  for (std::size_t row = 0; row < rows_of(record); ++row) {
    cells.clear();
    for (const Column& column : record.columns) cells.push_back(csv_cell(cell(column, row, true)));
    say("{}\n", fmt::join(cells, ","));
  }
}

Json json_of(const Record& record) {
  Json columns = Json::array();
  for (const Column& column : record.columns) {
    Json one{{"name", column.name}};
    if (!column.dimension.empty()) one["dimension"] = column.dimension;
    if (!column.meaning.empty()) one["meaning"] = column.meaning;
    Json values = Json::array();
    for (std::size_t row = 0; row < column.size(); ++row) {
      if (!column.texts.empty()) {
        values.push_back(column.texts[row]);
      } else {
        values.push_back(std::isfinite(column.values[row]) ? Json(column.values[row]) : Json(nullptr));
      }
    }
    one["values"] = values;
    columns.push_back(one);
  }
  return {{"name", record.name}, {"title", record.title}, {"columns", columns}};
}

// The table row by row, as `run --json` has it.
Json rows_json(const Record& record) {
  Json rows = Json::array();
  for (std::size_t row = 0; row < rows_of(record); ++row) {
    Json one;
    for (const Column& column : record.columns) {
      if (!column.texts.empty()) {
        one[column.name] = column.texts[row];
      } else {
        one[column.name] = std::isfinite(column.values[row]) ? Json(column.values[row]) : Json(nullptr);
      }
    }
    rows.push_back(one);
  }
  return rows;
}

void show_all(const io::Hdf5File& file, bool json) {
  const Record checks = engine::read_table(file, "/checks");
  const std::vector<std::string> names = file.names("/records");
  if (json) {
    Json records = Json::array();
    for (const std::string& name : names) {
      const Record record = engine::read_record(file, name);
      Json columns = Json::array();
      for (const Column& c : record.columns)
        columns.push_back({{"name", c.name}, {"dimension", c.dimension}, {"meaning", c.meaning}});
      records.push_back(
          {{"name", name}, {"title", record.title}, {"rows", rows_of(record)}, {"columns", columns}});
    }
    print_json(Json{{"id", file.attribute("/", "id")},
                    {"title", file.attribute("/", "title")},
                    {"verdict", file.attribute("/", "verdict")},
                    {"outcome", file.attribute("/", "outcome")},
                    {"checks", rows_json(checks)},
                    {"metrics", rows_json(engine::read_table(file, "/metrics"))},
                    {"records", records}});
    return;
  }
  say("{}: {}\n", file.attribute("/", "id"), file.attribute("/", "title"));
  const std::string verdict = file.attribute("/", "verdict");
  say("{}, driver {}, revision {}, {}\n", verdict, file.attribute("/", "driver"),
      file.attribute("/provenance", "revision"), file.attribute("/provenance", "date"));
  if (verdict == "error") say("  {}\n", file.attribute("/", "error_message"));
  if (rows_of(checks) > 0) say("checks\n");
  std::vector<std::vector<std::string>> lines{
      {"metric", "measured", "target", "margin", "verdict", "statement"}};
  const auto word = [&](const char* column, std::size_t row) {
    return engine::words_in(checks, column, file)[row];
  };
  const auto number = [&](const char* column, std::size_t row) {
    return engine::numbers_in(checks, column, file)[row];
  };
  for (std::size_t row = 0; row < rows_of(checks); ++row) {
    lines.push_back({word("metric", row), fmt::format("{:.10g}", number("measured", row)),
                     fmt::format("{:.10g}", number("target", row)),
                     fmt::format("{:.2g}", number("margin", row)), word("verdict", row),
                     word("statement", row)});
  }
  if (lines.size() > 1) print_aligned(lines);
  const std::vector<observe::Metric> numbers = engine::read_metrics(file, "/metrics");
  if (!numbers.empty()) say("metrics\n");
  print_metrics(numbers, "  ");
  if (!names.empty()) say("records\n");
  lines.clear();
  for (const std::string& name : names) {
    const Record record = engine::read_record(file, name);
    lines.push_back({name, fmt::format("{} x {}", rows_of(record), record.columns.size()), record.title});
  }
  print_aligned(lines);
}

void show_command(const ShowOptions& o) {
  const fs::path path = result_named(o);
  const io::Hdf5File file(path);
  if (o.record.empty() && !o.csv) {
    show_all(file, o.json);
    return;
  }
  const Record record = table_named(file, o.record.empty() ? "metrics" : o.record, path);
  if (o.csv) {
    print_csv(record);
  } else if (o.json) {
    print_json(json_of(record));
  } else {
    print_table(record);
  }
}

}  // namespace

void add_show_command(CLI::App& app) {
  const auto o = std::make_shared<ShowOptions>();
  CLI::App* show = app.add_subcommand("show", "what a result file holds: checks, metrics, records");
  show->add_option("result", o->result, "a result file, or the id of a result in --out")->required();
  show->add_option("record", o->record, "one table: a record, or checks, metrics, timing, parts");
  show->add_option("--out", o->out, "folder of results")->capture_default_str();
  CLI::Option* csv =
      show->add_flag("--csv", o->csv, "print the record (default: metrics) as comma-separated text");
  show->add_flag("--json", o->json, "print JSON")->excludes(csv);
  show->footer("Example: veriflex show tensile-fene-lj tensile --csv > curve.csv");
  show->callback([o] { show_command(*o); });
}

}  // namespace veriflex
