#include "studies/studies.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "engine/symbols.hpp"
#include "io/file.hpp"
#include "measures/drivers.hpp"
#include "repository.hpp"
#include "studies/ablate.hpp"
#include "studies/boundary.hpp"
#include "studies/grid.hpp"
#include "studies/sweep.hpp"

namespace veriflex::studies {

namespace {

using Read = engine::Study (*)(const io::Table&, const std::vector<io::Table>&, const Base&, engine::Study,
                               const Workspace&);
struct Kind {
  std::string table;
  Read read;
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all{
      {"sweep", &read_sweep}, {"boundary", &read_boundary}, {"ablate", &read_ablate}};
  return all;
}

}  // namespace

const std::vector<std::string>& tables() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Kind& kind : kinds()) all.push_back(kind.table);
    return all;
  }();
  return names;
}

namespace {

// The case that the rows of its study vary.
Base base_of(const engine::Case& c, const engine::Study& measure) {
  Base base{.path = std::filesystem::absolute(c.path),
            .id = c.id,
            .text = c.text,
            .overrides = {},
            .name = c.name(),
            .records = measure.declares.records};
  for (const std::string& one : c.overrides) {
    const std::string key = one.substr(0, one.find_first_of(".="));
    if (std::find(tables().begin(), tables().end(), key) == tables().end()) base.overrides.push_back(one);
  }
  return base;
}

}  // namespace

engine::Readers readers(const Workspace& workspace) {
  return {.drivers = measures::all(),
          .study = [workspace](const io::Table& top, const std::vector<io::Table>& checks,
                               const engine::Case& c, engine::Study measure) {
            const Kind* found = nullptr;
            for (const Kind& kind : kinds()) {
              if (!top.has(kind.table)) continue;
              if (found != nullptr) {
                top.fail(kind.table, fmt::format("both [{}] and [{}]", found->table, kind.table),
                         "a case is one question", "Keep one, or make two cases");
              }
              found = &kind;
            }
            if (found == nullptr) return measure;
            return found->read(top.table(found->table), checks, base_of(c, measure), measure, workspace);
          }};
}

engine::Readers readers_of_row() {
  return {.drivers = measures::all(),
          .study =
              [](const io::Table& top, const std::vector<io::Table>&, const engine::Case&,
                 engine::Study measure) {
                for (const std::string& name : tables()) {
                  if (top.has(name)) top.table(name).abandon();
                }
                return measure;
              },
          .with_checks = false};
}

void require_rows(const std::filesystem::path& path) {
  constexpr std::size_t tried = 16;
  const auto read = [&](const std::vector<std::string>& changed) {
    try {
      engine::read_case(path, changed, readers_of_row(), repository::references());
      return std::string();
    } catch (const InputError& error) {
      return std::string(error.what());
    }
  };
  if (!read({}).empty()) return;
  const io::Table top = engine::parse_case(io::read_file(path), path.string());
  for (const std::string name : {"sweep", "boundary"}) {
    if (!top.has(name)) continue;
    const io::Table study = top.table(name);
    const std::vector<Axis> axes = read_axes(study);
    const std::vector<Cell> all = cells(axes);
    std::string first;
    for (std::size_t i = 0; i < all.size(); i += 1 + all.size() / tried) {
      std::vector<std::string> changed = settings(axes, all[i]);
      if (name == "boundary") changed.push_back(study.text("key") + "=" + study.shown_value("from"));
      const std::string problem = read(changed);
      if (problem.empty()) return;
      if (first.empty()) first = problem;
    }
    top.fail(name, fmt::format("none of its rows can be read, the first because of {}", first), "",
             "Look at the keys and values of its axes");
  }
}

}  // namespace veriflex::studies
