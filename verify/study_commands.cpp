#include "study_commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/prctl.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.hpp"
#include "base/say.hpp"
#include "exit_code.hpp"
#include "io/document.hpp"
#include "io/file.hpp"
#include "run_cases.hpp"
#include "studies/studies.hpp"

namespace veriflex {

namespace fs = std::filesystem;

namespace {

struct StudyOptions : Options {
  std::vector<std::string> over, without, with, from;
  std::string along, criterion, error, work, shard_text;
  int points = 5;
  double accuracy = 0.01;
  bool logarithmic = false, whole_numbers = false, timed = false, against_finest = false, left_out = false,
       offered = false;
};

[[noreturn]] void refuse(const std::string& given, const std::string& why, const std::string& suggestion) {
  throw InputError({}, fmt::format("'{}' cannot be used", given), why, suggestion);
}

// What stands between commas that are in no bracket and no quotes.
std::vector<std::string> between_commas(const std::string& text) {
  std::vector<std::string> parts{""};
  int depth = 0;
  char quote = 0;
  for (const char c : text) {
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '[' || c == '{') {
      ++depth;
    } else if (c == ']' || c == '}') {
      --depth;
    }
    if (c == ',' && depth == 0 && quote == 0) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

// A TOML value as it stands, or a bare word as text.
std::string value_text(const std::string& word) {
  try {
    io::parse_document("value = " + word, "");
    return word;
  } catch (const InputError&) {
    return io::toml_text(word);
  }
}

// `key=value` in two.
std::pair<std::string, std::string> halves(const std::string& option, const std::string& given) {
  const std::size_t equals = given.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == given.size()) {
    refuse(given, "it is not of the form key=...", fmt::format("Write for example {}", option));
  }
  return {given.substr(0, equals), given.substr(equals + 1)};
}

// `axes` of a study's table, from `key=value,value,...`.
std::string axes_text(const std::vector<std::string>& over) {
  std::vector<std::string> axes;
  for (const std::string& given : over) {
    const auto [key, values] = halves("--over fluid.relaxation_time=0.6,0.8,1", given);
    std::vector<std::string> texts;
    for (const std::string& word : between_commas(values)) texts.push_back(value_text(word));
    axes.push_back(fmt::format("{{key = {}, values = [{}]}}", io::toml_text(key), fmt::join(texts, ", ")));
  }
  return fmt::format("axes = [{}]", fmt::join(axes, ", "));
}

std::string timing_text(const StudyOptions& o) {
  const std::string repeats = o.repeats > 0 ? fmt::format(", repeats = {}", o.repeats) : "";
  return fmt::format("timed = {}{}", o.timed, repeats);
}

std::string sweep_text(const StudyOptions& o) {
  std::string text = fmt::format("{}, {}", axes_text(o.over), timing_text(o));
  if (!o.error.empty()) text += ", error = " + io::toml_text(o.error);
  if (o.against_finest) text += ", reference = \"finest\"";
  if (!o.work.empty()) text += ", work = " + io::toml_text(o.work);
  return text;
}

std::string boundary_text(const StudyOptions& o) {
  const auto [key, range] = halves("--along fluid.relaxation_time=0.5001..1", o.along);
  const std::size_t dots = range.find("..");
  if (dots == std::string::npos) refuse(o.along, "it has no range", "Write for example --along key=0.1..2");
  std::string text = fmt::format(
      "key = {}, from = {}, to = {}, points = {}, accuracy = {}, scale = {}, whole_numbers = {}, {}",
      io::toml_text(key), range.substr(0, dots), range.substr(dots + 2), o.points, o.accuracy,
      io::toml_text(std::string(o.logarithmic ? "logarithmic" : "linear")), o.whole_numbers, timing_text(o));
  if (!o.over.empty()) text += ", " + axes_text(o.over);
  if (o.criterion.empty()) return text;
  const std::size_t at = o.criterion.find("<=");
  if (at == std::string::npos || at == 0) {
    refuse(o.criterion, "it is not of the form metric<=number",
           "Write for example --criterion 'error<=0.01'");
  }
  return text + fmt::format(", criterion = {{metric = {}, at_most = {}}}",
                            io::toml_text(o.criterion.substr(0, at)), o.criterion.substr(at + 2));
}

std::string ablate_text(const StudyOptions& o) {
  std::vector<std::string> variants;
  for (const std::string& key : o.without) {
    variants.push_back(
        fmt::format("{{name = {}, without = [{}]}}", io::toml_text("without " + key), io::toml_text(key)));
  }
  for (const std::string& given : o.with) {
    const auto [key, value] = halves("--with coupling.delta=3-point", given);
    variants.push_back(fmt::format("{{name = {}, set = {{{} = {}}}}}", io::toml_text("with " + given),
                                   io::toml_text(key), value_text(value)));
  }
  return fmt::format("left_out = {}, offered = {}, variants = [{}], {}", o.left_out, o.offered,
                     fmt::join(variants, ", "), timing_text(o));
}

void read_shard(StudyOptions& o) {
  if (o.shard_text.empty()) return;
  const std::size_t slash = o.shard_text.find('/');
  const io::Table parts =
      io::parse_document(fmt::format("shard = {}\nof = {}", o.shard_text.substr(0, slash),
                                     slash == std::string::npos ? "none" : o.shard_text.substr(slash + 1)),
                         "--shard " + o.shard_text);
  o.shards = static_cast<int>(parts.integer("of", 1, 100'000));
  o.shard = static_cast<int>(parts.integer("shard", 1, o.shards)) - 1;
}

// The study in place of any that the case has. Its checks ask for numbers of what stands in the file.
int run_study(StudyOptions& o, const std::string& table, const std::string& text) {
  read_shard(o);
  const fs::path path = engine::case_named(o.cases.front(), o.case_folder);
  const io::Table file = io::parse_document(io::read_file(path), path.string());
  for (const std::string& other : studies::tables()) {
    if (other != table && file.has(other)) o.overrides.push_back(other + "=");
  }
  o.overrides.push_back(fmt::format("{}={{{}}}", table, text));
  o.with_checks = false;
  return run_cases(o.cases, o, true);
}

// Copies rows that other machines made, and makes the study whole.
int merge_command(StudyOptions& o) {
  std::size_t rows = 0;
  for (const std::string& from : o.from) {
    std::error_code unknown;
    if (!fs::is_directory(from, unknown)) {
      throw InputError({from}, "no folder of results", "rows are looked for there",
                       "Give what a shard wrote with --out");
    }
    for (const fs::directory_entry& folder : fs::directory_iterator(from)) {
      const std::string name = folder.path().filename().string();
      if (!folder.is_directory() || !name.ends_with("rows")) continue;
      for (const fs::directory_entry& row : fs::recursive_directory_iterator(folder.path())) {
        const fs::path to = fs::path(o.out) / fs::relative(row.path(), from);
        if (row.path().extension() != ".h5" || fs::equivalent(row.path(), to, unknown)) continue;
        fs::create_directories(to.parent_path());
        io::write_file(to, io::read_file(row.path()));
        ++rows;
      }
    }
  }
  if (o.json) {
    say("{}\n", nlohmann::ordered_json{{"rows", rows}, {"out", o.out}}.dump(2));
  } else {
    say("{} row{} gathered in {}\n", rows, rows == 1 ? "" : "s", o.out);
  }
  return exit_code::success;
}

void add_common_options(CLI::App& command, StudyOptions& o) {
  command.add_option("case", o.cases, "path of a case file, or id")->required()->expected(1);
  command
      .add_option("--set", o.overrides, "replace a value of the case in all rows, key=value; may be repeated")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command.add_flag("--timed", o.timed,
                   "one row after another with all threads, so that their times can be compared");
  command.add_option("--repeats", o.repeats, "with --timed: further runs of each row, for its time")
      ->check(CLI::Range(0, 1000));
  command.add_flag("--fresh", o.fresh, "run rows again that are kept from an earlier run");
  command.add_option(
      "--shard", o.shard_text,
      "i/n: run every n-th part only, from the i-th on, and keep its rows; see veriflex merge");
  command.add_option("--threads", o.threads, "rows at once, or threads of a timed row (default: all cores)")
      ->check(CLI::Range(1, 4096));
  command.add_option("--out", o.out, "folder for the result file and the rows")->capture_default_str();
  command.add_option("--cases", o.case_folder, "folder of case files")->capture_default_str();
  command.add_flag("--json", o.json, "print a JSON array like veriflex run");
}

void add_axes(CLI::App& command, StudyOptions& o) {
  command.add_option("--over", o.over, "an axis: key=value,value,...; may be repeated; from coarse to fine")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
}

}  // namespace

void add_study_commands(CLI::App& app, int& exit_code) {
  const auto o = std::make_shared<StudyOptions>();

  CLI::App* sweep =
      app.add_subcommand("sweep", "a case over a grid of its keys: error and cost of each run, orders");
  add_common_options(*sweep, *o);
  add_axes(*sweep, *o);
  sweep->get_option("--over")->required();
  sweep->add_option("--error", o->error, "the metric that is an error: which settings are worth their work");
  sweep->add_flag("--against-finest", o->against_finest,
                  "with --error: the metric is no error, but its distance from the last row is");
  sweep->add_option("--work", o->work, "with --error: what counts as work (default: bytes_moved)");
  sweep->footer(
      "Example: veriflex sweep tensile-fene-lj --over 'solid.nodes=[3, 3, 6],[3, 3, 12],[3, 3, 24]'");
  sweep->callback([o, &exit_code] { exit_code = run_study(*o, "sweep", sweep_text(*o)); });

  CLI::App* boundary =
      app.add_subcommand("boundary", "where the outcome of a case changes along one of its keys");
  add_common_options(*boundary, *o);
  add_axes(*boundary, *o);
  boundary->add_option("--along", o->along, "key=from..to")->required();
  boundary->add_option("--points", o->points, "places looked at before the bisection, both ends included")
      ->check(CLI::Range(2, 10000))
      ->capture_default_str();
  boundary->add_option("--accuracy", o->accuracy, "of the key, relative")->capture_default_str();
  boundary->add_option("--criterion", o->criterion,
                       "metric<=number: what counts as good beside coming to an end");
  boundary->add_flag("--logarithmic", o->logarithmic, "divide the range by factors");
  boundary->add_flag("--whole-numbers", o->whole_numbers, "the key takes whole numbers only");
  boundary->footer("Example: veriflex boundary my-scene.toml --along 'body.0.node_mass=0.2..2'");
  boundary->callback([o, &exit_code] { exit_code = run_study(*o, "boundary", boundary_text(*o)); });

  CLI::App* ablate = app.add_subcommand(
      "ablate", "a case beside itself with parts left out and others put in: what each does and costs");
  add_common_options(*ablate, *o);
  ablate->add_option("--without", o->without, "a key or table to remove; may be repeated, each is a row")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  ablate->add_option("--with", o->with, "key=value to put in; may be repeated, each is a row")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  ablate->add_flag("--left-out", o->left_out,
                   "a row for each part that the plan leaves out and that can be built all the same");
  ablate->add_flag("--offered", o->offered, "a row for each saving that `veriflex plan` offers");
  ablate->footer("Example: veriflex ablate tensile-fene-lj --without angle --with solid.lateral=free");
  ablate->callback([o, &exit_code] { exit_code = run_study(*o, "ablate", ablate_text(*o)); });

  CLI::App* merge =
      app.add_subcommand("merge", "gather the rows of shards; the study run again then finds them all");
  merge->add_option("from", o->from, "folders that shards wrote to with --out")->required();
  merge->add_option("--out", o->out, "folder to gather them in")->capture_default_str();
  merge->add_flag("--json", o->json, "print how many rows were gathered, and where, as JSON");
  merge->footer("Example: veriflex merge node-1 node-2 --out results");
  merge->callback([o, &exit_code] { exit_code = merge_command(*o); });

  CLI::App* row = app.add_subcommand("row", "one row of a study");
  row->group("");  // not shown: studies call it
  add_common_options(*row, *o);
  row->callback([o, &exit_code] {
    prctl(PR_SET_PDEATHSIG, SIGTERM);  // a row does not outlive its study
    o->is_row = true;
    exit_code = run_cases(o->cases, *o, false);
  });
}

}  // namespace veriflex
