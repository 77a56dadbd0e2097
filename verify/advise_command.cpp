#include "advise_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>

#include "base/error.hpp"
#include "base/say.hpp"
#include "engine/result.hpp"
#include "engine/symbols.hpp"
#include "exit_code.hpp"
#include "run_cases.hpp"
#include "studies/advise.hpp"
#include "studies/grid.hpp"

namespace veriflex {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct AdviseOptions {
  std::string study;
  std::string out = "results";
  double error = 0.0;
  double budget = 0.0;
  bool json = false;
};

fs::path result_of(const AdviseOptions& o) {
  const fs::path given = o.study;
  std::error_code unknown;
  if (given.extension() == ".h5" || fs::is_regular_file(given, unknown)) return given;
  const fs::path stored = fs::path(o.out) / (o.study + ".h5");
  if (fs::is_regular_file(stored, unknown)) return stored;
  throw InputError(
      {stored.string()}, "there is no result", "advice is taken from a sweep that was run",
      fmt::format("Run veriflex run {} --out {} first, or give its result file", o.study, o.out));
}

studies::SweptRows rows_of(const io::Hdf5File& file, const std::string& path) {
  try {
    const observe::Record front = engine::read_record(file, "sweep_front");
    const std::string error = front.columns.at(front.columns.size() - 2).name;
    return studies::swept_rows(engine::read_record(file, "sweep"), engine::read_record(file, "sweep_cost"),
                               error);
  } catch (const InputError&) {
    throw InputError({path}, "this is no sweep with an error", "advice needs to know what the rows' error is",
                     "Give the sweep error = \"<metric>\", or veriflex sweep --error, and run it again");
  }
}

// Axes of the case's own sweep that stand for several keys at once, in words; what one of them alone is set
// to is no setting.
std::vector<std::string> joint_axes(const io::Hdf5File& file) {
  const io::Table top = engine::parse_case(file.texts("/case").front(), "the stored case");
  std::vector<std::string> joint;
  if (!top.has("sweep") || !file.attribute("/", "variant").empty()) return joint;
  for (const studies::Axis& axis : studies::read_axes(top.table("sweep"))) {
    if (axis.keys.size() > 1)
      joint.push_back(fmt::format("{} stands for {} together", axis.name(), fmt::join(axis.keys, ", ")));
  }
  return joint;
}

int advise_command(const AdviseOptions& o) {
  if (!(o.error > 0.0))
    throw InputError({}, fmt::format("--error is {}", o.error), "it must be positive", "Use 1e-3");
  const fs::path path = result_of(o);
  const io::Hdf5File file(path);
  const studies::SweptRows rows = rows_of(file, path.string());
  const studies::Advice found = studies::advise(
      rows, {.error = o.error, .budget = o.budget > 0.0 ? std::optional(o.budget) : std::nullopt});
  const std::string machine = file.attribute("/provenance", "machine");
  const std::string id = file.attribute("/", "case_id");
  if (o.json) {
    print_json(Json{
        {"case", id},
        {"error_wanted", o.error},
        {"setting", found.setting},
        {"predicted", {{"error", found.error}, {"seconds", found.seconds}, {"memory_bytes", found.memory}}},
        {"within_the_sweep", found.is_within},
        {"measured", found.is_measured},
        {"limited_by", found.limited_by},
        {"rows", found.rows},
        {"left_out_rows_within", {{"error", found.error_factor}, {"seconds", found.time_factor}}},
        {"study", path.string()},
        {"machine", machine}});
    return exit_code::success;
  }
  say("{}: the cheapest setting for an error of {:.3g}\n", id, o.error);
  for (const std::string& one : found.setting) say("    {}\n", one);
  say("  {}: error {:.3g}, run time {:.3g} s, memory {:.3g} MB, on {}\n",
      found.is_measured ? "measured" : "predicted", found.error, found.seconds, found.memory / 1e6, machine);
  say("  limited by: {}\n", found.limited_by);
  say("  from {} rows of {}; each predicted from the others is within a factor of {:.3g} (error), {:.3g} "
      "(time)\n",
      found.rows, path.string(), found.error_factor, found.time_factor);
  if (found.is_measured) say("  The fit is worth too little to go between rows: this is one that was run.\n");
  if (!found.is_within) say("  This lies beyond the sweep, by a factor of two at most: extrapolated.\n");
  const std::vector<std::string> joint = joint_axes(file);
  for (const std::string& one : joint) say("  {}, as in [sweep] of the case\n", one);
  if (!joint.empty()) return exit_code::success;
  say("  Try it: veriflex sweep {} --timed", id);
  for (const std::string& one : found.setting) say(" --over {}", one);
  say("\n");
  return exit_code::success;
}

}  // namespace

void add_advise_command(CLI::App& app, int& exit_code) {
  const auto o = std::make_shared<AdviseOptions>();
  CLI::App* advise = app.add_subcommand(
      "advise", "the cheapest setting for an error, from a sweep that says what its error costs");
  advise->add_option("study", o->study, "id of a case whose result is in --out, or a result file")
      ->required();
  advise->add_option("--error", o->error, "the error that is to be reached")->required();
  advise->add_option("--budget", o->budget, "the most run time [s]");
  advise->add_option("--out", o->out, "folder of results")->capture_default_str();
  advise->add_flag("--json", o->json, "print JSON");
  advise->footer(
      "Example: veriflex run cost-oscillation-pair; veriflex advise cost-oscillation-pair --error 1e-4");
  advise->callback([o, &exit_code] { exit_code = advise_command(*o); });
}

}  // namespace veriflex
