#include "studies/studies.hpp"

#include <fmt/format.h>

#include "measures/drivers.hpp"
#include "studies/ablate.hpp"
#include "studies/boundary.hpp"
#include "studies/sweep.hpp"

namespace veriflex::studies {

namespace {

using Read = engine::Study (*)(const io::Table&, const engine::Case&, engine::Study, const Workspace&);
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

engine::Readers readers(const Workspace& workspace) {
  return {.drivers = measures::all(),
          .study = [workspace](const io::Table& top, const engine::Case& c, engine::Study measure) {
            const Kind* found = nullptr;
            for (const Kind& kind : kinds()) {
              if (!top.has(kind.table)) continue;
              if (found != nullptr) {
                top.fail(kind.table, fmt::format("both [{}] and [{}]", found->table, kind.table),
                         "a case is one question", "Keep one, or make two cases");
              }
              found = &kind;
            }
            return found == nullptr ? std::move(measure) : found->read(top, c, std::move(measure), workspace);
          }};
}

engine::Readers readers_of_row() {
  return {.drivers = measures::all(),
          .study =
              [](const io::Table& top, const engine::Case&, engine::Study measure) {
                for (const std::string& name : tables()) {
                  if (top.has(name)) top.table(name).abandon();
                }
                return measure;
              },
          .with_checks = false};
}

}  // namespace veriflex::studies
