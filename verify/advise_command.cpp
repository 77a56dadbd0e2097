#include "advise_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>

#include "advise_rod.hpp"
#include "advisers.hpp"
#include "base/error.hpp"
#include "base/say.hpp"
#include "engine/only.hpp"
#include "engine/result.hpp"
#include "engine/symbols.hpp"
#include "exit_code.hpp"
#include "io/file.hpp"
#include "repository.hpp"
#include "run_cases.hpp"
#include "studies/advise.hpp"
#include "threads.hpp"

namespace veriflex {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct AdviseOptions {
  std::string study;
  std::string out = "results";
  std::string case_folder = repository::cases().string();
  double error = 0.0;
  double budget = 0.0;
  std::vector<std::string> where;
  bool json = false;
  RodInFlow rod;
  std::string write;
  int threads = 0;
};

// A result with the sweep that is asked, and how the case that is to be advised differs from it.
Adviser adviser(const AdviseOptions& o) {
  const fs::path given = o.study;
  if (given.extension() == ".h5") return {given, {}};
  const fs::path stored = fs::path(o.out) / (o.study + ".h5");
  std::error_code unknown;
  if (fs::is_regular_file(stored, unknown)) {
    try {
      engine::read_record(io::Hdf5File(stored), "sweep_front");
      return {stored, {}};
    } catch (const InputError&) {  // a run of the case, and no sweep over it
    }
  }
  const fs::path path = engine::case_named(o.study, o.case_folder);
  const std::vector<Adviser> able =
      advisers_of(engine::parse_case(io::read_file(path), path.string()), o.out);
  if (!able.empty()) return able.front();
  throw InputError(
      {path.string()}, fmt::format("no result in {} can advise it", o.out),
      "advice is taken from a timed sweep of this case, or of one of the same driver, law and kind of scene",
      fmt::format(
          "Run a case cost-... of the kind, or veriflex sweep {} --timed --error METRIC --over KEY=..., "
          "with --out {}",
          o.study, o.out));
}

// `key=value` of what an axis sets beside its first key, and the axis itself with that value alone, as TOML.
struct Full {
  std::vector<std::string> settings, axes;
};
Full full_setting(const std::vector<std::string>& advised, const std::vector<studies::Axis>& own) {
  Full full;
  for (const std::string& one : advised) {
    const std::size_t equals = one.find('=');
    const std::string key = one.substr(0, equals), value = one.substr(equals + 1);
    const auto axis =
        std::find_if(own.begin(), own.end(), [&](const studies::Axis& a) { return a.name() == key; });
    auto values = axis == own.end() ? std::nullopt : studies::values_at(*axis, value);
    full.settings.push_back(one);
    if (!values) continue;
    std::vector<std::string> keys;
    for (const std::string& each : axis->keys) keys.push_back(io::toml_text(each));
    // In double quotes, so that a shell's single ones may stand around it.
    for (std::string& each : *values)
      if (each.starts_with('\'')) each = io::toml_text(studies::bare(each));
    for (std::size_t k = 1; k < values->size(); ++k)
      full.settings.push_back(fmt::format("{}={}", axis->keys[k], (*values)[k]));
    full.axes.push_back(keys.size() == 1
                            ? fmt::format("{{ key = {}, values = [{}] }}", keys.front(), values->front())
                            : fmt::format("{{ keys = [{}], values = [[{}]] }}", fmt::join(keys, ", "),
                                          fmt::join(*values, ", ")));
  }
  return full;
}

studies::SweptRows rows_where(const std::vector<std::string>& given, studies::SweptRows rows) {
  for (const std::string& one : given) {
    const std::size_t equals = one.find('=');
    if (equals == std::string::npos)
      throw InputError({}, fmt::format("--where is {}", one), "it names an axis and its value",
                       "Use --where fluid.relaxation_time=0.8");
    try {
      rows = studies::only(rows, one.substr(0, equals), one.substr(equals + 1));
    } catch (const BadParameter& bad) {
      throw InputError({}, fmt::format("--where {}: {}", one, bad.problem), bad.why, bad.suggestion);
    }
  }
  return rows;
}

int advise_command(const AdviseOptions& o) {
  const Adviser from = adviser(o);
  const fs::path path = from.result;
  const io::Hdf5File file(path);
  const studies::SweptRows rows = rows_where(o.where, rows_of(file, path.string()));
  const studies::Advice found = studies::advise(
      rows, {.error = o.error, .budget = o.budget > 0.0 ? std::optional(o.budget) : std::nullopt});
  const std::string machine = file.attribute("/provenance", "machine");
  const std::string id = file.attribute("/", "case_id");
  const io::Table stored =
      engine::parse_case(engine::only(file.texts("/case"), path, "/case"), "the stored case");
  const Full full = full_setting(found.setting, own_axes(stored, file));
  if (o.json) {
    print_json(Json{
        {"case", id},
        {"error_wanted", o.error},
        {"setting", full.settings},
        {"axes", full.axes},
        {"predicted", {{"error", found.error}, {"seconds", found.seconds}, {"memory_bytes", found.memory}}},
        {"within_the_sweep", found.is_within},
        {"measured", found.is_measured},
        {"limited_by", found.limited_by},
        {"rows", found.rows},
        {"left_out_rows_within", {{"error", found.error_factor}, {"seconds", found.time_factor}}},
        {"study", path.string()},
        {"differences", from.differences},
        {"failures_beside", found.failures},
        {"machine", machine}});
    return exit_code::success;
  }
  say("{}: the cheapest setting for an error of {:.3g}\n", id, o.error);
  for (const std::string& one : full.settings) say("    {}\n", one);
  say("  {}: error {:.3g}, run time {:.3g} s, memory {:.3g} MB, on {}\n",
      found.is_measured ? "measured" : "predicted", found.error, found.seconds, found.memory / 1e6, machine);
  say("  limited by: {}\n", found.limited_by);
  say("  stability: {}\n", found.failures.empty()
                               ? "all rows of these words completed"
                               : fmt::format("beside it failed {}", fmt::join(found.failures, "; ")));
  say("  from {} rows of {}; each predicted from the others is within a factor of {:.3g} (error), {:.3g} "
      "(time)\n",
      found.rows, path.string(), found.error_factor, found.time_factor);
  if (found.is_measured) say("  This is a row that was run.\n");
  if (!found.is_within) say("  This lies beyond the sweep, by a factor of two at most: extrapolated.\n");
  if (!from.differences.empty()) {
    say("  The study's scene is not this case's; they differ in\n");
    constexpr std::size_t most = 12;
    for (std::size_t i = 0; i < std::min(most, from.differences.size()); ++i)
      say("    {}\n", from.differences[i]);
    if (from.differences.size() > most) say("    and {} more\n", from.differences.size() - most);
  }
  if (full.axes.size() == found.setting.size()) {
    say("  Try it: veriflex run {} --set 'sweep.axes=[{}]'\n", id, fmt::join(full.axes, ", "));
    return exit_code::success;
  }
  say("  Try it: veriflex sweep {} --timed", id);
  for (const std::string& one : found.setting) say(" --over {}", one);
  say("\n");
  return exit_code::success;
}

int advise_rod_command(const AdviseOptions& o) {
  if (!(o.rod.rod_length >= o.rod.flow.length))
    throw InputError({}, fmt::format("--rod-length is {}", o.rod.rod_length),
                     "a rod is longer than its diameter", "Give both in metres");
  RodAdvice found;
  try {
    found = advise_rod(o.rod, o.error, o.out, usable_threads(o.threads));
  } catch (const BadParameter& bad) {
    throw InputError(
        {}, fmt::format("--{}: {}", bad.parameter == "length" ? "diameter" : bad.parameter, bad.problem),
        bad.why, bad.suggestion);
  }
  if (!o.write.empty())
    io::write_file(o.write, fmt::format("schema = 2\nid = {}\n{}",
                                        io::toml_text(fs::path(o.write).stem().string()), found.scene));
  const auto or_null = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
  };
  if (o.json) {
    Json settings = Json::array();
    for (const Advised& one : found.settings)
      settings.push_back({{"setting", one.setting}, {"why", one.why}});
    print_json(Json{{"error_wanted", o.error},
                    {"settings", settings},
                    {"predicted",
                     {{"error", found.error},
                      {"terms", found.errors},
                      {"seconds", or_null(found.seconds)},
                      {"memory_bytes", or_null(found.memory)}}},
                    {"coupling_growth", or_null(found.coupling_growth)}});
    return exit_code::success;
  }
  std::size_t width = 0;
  for (const Advised& one : found.settings) width = std::max(width, one.setting.size());
  for (const Advised& one : found.settings) say("  {:<{}}  {}\n", one.setting, width, one.why);
  say("  predicted: error {:.2g}, {} ({})\n", found.error,
      found.error > o.error ? fmt::format("more than the {:.2g} that is wanted", o.error)
                            : fmt::format("of {:.2g} that is wanted", o.error),
      fmt::join(found.errors, "; "));
  say("  run time {}, memory {:.3g} MB\n",
      found.seconds ? fmt::format("about {:.2g} s on this machine", *found.seconds) : "not known",
      *found.memory / 1e6);
  if (found.coupling_growth) {
    say("  stability: {}\n",
        *found.coupling_growth > 1.0
            ? fmt::format("the exchange grows by {:.3g} a step: take heavier nodes or more sub-steps",
                          *found.coupling_growth)
            : "the linearised exchange does not grow");
  }
  if (!o.write.empty()) say("  Try it: veriflex run {}\n", o.write);
  for (const engine::Quantity& q : found.quantities) {
    if (!q.fault.empty()) say("  {} = {:.3g}: {}. Take {}\n", q.name, q.lattice, q.fault, q.remedy);
  }
  return exit_code::success;
}

}  // namespace

void add_advise_command(CLI::App& app, int& exit_code) {
  const auto o = std::make_shared<AdviseOptions>();
  CLI::App* advise = app.add_subcommand(
      "advise", "the cheapest setting for an error, from a sweep that says what its error costs");
  CLI::Option* study = advise->add_option(
      "study", o->study,
      "a case that was swept, by id or result file; or any case: the stored sweep that is most like it "
      "advises it");
  engine::Physical& flow = o->rod.flow;
  CLI::Option* viscosity =
      advise->add_option("--viscosity,--nu", flow.viscosity,
                         "kinematic: a flexible rod in a flow is advised from numbers in SI [m^2/s]");
  viscosity->excludes(study);
  CLI::Option* speed = advise->add_option("--speed", flow.speed, "of that flow [m/s]")->needs(viscosity);
  CLI::Option* diameter = advise->add_option("--diameter", flow.length, "of the rod [m]")->needs(viscosity);
  CLI::Option* length = advise->add_option("--rod-length", o->rod.rod_length, "[m]")->needs(viscosity);
  viscosity->needs(speed)->needs(diameter)->needs(length);
  advise->add_option("--density", flow.density, "of the fluid [kg/m^3]")
      ->needs(viscosity)
      ->capture_default_str();
  advise->add_option("--young", flow.young_modulus, "of the rod [Pa]; without it the rod is rigid")
      ->needs(viscosity);
  advise->add_option("--solid-density", flow.solid_density, "of the rod [kg/m^3] (default: the fluid's)")
      ->needs(viscosity);
  advise->add_option("--amplitude", o->rod.amplitude, "how far the rod is moved [m]")->needs(viscosity);
  advise->add_option("--duration", o->rod.duration, "of the run [s] (default: ten rod lengths of the flow)")
      ->needs(viscosity);
  advise->add_option("--write", o->write, "a case file of it, which is made or replaced")->needs(viscosity);
  advise->add_option("--threads", o->threads, "threads that a run would have (default: all cores)")
      ->check(CLI::Range(1, 4096));
  advise->add_option("--error", o->error, "the error that is to be reached")->required();
  advise->add_option("--budget", o->budget, "the most run time [s]");
  advise
      ->add_option("--where", o->where,
                   "KEY=VALUE of an axis of the sweep that is not to be chosen (repeat it for more)")
      ->excludes(viscosity);
  advise->add_option("--out", o->out, "folder of results")->capture_default_str();
  advise->add_option("--cases", o->case_folder, "folder of case files")->capture_default_str();
  advise->add_flag("--json", o->json, "print JSON");
  advise->footer(
      "Example: veriflex run cost-oscillation-pair; veriflex advise cost-oscillation-pair --error 1e-4\n"
      "         veriflex advise --viscosity 1e-6 --speed 0.01 --diameter 1e-3 --rod-length 0.02 --young 1e4 "
      "--error 0.02");
  advise->callback([o, viscosity, &exit_code] {
    if (o->study.empty() && viscosity->count() == 0) {
      throw InputError({}, "neither a study nor a flow is given", "there is nothing to advise",
                       "Name a case, or give --viscosity, --speed, --diameter and --rod-length");
    }
    if (!(o->error > 0.0))
      throw InputError({}, fmt::format("--error is {}", o->error), "it must be positive", "Use 1e-3");
    exit_code = viscosity->count() > 0 ? advise_rod_command(*o) : advise_command(*o);
  });
}

}  // namespace veriflex
