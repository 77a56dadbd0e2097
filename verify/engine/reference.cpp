#include "engine/reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/mutant.hpp"
#include "io/file.hpp"

namespace veriflex::engine {

namespace fs = std::filesystem;

namespace {

// Columns become data sets of that name in a result file.
void check_names(const std::vector<io::CsvColumn>& columns, const fs::path& file) {
  if (columns.size() > io::longest_list) {
    throw InputError({file.string()}, fmt::format("has {} columns", columns.size()),
                     fmt::format("a result file keeps {}", io::longest_list), "Leave out what is not used");
  }
  for (const io::CsvColumn& column : columns) {
    const std::string& name = column.name;
    const bool unprintable =
        std::any_of(name.begin(), name.end(), [](unsigned char c) { return std::iscntrl(c) != 0; });
    if (name == "." || name.find('/') != std::string::npos || unprintable) {
      throw InputError({file.string()}, fmt::format("a column is named '{}'", name),
                       "a result file could not hold it: no '.' alone, no '/', no control characters",
                       "Rename it");
    }
  }
}

std::vector<io::CsvColumn> read_data(const io::Table& data, const fs::path& folder, std::string& sha256) {
  const fs::path file = folder / data.text("file");
  sha256 = data.text("sha256");
  std::error_code impossible;
  if (!fs::is_regular_file(file, impossible)) {
    data.fail("file", fmt::format("data file '{}' does not exist", file.string()),
              "it is named relative to the reference",
              "Put it there, or make it again with the reference's command");
  }
  const std::string text = io::read_file(file);
  const std::string found = io::sha256(text);
  if (found != sha256 && !planted(Mutant::checksum_not_compared)) {
    data.fail("sha256", fmt::format("'{}' does not match its checksum", file.string()),
              "it has SHA-256 " + found, "Restore the file, or renew the checksum with a stated reason");
  }
  std::vector<io::CsvColumn> columns = io::parse_csv(text, file.string());
  check_names(columns, file);
  return columns;
}

void read_tolerance(const io::Table& tolerance, Origin& origin) {
  origin.relative = tolerance.number("relative", origin.relative);
  origin.absolute = tolerance.number("absolute", origin.absolute);
  if (!(std::min(origin.relative, origin.absolute) >= 0.0)) {
    throw InputError(tolerance.place(), "a tolerance is negative", "it bounds a distance", "Give 0 or more");
  }
}

observe::Record read_table(const io::Table& top) {
  const io::Table table = top.table("table");
  observe::Record record{table.text("record"), "", {}};
  for (const io::Table& column : table.tables("column")) {
    const bool of_words = column.has("texts");
    record.columns.push_back({column.text("name"), "", "", "",
                              of_words ? std::vector<double>{} : column.numbers_or_none("numbers"),
                              of_words ? column.texts("texts") : std::vector<std::string>{}});
    if (record.columns.back().size() != record.columns.front().size()) {
      column.fail(of_words ? "texts" : "numbers",
                  fmt::format("{} rows, not {}", record.columns.back().size(), record.columns.front().size()),
                  "columns of a table are equally long", "Renew it: veriflex accept --replace");
    }
  }
  return record;
}

// A case and its reference may share their stem, also when both lie in one folder's reach.
bool is_case(const fs::path& path) {
  return io::parse_document(io::read_file(path), path.string()).has("driver");
}

}  // namespace

double Origin::allowed(double value) const { return std::max(relative * std::abs(value), absolute); }

const std::vector<std::string>& reference_kinds() {
  static const std::vector<std::string> kinds{"analytic",         "high-precision",  "peer-code",
                                              "published-number", "published-curve", "baseline"};
  return kinds;
}

const std::vector<std::string>& target_kinds() {
  static const std::vector<std::string> kinds = [] {
    std::vector<std::string> all = reference_kinds();
    all.emplace_back("reading");
    return all;
  }();
  return kinds;
}

Reference read_reference(const fs::path& path) {
  return read_reference(io::parse_document(io::read_file(path), path.string()), path);
}

Reference read_reference(const io::Table& top, const fs::path& path) {
  Reference reference;
  reference.path = path;
  top.integer("schema", 1, 1);
  reference.id = top.text("id");
  if (reference.id != path.stem().string()) {
    top.fail("id", fmt::format("id '{}' differs from the file's name", reference.id), "they must agree",
             fmt::format("Write id = \"{}\"", path.stem().string()));
  }
  if (reference.id == ".") {
    top.fail("id", "id '.' is no name", "a result file could not hold it", "Rename the reference");
  }
  reference.kind = top.choice("kind", reference_kinds());
  reference.source = top.text("source");
  reference.obtained = top.text("obtained");
  reference.command = top.text("command", "");
  const bool published = reference.kind.starts_with("published-");
  if (published || top.has("citations")) reference.citations = top.texts("citations");
  reference.citations_at = top.place("citations");
  if (published && reference.citations.empty()) {
    top.fail("citations", "'citations' is empty", "what is published was published somewhere",
             "Name a key of bibliography.bib");
  }
  if (reference.kind == "baseline") {
    const io::Table origin = top.table("provenance");
    reference.origin = {.revision = origin.text("revision"),
                        .compiler = origin.text("compiler"),
                        .machine = origin.text("machine"),
                        .date = origin.text("date"),
                        .reason = origin.text("reason")};
    if (top.has("tolerance")) read_tolerance(top.table("tolerance"), *reference.origin);
    if (top.has("table")) reference.table = read_table(top);
  }
  if (top.has("values")) {
    const io::Table values = top.table("values");
    for (const std::string& name : values.keys()) {
      const io::Table value = values.table(name);
      // A law may hold at any strain: a baseline then says inf.
      const double number = reference.origin ? value.number_or_infinity("value") : value.number("value");
      reference.values[name] = {number, value.number("uncertainty", 0.0), value.text("dimension"),
                                value.text("meaning")};
    }
  }
  if (top.has("data")) reference.columns = read_data(top.table("data"), path.parent_path(), reference.sha256);
  if (reference.values.empty() && reference.columns.empty() && !reference.table) {
    throw InputError(top.place(), "the reference holds neither values nor data",
                     "it can be compared with nothing", "Add [values.<name>] or [data]");
  }
  top.finish();
  return reference;
}

Reference find_reference(const std::string& id, const fs::path& beside, const fs::path& shared,
                         const Place& asked_at) {
  for (const fs::path& folder : {beside, shared}) {
    const fs::path path = folder / (id + ".toml");
    std::error_code impossible;  // such as a name too long for the file system
    if (fs::exists(path, impossible) && !is_case(path)) return read_reference(path);
  }
  throw InputError(asked_at, fmt::format("reference '{}' not found", id),
                   fmt::format("looked for {}.toml in {} and {}", id, beside.string(), shared.string()),
                   "Put it beside the case or correct the name");
}

void need_columns(const Reference& reference, const std::vector<std::string>& names, const io::Table& asks,
                  const std::string& key) {
  for (const std::string& name : names) {
    if (std::none_of(reference.columns.begin(), reference.columns.end(),
                     [&](const io::CsvColumn& has) { return has.name == name; })) {
      asks.fail(key, fmt::format("reference '{}' has no column '{}'", reference.id, name),
                "a curve is compared column by column of the same name", "Look at its data file");
    }
  }
}

}  // namespace veriflex::engine
