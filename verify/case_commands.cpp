#include "case_commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <omp.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/say.hpp"
#include "base/stop.hpp"
#include "claims_command.hpp"
#include "engine/baseline.hpp"
#include "engine/result.hpp"
#include "exit_code.hpp"
#include "measures/drivers.hpp"
#include "repository.hpp"
#include "threads.hpp"

namespace veriflex {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;
using engine::Case;
using engine::CaseHead;
using engine::Result;
using engine::Verdict;

// Bytes that are no UTF-8, as file names may hold, are replaced.
void print_json(const Json& json) { say("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace)); }

struct Options {
  std::vector<std::string> cases;
  std::vector<std::string> overrides;
  std::string case_folder = repository::cases().string();
  std::string tier;
  std::string topic;
  std::string out = "results";
  std::string report;
  int threads = 0;
  bool json = false;
};

Case read(const fs::path& path, const Options& options) {
  Case c = engine::read_case(path, options.overrides, measures::all(), repository::references());
  engine::compare_with_baseline(c, repository::cases(), repository::references());
  return c;
}

std::vector<CaseHead> chosen(const Options& options) {
  std::vector<CaseHead> heads = engine::find_cases(options.case_folder);
  std::erase_if(heads, [&](const CaseHead& head) {
    const bool of_tier = options.tier.empty() || head.tier == options.tier || !head.problem.empty();
    const bool of_topic = options.topic.empty() || std::find(head.topics.begin(), head.topics.end(),
                                                             options.topic) != head.topics.end();
    return !of_tier || !of_topic;
  });
  return heads;
}

void list_command(const Options& options) {
  const std::vector<CaseHead> heads = chosen(options);
  if (options.json) {
    Json all = Json::array();
    for (const CaseHead& head : heads) {
      Json one{{"id", head.id},         {"title", head.title},   {"tier", head.tier},
               {"topics", head.topics}, {"driver", head.driver}, {"path", fs::absolute(head.path).string()}};
      if (!head.problem.empty()) one["problem"] = head.problem;
      all.push_back(one);
    }
    print_json(all);
    return;
  }
  for (const CaseHead& head : heads) {
    if (!head.problem.empty()) {
      say("{:<32} unreadable: {}\n", head.id, head.problem);
    } else {
      say("{:<32} {:<6} {:<8} {:<28} {}\n", head.id, head.tier, head.driver,
          fmt::format("{}", fmt::join(head.topics, ", ")), head.title);
    }
  }
}

void plan_command(const Options& options) {
  Json all = Json::array();
  for (const std::string& name : options.cases) {
    const Case c = read(engine::case_named(name, options.case_folder), options);
    Json built = Json::array();
    Json left_out = Json::array();
    if (!options.json) say("{}: {}\n", c.id, c.title);
    for (const scene::Built& b : c.study.plan.built) {
      built.push_back({{"module", b.module}, {"what", b.what}, {"memory_bytes", b.memory_bytes}});
      if (!options.json) say("  built     {:<12} {} ({:.3g} MB)\n", b.module, b.what, 1e-6 * b.memory_bytes);
    }
    for (const scene::LeftOut& l : c.study.plan.left_out) {
      left_out.push_back({{"module", l.module}, {"why", l.why}});
      if (!options.json) say("  left out  {:<12} {}\n", l.module, l.why);
    }
    all.push_back({{"id", c.id}, {"built", built}, {"left_out", left_out}, {"measures", c.study.measures}});
  }
  if (options.json) print_json(all);
}

Json result_json(const Result& r, const std::string& stored) {
  Json checks = Json::array();
  for (std::size_t i = 0; i < r.outcomes.size(); ++i) {
    const engine::Outcome& o = r.outcomes[i];
    const engine::Check& check = r.c.checks[i];
    checks.push_back({{"metric", o.measure},
                      {"kind", to_string(check.kind)},
                      {"statement", check.statement},
                      {"measured", o.measured},
                      {"target", o.target},
                      {"holds", o.outside ? "outside" : "within"},
                      {"tolerance", o.tolerance},
                      {"margin", o.margin},
                      {"verdict", to_string(o.verdict)}});
  }
  Json metrics = Json::array();
  for (const observe::Metric& m : r.seen.metrics) {
    metrics.push_back(
        {{"name", m.name}, {"value", m.value}, {"dimension", m.dimension}, {"meaning", m.meaning}});
  }
  Json json{{"id", r.c.name()},           {"case_id", r.c.id},
            {"overrides", r.c.overrides}, {"verdict", to_string(r.verdict)},
            {"findings", r.findings()},   {"wall_seconds", r.cost.wall_seconds()},
            {"checks", checks},           {"metrics", metrics},
            {"warnings", r.warnings},     {"result", stored.empty() ? Json(nullptr) : Json(stored)}};
  if (r.verdict == Verdict::error) json["error"] = {{"kind", r.error_kind}, {"message", r.error_message}};
  return json;
}

void print_table(const Result& r) {
  std::size_t width = 6;
  for (const engine::Outcome& o : r.outcomes) width = std::max(width, o.measure.size());
  for (const observe::Metric& m : r.seen.metrics) {
    if (r.outcomes.empty()) width = std::max(width, m.name.size());
  }
  if (!r.outcomes.empty()) {
    say("        {:<{}}  {:>24}  {:>24}  {:>9}  {}\n", "metric", width, "measured", "target", "margin",
        "verdict");
  }
  for (std::size_t i = 0; i < r.outcomes.size(); ++i) {
    const engine::Outcome& o = r.outcomes[i];
    const std::string target = o.outside ? fmt::format("beyond {:.10g} +- {:.3g}", o.target, o.tolerance)
                                         : fmt::format("{:.17g}", o.target);
    say("        {:<{}}  {:>24.17g}  {:>24}  {:>9.2g}  {}\n", o.measure, width, o.measured, target, o.margin,
        to_string(o.verdict));
  }
  if (!r.outcomes.empty()) return;
  for (const observe::Metric& m : r.seen.metrics) {
    say("        {:<{}}  {:>24.17g}  [{}] {}\n", m.name, width, m.value, m.dimension, m.meaning);
  }
}

// What the measured number had to be.
std::string wanted(const engine::Outcome& o) {
  if (o.outside) return fmt::format("must lie beyond {:.17g} +- {:.3g}", o.target, o.tolerance);
  return fmt::format("target {:.17g}, tolerance {:.3g}", o.target, o.tolerance);
}

// The verdict in one line, what is wrong or found, and for `run` the numbers.
void print_result(const Result& r, const std::string& stored, bool with_table) {
  say("{:<8} {:<32} {:>2} checks, worst margin {:<9.3g} {:.2f} s\n", to_string(r.verdict), r.c.name(),
      r.outcomes.size(), r.worst_margin(), r.cost.wall_seconds());
  if (!r.c.overrides.empty()) {
    say("        changed: {} --set {}\n", r.c.id, fmt::join(r.c.overrides, " --set "));
  }
  if (with_table) print_table(r);
  for (std::size_t i = 0; i < r.outcomes.size(); ++i) {
    const engine::Outcome& o = r.outcomes[i];
    const engine::Check& check = r.c.checks[i];
    if (o.verdict == Verdict::fail) {
      say("        {}: {}: {} measured {:.17g}, {}, margin {:.3g}. {}\n", to_string(check.place),
          to_string(o.verdict), o.measure, o.measured, wanted(o), o.margin, check.statement);
    } else if (o.verdict == Verdict::finding) {
      say("        finding: {} (measured {:.10g}, {})\n", check.statement, o.measured, wanted(o));
    }
  }
  if (r.verdict == Verdict::error) say("        {}\n", r.error_message);
  if (with_table && !stored.empty()) say("        result {}\n", stored);
}

int exit_code_of(const Result& r) {
  if (r.verdict == Verdict::fail) return exit_code::check_failed;
  return r.verdict == Verdict::error ? exit_code::of_error(r.error_kind) : exit_code::success;
}

// One case of a command.
struct Asked {
  std::string name;  // as it was given
  fs::path path;     // empty: there is no such case
  std::string problem;
};

// Finds the cases. Throws InputError when two of them would write the same result.
std::vector<Asked> asked_for(const std::vector<std::string>& names, const Options& options) {
  std::vector<Asked> all;
  std::map<std::string, std::string> by_id;
  for (const std::string& name : names) {
    Asked& asked = all.emplace_back(Asked{name, {}, {}});
    try {
      asked.path = engine::case_named(name, options.case_folder);
    } catch (const InputError& error) {
      asked.problem = error.what();
      continue;
    }
    const auto [earlier, first] = by_id.emplace(asked.path.stem().string(), name);
    if (!first) {
      throw InputError(
          {},
          fmt::format("case '{}' stands here twice: as {} and as {}", earlier->first, earlier->second, name),
          "they would write the same result", "Give each id once, or run them with two --out");
    }
  }
  return all;
}

// Runs and stores the cases of one command.
class Runs {
 public:
  explicit Runs(const Options& options) : options_(options), threads_(usable_threads(options.threads)) {
    omp_set_num_threads(threads_);
  }

  // What becomes of a case is stored in any case, before anything is said about it: while it runs, its place
  // is held by a result that says so, so that no earlier verdict outlives a run that is killed.
  Result run(const Asked& asked) {
    stored_.clear();
    if (asked.path.empty()) return not_run(asked, {"input", asked.problem});
    if (stop::signal != 0) {
      Result result = not_run(asked, {"interrupted", fmt::format("not run: {}", stop::reason())});
      store(result);
      return result;
    }
    std::error_code unknown;
    const bool is_file = fs::is_regular_file(asked.path, unknown);
    Result result = not_run(
        asked,
        {"interrupted", fmt::format("its run began at {} and has not come to its end: it was killed, or is "
                                    "running still",
                                    engine::provenance(1).date)});
    std::optional<Case> c;
    try {
      c = read(asked.path, options_);
      if (!store(result)) return result;
    } catch (...) {
      result.fail(engine::current_failure());
      if (is_file) store(result);
      return result;
    }
    result = engine::run_case(*c, threads_);
    store(result);
    return result;
  }

  // Of the last case; empty if it could not be stored.
  const std::string& stored() const { return stored_; }

 private:
  Result not_run(const Asked& asked, const engine::Failure& failure) const {
    return engine::not_run(asked.path.empty() ? fs::path(asked.name) : asked.path, options_.overrides,
                           failure, threads_);
  }

  // Whether the result could be written; if not it becomes the error that says why.
  bool store(Result& result) {
    for (const bool whole : {true, false}) {
      try {
        engine::write_result(result, options_.out);
        stored_ = engine::result_path(result.c, options_.out).string();
        return whole;
      } catch (...) {
        // What a file cannot hold, or memory for it was lacking: then the reason alone.
        engine::Failure why = engine::current_failure();
        if (why.kind != "output") why.message = "the result could not be stored: " + why.message;
        result = engine::not_run(result.c.path, result.c.overrides, why, threads_);
        if (why.kind == "output") break;
      }
    }
    stored_.clear();
    return false;
  }

  const Options& options_;
  int threads_;
  std::string stored_;
};

int run_all(const std::vector<std::string>& names, const Options& options, bool with_tables) {
  const std::vector<Asked> cases = asked_for(names, options);
  int code = exit_code::success;
  Json all = Json::array();
  Runs runs(options);
  const stop::Handlers handlers;
  for (const Asked& asked : cases) {
    const Result result = runs.run(asked);
    code = exit_code::first_of(code, exit_code_of(result));
    if (result.verdict == Verdict::error) {
      const bool has_place = result.error_kind == "input" || result.error_kind == "output";
      complain("{}{}", has_place ? "" : result.c.path.string() + ": ", result.error_message);
    }
    if (options.json) {
      all.push_back(result_json(result, runs.stored()));
    } else {
      print_result(result, runs.stored(), with_tables);
      std::fflush(stdout);
    }
  }
  if (options.json) print_json(all);
  return code;
}

// A file in memory, which a child process reads as /dev/fd/<number>.
class FileInMemory {
 public:
  explicit FileInMemory(const std::string& text) : file_(memfd_create("ledger", 0)) {
    std::size_t done = 0;
    while (file_ >= 0 && done < text.size()) {
      const ssize_t wrote = write(file_, text.data() + done, text.size() - done);
      if (wrote <= 0) break;
      done += static_cast<std::size_t>(wrote);
    }
    if (file_ < 0 || done < text.size()) {
      throw OutputError("memory", "the ledger cannot be handed to the report", "Free some memory");
    }
    lseek(file_, 0, SEEK_SET);
  }
  ~FileInMemory() { close(file_); }
  FileInMemory(const FileInMemory&) = delete;
  FileInMemory& operator=(const FileInMemory&) = delete;
  std::string path() const { return fmt::format("/dev/fd/{}", file_); }

 private:
  int file_;
};

// The report is drawn by a script from the result files and the ledger; it inherits standard output.
int report_command(const std::string& results, const std::string& report) {
  int code = exit_code::success;
  std::vector<std::string> words{VERIFLEX_SOURCE_DIR "/scripts/report.py", results};
  std::optional<FileInMemory> ledger;
  std::error_code unknown;
  try {
    // The script names files and folders that cannot be read.
    if (fs::is_directory(results, unknown)) ledger.emplace(claims_json({results}));
    if (ledger) words.insert(words.end(), {"--claims", ledger->path()});
  } catch (const std::exception&) {
    // The results are worth a page even when the ledger cannot be read.
    const engine::Failure why = engine::current_failure();
    complain("{}. The report goes without the ledger of claims", why.message);
    code = exit_code::of_error(why.kind);
  }
  if (!report.empty()) words.insert(words.end(), {"--out", report});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::fflush(stdout);
  pid_t child = 0;
  const int failed = posix_spawn(&child, words[0].c_str(), nullptr, nullptr, arguments.data(), environ);
  if (failed != 0) {
    throw OutputError(words[0], fmt::format("cannot be run ({})", std::strerror(failed)),
                      "It needs Debian's python3; scripts/install-deps installs all that is needed");
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  if (!WIFEXITED(status))
    throw OutputError(words[0], "was killed before the report was complete", "Run it again");
  // A script that breaks off (a missing Python module) exits with 1, which here would mean a failed check.
  const int drawn = WEXITSTATUS(status);
  return exit_code::first_of(code, drawn == exit_code::check_failed ? exit_code::output : drawn);
}

int verify_command(const Options& options) {
  std::vector<std::string> names;
  for (const CaseHead& head : chosen(options)) names.push_back(head.path.string());
  if (names.empty()) {
    throw InputError({options.case_folder}, fmt::format("holds no case of tier '{}'", options.tier),
                     "nothing to verify", "See veriflex list");
  }
  const int code = run_all(names, options, false);
  if (options.json) return code;  // standard output is the JSON document
  if (stop::signal != 0) {
    complain("{}: no report is drawn", stop::reason());
    return exit_code::first_of(code, exit_code::numerical);
  }
  return exit_code::first_of(code, report_command(options.out, options.report));
}

void add_run_options(CLI::App& command, Options& options) {
  command.add_option("--threads", options.threads, "threads for the loops of a case (default: all cores)")
      ->check(CLI::Range(1, 4096));
  command.add_option("--out", options.out, "folder for the result files")->capture_default_str();
  command.add_flag("--json", options.json,
                   "print a JSON array: per case id, overrides, verdict, findings, wall_seconds, checks "
                   "(metric, measured, "
                   "target, holds, tolerance, margin, verdict), metrics, warnings, result (the file)");
}

void add_case_names(CLI::App& command, Options& options) {
  command.add_option("case", options.cases, "paths of case files, or ids")->required();
  command.add_option("--set", options.overrides, "replace a value of the case, key=value; may be repeated")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
}

void add_case_folder(CLI::App& command, Options& options) {
  command.add_option("--cases", options.case_folder, "folder of case files")->capture_default_str();
}

}  // namespace

void add_case_commands(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<Options>();

  CLI::App* list = app.add_subcommand("list", "the cases there are");
  list->add_option("--tier", options->tier, "only this tier")->check(CLI::IsMember(engine::tiers()));
  list->add_option("--topic", options->topic, "only cases with this topic");
  list->add_flag("--json", options->json, "print a JSON array");
  add_case_folder(*list, *options);
  list->footer("Example: veriflex list --topic tensile");
  list->callback([options] { list_command(*options); });

  CLI::App* plan = app.add_subcommand("plan", "what a case will build and leave out, without running it");
  add_case_names(*plan, *options);
  plan->add_flag("--json", options->json, "print a JSON array");
  add_case_folder(*plan, *options);
  plan->footer("Example: veriflex plan tensile-fene-lj --set 'solid.nodes=[8, 8, 40]'");
  plan->callback([options] { plan_command(*options); });

  CLI::App* run = app.add_subcommand("run", "run cases, judge them and write a result file each");
  add_case_names(*run, *options);
  add_run_options(*run, *options);
  add_case_folder(*run, *options);
  run->footer("Example: veriflex run path/to/mine.toml --set bond.epsilon=2.0 --out results");
  run->callback([options, &exit_code] { exit_code = run_all(options->cases, *options, true); });

  CLI::App* verify = app.add_subcommand("verify", "run every case of a tier and write the report");
  verify->add_option("--tier", options->tier, "quick, full or paper")
      ->default_val("quick")
      ->check(CLI::IsMember(engine::tiers()));
  add_run_options(*verify, *options);
  add_case_folder(*verify, *options);
  verify->footer("Example: veriflex verify --tier quick --out results");
  verify->callback([options, &exit_code] { exit_code = verify_command(*options); });

  CLI::App* report =
      app.add_subcommand("report", "draw the report from result files and print the table of verdicts");
  report->add_option("results", options->out, "folder of result files")->capture_default_str();
  report->add_option("--out", options->report,
                     "the HTML file to write (default: report.html among the results)");
  report->footer("Example: veriflex report results --out report.html");
  report->callback([options, &exit_code] { exit_code = report_command(options->out, options->report); });
}

}  // namespace veriflex
