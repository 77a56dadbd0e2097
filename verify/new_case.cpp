#include "new_case.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <optional>
#include <sstream>
#include <tuple>
#include <vector>

#include "base/error.hpp"
#include "engine/case.hpp"
#include "io/file.hpp"
#include "studies/studies.hpp"

namespace veriflex {

namespace fs = std::filesystem;

namespace {

// A key with its value, which may take several lines.
struct KeyLines {
  std::string key, lines;
};

// `[header]` or `[[header]]`, empty for what stands before the first, and its keys. Comments are left out.
struct Block {
  std::string header;
  std::vector<KeyLines> entries;

  bool is_array() const { return header.starts_with("[["); }
  std::string name() const {
    return header.substr(is_array() ? 2 : 1, header.find(']') - (is_array() ? 2 : 1));
  }
  // The table at the top that this one is, or is part of.
  std::string top() const { return header.empty() ? "" : name().substr(0, name().find('.')); }
  const KeyLines* find(const std::string& key) const {
    const auto found =
        std::find_if(entries.begin(), entries.end(), [&](const KeyLines& e) { return e.key == key; });
    return found == entries.end() ? nullptr : &*found;
  }
};

// How far brackets are open behind a line, and where a comment begins in it.
struct Scan {
  int depth;
  std::size_t comment;
};
Scan scan(const std::string& line, int depth) {
  char quote = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quote != 0) {
      if (c == '\\' && quote == '"') {
        ++i;
      } else if (c == quote) {
        quote = 0;
      }
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '#') {
      return {depth, i};
    } else if (c == '[' || c == '{') {
      ++depth;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return {depth, line.size()};
}

std::vector<Block> blocks_of(const std::string& text) {
  std::vector<Block> blocks(1);
  int depth = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const bool inside = depth > 0;
    const Scan seen = scan(line, depth);
    line.resize(seen.comment);
    line.resize(line.find_last_not_of(" \t\r") + 1);
    if (line.empty()) continue;
    if (!inside && line.front() == '[') {
      blocks.push_back({line, {}});
      continue;
    }
    depth = seen.depth;
    if (inside) {
      blocks.back().entries.back().lines += "\n" + line;
      continue;
    }
    std::string key = line.substr(0, line.find('='));
    key.resize(key.find_last_not_of(' ') + 1);
    blocks.back().entries.push_back({key, line});
  }
  return blocks;
}

bool is_study(const std::string& table) {
  const std::vector<std::string>& tables = studies::tables();
  return std::find(tables.begin(), tables.end(), table) != tables.end();
}

// What each key means, by its documented path.
std::map<std::string, std::string> meanings(const fs::path& page) {
  std::map<std::string, std::string> all;
  std::istringstream lines(io::read_file(page));
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| `")) continue;
    std::vector<std::string> cells;
    for (std::size_t at = 1; at < line.size();) {
      const std::size_t end = std::min(line.find(" |", at), line.size());
      cells.push_back(line.substr(at + 1, end - at - 1));
      at = end + 2;
    }
    if (cells.size() != 4) continue;
    const std::string path = cells[0].substr(1, cells[0].size() - 2);
    const bool may_be_left_out =
        cells[3] != "required" && cells[3] != "none" && !cells[3].starts_with("this or");
    all.emplace(path, cells[2] + (may_be_left_out ? "; default: " + cells[3] : ""));
  }
  return all;
}

struct Template {
  std::vector<Block> blocks;
  std::ptrdiff_t tier;  // as engine::tiers() has them
  bool has_study;
  std::size_t size;

  auto order() const { return std::tuple(tier, has_study, size); }
};

Template template_for(const std::string& driver, const fs::path& folder) {
  std::optional<Template> best;
  for (const engine::CaseHead& head : engine::find_cases(folder)) {
    if (!head.problem.empty() || head.driver != driver) continue;
    const std::string text = io::read_file(head.path);
    const auto tier = std::find(engine::tiers().begin(), engine::tiers().end(), head.tier);
    Template one{blocks_of(text), tier - engine::tiers().begin(), false, text.size()};
    for (const Block& block : one.blocks) one.has_study = one.has_study || is_study(block.top());
    if (!best || one.order() < best->order()) best = one;
  }
  if (best) return *best;
  throw InputError({folder.string()}, fmt::format("holds no case of driver '{}'", driver),
                   "a new case is made of one", "See veriflex list");
}

// The first check that stands for itself, with its tables; none in a case whose checks ask for a study's
// rows.
std::vector<Block> one_check(const Template& from) {
  std::vector<Block> check;
  if (from.has_study) return check;
  for (const Block& block : from.blocks) {
    if (block.top() != "check") continue;
    if (block.is_array() && block.name() == "check") {
      if (!check.empty()) break;
      const KeyLines* kind = block.find("kind");
      const bool stands_alone = kind != nullptr && kind->lines.find("verification") != std::string::npos &&
                                block.find("target") != nullptr;
      if (!stands_alone) continue;
      check.push_back(block);
    } else if (!check.empty()) {
      check.push_back(block);
    }
  }
  return check;
}

void add(std::string& text, const Block& block, const std::map<std::string, std::string>& meaning) {
  if (!block.header.empty()) text += "\n" + block.header + "\n";
  const std::string before = block.header.empty() ? "" : block.name() + (block.is_array() ? "[]." : ".");
  for (const KeyLines& entry : block.entries) {
    std::string path = before + entry.key;
    if (path.starts_with("check.")) path.replace(0, 6, "check[].");
    if (path.starts_with("body.")) path.replace(0, 5, "body[].");
    const auto found = meaning.find(path);
    if (found != meaning.end()) text += "# " + found->second + "\n";
    text += entry.lines + "\n";
  }
}

}  // namespace

std::string new_case(const std::string& driver, const std::string& id, const fs::path& folder) {
  const std::map<std::string, std::string> meaning = meanings(folder / "README.md");
  const Template from = template_for(driver, folder);
  std::string text = fmt::format(
      "# A case of driver '{}', to be changed: cases/README.md has all keys. Its name must be that of its "
      "file.\n"
      "# veriflex validate {}.toml; veriflex plan {}.toml; veriflex run {}.toml\n",
      driver, id, id, id);
  for (Block block : from.blocks) {
    if (block.top() == "check" || block.top() == "assumed" || is_study(block.top())) continue;
    for (KeyLines& entry : block.entries) {
      if (!block.header.empty()) break;
      if (entry.key == "id") entry.lines = fmt::format("id = {}", io::toml_text(id));
      if (entry.key == "sources") entry.lines = "sources = []";
      if (entry.key == "topics") entry.lines = "topics = []";
    }
    // Studies may stand as inline tables, too.
    std::erase_if(block.entries, [&](const KeyLines& e) {
      return block.header.empty() && (is_study(e.key) || e.key == "assumed" || e.key == "check");
    });
    add(text, block, meaning);
  }
  for (const Block& block : one_check(from)) add(text, block, meaning);
  return text;
}

}  // namespace veriflex
