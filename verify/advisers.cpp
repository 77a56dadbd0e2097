#include "advisers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "base/error.hpp"
#include "engine/columns.hpp"
#include "engine/only.hpp"
#include "engine/result.hpp"
#include "engine/stored_result.hpp"
#include "engine/symbols.hpp"

namespace veriflex {

namespace {

namespace fs = std::filesystem;

struct Value {
  std::string shown;
  bool is_word;
};
using Values = std::map<std::string, Value>;

// What a case is about, by dotted path.
Values values_of(const io::Table& top) {
  static const std::set<std::string> of_the_file{
      "schema", "id",      "title", "question", "equation", "sources", "tier",  "topics",
      "check",  "assumed", "sweep", "boundary", "ablate",   "monitor", "units", "observe"};
  Values values;
  const std::vector<io::Table::Entry> entries = top.entries();
  for (const io::Table::Entry& entry : entries) {
    const bool is_table = std::any_of(entries.begin(), entries.end(), [&](const io::Table::Entry& other) {
      return other.path.starts_with(entry.path + ".") || other.path.starts_with(entry.path + "[]");
    });
    if (is_table) continue;
    const std::string first = entry.path.substr(0, entry.path.find_first_of(".["));
    if (of_the_file.contains(first)) continue;
    std::string path;  // of the first where there are several
    for (const char c : entry.path)
      path += c == '[' ? std::string(".0") : c == ']' ? std::string() : std::string(1, c);
    if (const auto shown = top.shown(path)) values[path] = {*shown, entry.text.has_value()};
  }
  return values;
}

// Whether a difference in this key makes another kind of scene of it.
bool is_decisive(const std::string& path, const Value& value, const std::string& driver) {
  std::string table = driver;
  std::replace(table.begin(), table.end(), '-', '_');
  return path == "driver" || path.ends_with("law") || (value.is_word && path.starts_with(table + "."));
}

// Nothing where the sweep is about another kind of scene.
std::optional<std::vector<std::string>> differences(const Values& theirs, const Values& mine,
                                                    const std::set<std::string>& swept,
                                                    const std::string& driver) {
  std::vector<std::string> all;
  std::set<std::string> paths;
  for (const auto& [path, value] : theirs) paths.insert(path);
  for (const auto& [path, value] : mine) paths.insert(path);
  for (const std::string& path : paths) {
    const bool is_swept = std::any_of(swept.begin(), swept.end(), [&](const std::string& key) {
      return key == path || key.starts_with(path + ".");
    });
    if (is_swept) continue;
    const auto their = theirs.find(path), my = mine.find(path);
    const bool in_both = their != theirs.end() && my != mine.end();
    if (in_both && their->second.shown == my->second.shown) continue;
    if (is_decisive(path, (in_both || my == mine.end() ? their : my)->second, driver)) return std::nullopt;
    all.push_back(fmt::format("{}: {}, here {}", path,
                              their == theirs.end() ? "not given" : their->second.shown,
                              my == mine.end() ? "not given" : my->second.shown));
  }
  return all;
}

}  // namespace

std::vector<Adviser> advisers_of(const io::Table& top, const fs::path& out) {
  const Values mine = values_of(top);
  const std::string driver = top.text("driver");
  std::vector<Adviser> found;
  std::error_code none;
  if (!fs::is_directory(out, none)) return found;
  for (const fs::path& path : engine::result_files(out)) {
    try {
      const io::Hdf5File file(path);
      engine::read_record(file, "sweep_cost_front");
      const observe::Record sweep = engine::read_record(file, "sweep");
      const io::Table theirs =
          engine::parse_case(engine::only(file.texts("/case"), path.string(), "/case"), path.string());
      std::set<std::string> swept;
      for (const observe::Column& axis : studies::axes_of(sweep)) swept.insert(axis.name);
      for (const studies::Axis& axis : own_axes(theirs, file))
        swept.insert(axis.keys.begin(), axis.keys.end());
      if (const auto differ = differences(values_of(theirs), mine, swept, driver))
        found.push_back({path, *differ});
    } catch (const InputError&) {  // no sweep with an error and times
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Adviser& a, const Adviser& b) {
    return a.differences.size() < b.differences.size();
  });
  return found;
}

std::vector<studies::Axis> own_axes(const io::Table& top, const io::Hdf5File& file) {
  if (!top.has("sweep") || !file.attribute("/", "variant").empty()) return {};
  return studies::read_axes(top.table("sweep"));
}

std::string error_of_sweep(const io::Hdf5File& file) {
  const observe::Record front = engine::read_record(file, "sweep_front");
  if (front.columns.size() >= 2) return front.columns[front.columns.size() - 2].name;
  throw InputError({file.name()}, "no error in sweep_front", "the file is not as its schema says",
                   "Run the sweep again");
}

studies::SweptRows rows_of(const io::Hdf5File& file, const std::string& path) {
  try {
    const std::string error = error_of_sweep(file);
    const observe::Record sweep = engine::read_record(file, "sweep"),
                          cost = engine::read_record(file, "sweep_cost");
    const std::size_t rows = engine::numbers_in(sweep, error, file).size();
    for (const char* const spent : {"min_wall_seconds", "peak_memory_bytes"}) {
      if (engine::numbers_in(cost, spent, file).size() == rows) continue;
      throw InputError({file.name()}, "sweep and sweep_cost differ in length",
                       "the file is not as its schema says", "Run the sweep again");
    }
    return studies::swept_rows(sweep, cost, error);
  } catch (const InputError&) {
    throw InputError({path}, "this is no sweep with an error", "advice needs to know what the rows' error is",
                     "Give the sweep error = \"<metric>\", or veriflex sweep --error, and run it again");
  }
}

}  // namespace veriflex
