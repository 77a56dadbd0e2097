#include "engine/renamed.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "engine/reference.hpp"

namespace veriflex::engine {

namespace {

// A key of the tables called `table`, wherever they stand in the case; empty: at the top.
struct Renamed {
  std::string_view table, was, now;
};

constexpr std::array renamed_keys{
    Renamed{"", "asks", "question"},
    Renamed{"", "wave", "plane_wave"},
    Renamed{"", "waves", "dispersion"},
    Renamed{"", "motion", "integrator"},
    Renamed{"", "compare", "peer"},
    Renamed{"", "watch", "monitor"},
    Renamed{"check", "question", "kind"},
    Renamed{"bond", "depth", "epsilon"},
    Renamed{"bond", "diameter", "sigma"},
    Renamed{"bond", "attraction", "fene_k"},
    Renamed{"bond", "reach", "r_max"},
    Renamed{"coupling", "live", "subcycled"},
    Renamed{"coupling", "force", "allow_unstable"},
    Renamed{"coupling", "iterations", "forcing_iterations"},
    Renamed{"galilean", "side", "nodes"},
};

// Lists of values that a case once ran one after the other: an axis of a sweep now.
struct NowAxis {
  std::string_view path, axis;
};

constexpr std::array now_axes{
    NowAxis{"plane_wave.relaxation_times", "fluid.relaxation_time"},
    NowAxis{"vortex.planes", "vortex.plane"},
    NowAxis{"vortex.storages", "fluid.storage"},
    NowAxis{"galilean.speeds", "galilean.speed"},
    NowAxis{"channel.resolutions", "channel.nodes"},
    NowAxis{"channel.relaxation_times", "fluid.relaxation_time"},
    NowAxis{"channel.storages", "fluid.storage"},
    NowAxis{"tensile.sections", "solid.nodes.0"},
    NowAxis{"beam.lengths", "beam.length"},
    NowAxis{"elastica.lengths", "elastica.length"},
    NowAxis{"buckling.lengths", "buckling.length"},
    NowAxis{"torsion.sides", "torsion.side"},
    NowAxis{"torsion.sections", "torsion.side"},
    NowAxis{"shear.widths", "solid.nodes.0"},
    NowAxis{"dispersion.modes", "dispersion.mode"},
    NowAxis{"integrator.steps", "integrator.steps"},
    NowAxis{"immersed.relaxation_times", "fluid.relaxation_time"},
    NowAxis{"immersed.resolutions", "immersed.nodes"},
    NowAxis{"immersed.iterations", "coupling.forcing_iterations"},
    NowAxis{"immersed.forcing_iterations", "coupling.forcing_iterations"},
};

// Values that are names too.
struct RenamedValue {
  std::string_view path, was, now;
};

constexpr std::array renamed_values{
    RenamedValue{"driver", "wave", "plane-wave"},
    RenamedValue{"driver", "waves", "dispersion"},
    RenamedValue{"driver", "motion", "integrator"},
    RenamedValue{"driver", "compare", "peer"},
    RenamedValue{"driver", "stability", "scene"},
    RenamedValue{"driver", "filament-companions", "filament-sensitivity"},
    RenamedValue{"solid.lateral", "held", "fixed"},
    RenamedValue{"check[].question", "code", "verification"},
    RenamedValue{"check[].kind", "code", "verification"},
};

// The last part of a dotted path, and the name of the table it stands in.
std::pair<std::string_view, std::string_view> parts(std::string_view path) {
  const std::size_t dot = path.rfind('.');
  if (dot == std::string_view::npos) return {"", path};
  std::string_view table = path.substr(0, dot);
  table = table.substr(table.rfind('.') + 1);  // npos + 1 is 0
  if (table.ends_with("[]")) table.remove_suffix(2);
  return {table, path.substr(dot + 1)};
}

std::string is_now(std::string_view was, std::string_view now) {
  return fmt::format("'{}' is now '{}'", was, now);
}

// What is old about one key of a case and its value.
std::vector<std::string> old_in(const io::Table::Entry& entry) {
  std::vector<std::string> found;
  std::string_view path = entry.path;
  if (path.starts_with("assumed.")) {  // its keys are paths
    path.remove_prefix(8);
    const std::string_view first = path.substr(0, path.find('.'));
    if (const auto now = present_name(first)) found.push_back(is_now(first, *now));
  }
  if (const auto now = present_name(path)) found.push_back(is_now(parts(path).second, *now));
  if (!entry.text) return found;
  for (const RenamedValue& one : renamed_values) {
    if (one.path == path && one.was == *entry.text) found.push_back(is_now(one.was, one.now));
  }
  const std::vector<std::string>& kinds = target_kinds();
  if (path == "check[].kind" && std::find(kinds.begin(), kinds.end(), *entry.text) != kinds.end()) {
    found.push_back(is_now("kind", "target_kind"));
  }
  return found;
}

}  // namespace

std::optional<std::string> present_name(std::string_view path) {
  const auto [in, key] = parts(path);
  const std::string_view table = in == "compared_bond" ? "bond" : in;  // a bond law, too
  for (const Renamed& one : renamed_keys) {
    if (one.table == table && one.was == key) return std::string(one.now);
  }
  return std::nullopt;
}

std::optional<std::string> present_option(std::string_view word) {
  if (!word.starts_with("--")) return std::nullopt;
  std::optional<std::string> now =
      present_name(fmt::format("bond.{}", word.substr(2, word.find('=') - 2)));  // npos - 2 is far enough
  if (!now) return std::nullopt;
  std::replace(now->begin(), now->end(), '_', '-');
  return "--" + *now;
}

std::vector<InputError> old_names(const io::Table& top) {
  std::vector<InputError> errors;
  std::vector<std::string> said;
  for (const io::Table::Entry& entry : top.entries()) {
    for (const std::string& what : old_in(entry)) {
      if (std::find(said.begin(), said.end(), what) == said.end()) said.push_back(what);
      errors.emplace_back(entry.place, what, "since schema 2", "Write the new name");
    }
    for (const NowAxis& one : now_axes) {
      if (one.path != entry.path) continue;
      if (one.path == one.axis && !top.shown(entry.path)->starts_with('[')) continue;  // one value
      errors.emplace_back(entry.place, fmt::format("'{}' is now an axis of a sweep", one.path),
                          "a case measures one run, and its study makes many",
                          fmt::format("Write [sweep] axes = [{{ key = \"{}\", values = [...] }}]", one.axis));
    }
  }
  if (top.shown("coupling_stability.point")) {
    errors.emplace_back(top.table("coupling_stability").place("point"),
                        "'coupling_stability.point' is now a variant of the case",
                        "a case measures one run, and its study makes many",
                        "Write [[ablate.variants]] with name = \"...\" and set = { \"coupling.nodes\" = ..., "
                        "\"coupling_stability.substeps\" = ... }");
  }
  const std::int64_t schema = top.integer("schema", 0, 1'000'000);
  if (schema == case_schema) return errors;
  return {InputError(
      top.place("schema"), fmt::format("'schema' is {}", schema),
      said.empty() ? std::string("this program reads schema 2")
                   : fmt::format("in schema 2, {}", fmt::join(said, ", ")),
      fmt::format("{}schema = {}", said.empty() ? "Write " : "Write the new names and ", case_schema))};
}

}  // namespace veriflex::engine
