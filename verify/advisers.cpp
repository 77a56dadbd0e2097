#include "advisers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "base/error.hpp"
#include "engine/result.hpp"
#include "engine/symbols.hpp"
#include "studies/grid.hpp"

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
  std::vector<fs::path> files;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(out, none))
    if (entry.path().extension() == ".h5") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file_path : files) {
    try {
      const io::Hdf5File file(file_path);
      engine::read_record(file, "sweep_cost_front");
      const observe::Record sweep = engine::read_record(file, "sweep");
      const io::Table theirs = engine::parse_case(file.texts("/case").front(), file_path.string());
      std::set<std::string> swept;
      for (const observe::Column& column : sweep.columns) {
        if (column.name == "outcome") break;
        swept.insert(column.name);
      }
      if (theirs.has("sweep") && file.attribute("/", "variant").empty()) {
        for (const studies::Axis& axis : studies::read_axes(theirs.table("sweep")))
          swept.insert(axis.keys.begin(), axis.keys.end());
      }
      if (const auto differ = differences(values_of(theirs), mine, swept, driver))
        found.push_back({file_path, file.attribute("/", "case_id"), *differ});
    } catch (const InputError&) {  // no sweep with an error and times
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const Adviser& a, const Adviser& b) {
    return a.differences.size() < b.differences.size();
  });
  return found;
}

}  // namespace veriflex
