#include "case_commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <omp.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "claims_command.hpp"
#include "drivers/drivers.hpp"
#include "engine/result.hpp"
#include "exit_code.hpp"
#include "repository.hpp"

namespace veriflex {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;
using engine::Case;
using engine::CaseHead;
using engine::Result;
using engine::Verdict;

// Bytes that are no UTF-8, as file names may hold, are replaced.
void print_json(const Json& json) {
  fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
}

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
  return engine::read_case(path, options.overrides, drivers::all(), repository::references());
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
      fmt::print("{:<32} unreadable: {}\n", head.id, head.problem);
    } else {
      fmt::print("{:<32} {:<6} {:<8} {:<28} {}\n", head.id, head.tier, head.driver,
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
    if (!options.json) fmt::print("{}: {}\n", c.id, c.title);
    for (const scene::Built& b : c.study.plan.built) {
      built.push_back({{"module", b.module}, {"what", b.what}, {"memory_bytes", b.memory_bytes}});
      if (!options.json)
        fmt::print("  built     {:<12} {} ({:.3g} MB)\n", b.module, b.what, 1e-6 * b.memory_bytes);
    }
    for (const scene::LeftOut& l : c.study.plan.left_out) {
      left_out.push_back({{"module", l.module}, {"why", l.why}});
      if (!options.json) fmt::print("  left out  {:<12} {}\n", l.module, l.why);
    }
    all.push_back({{"id", c.id}, {"built", built}, {"left_out", left_out}, {"measures", c.study.measures}});
  }
  if (options.json) print_json(all);
}

Json result_json(const Result& r) {
  Json checks = Json::array();
  for (const engine::Outcome& o : r.outcomes) {
    checks.push_back({{"metric", o.measure},
                      {"measured", o.measured},
                      {"target", o.target},
                      {"tolerance", o.tolerance},
                      {"margin", o.margin},
                      {"verdict", to_string(o.verdict)}});
  }
  Json json{{"id", r.c.id},
            {"verdict", to_string(r.verdict)},
            {"findings", r.findings()},
            {"wall_seconds", r.cost.wall_seconds()},
            {"checks", checks}};
  if (r.verdict == Verdict::error) json["error"] = {{"kind", r.error_kind}, {"message", r.error_message}};
  return json;
}

void print_result(const Result& r) {
  fmt::print("{:<7} {:<32} {:>2} checks, worst margin {:<9.3g} {:.2f} s\n", to_string(r.verdict), r.c.id,
             r.outcomes.size(), r.worst_margin(), r.cost.wall_seconds());
  for (std::size_t i = 0; i < r.outcomes.size(); ++i) {
    const engine::Outcome& o = r.outcomes[i];
    const engine::Check& check = r.c.checks[i];
    if (o.verdict == Verdict::fail) {
      fmt::print("        {}: {}: {} measured {:.17g}, target {:.17g}, tolerance {:.3g}, margin {:.3g}. {}\n",
                 to_string(check.place), to_string(o.verdict), o.measure, o.measured, o.target, o.tolerance,
                 o.margin, check.statement);
    } else if (o.verdict == Verdict::finding) {
      fmt::print("        finding: {} (measured {:.10g}, claimed {:.10g})\n", check.statement, o.measured,
                 o.target);
    }
  }
}

int exit_code_of(const Result& r) {
  switch (r.verdict) {
    case Verdict::error:
      return exit_code::numerical;
    case Verdict::fail:
      return exit_code::check_failed;
    default:
      return exit_code::success;
  }
}

// Runs and stores one case. A case file that cannot be read is reported and, unless an earlier result stands
// there, stored as an error, so that a report made of the folder cannot overlook it.
Result run_one(const std::string& name, const Options& options, int& code) {
  const int threads = options.threads > 0 ? options.threads : omp_get_max_threads();
  omp_set_num_threads(threads);
  Result result{};
  fs::path path;
  try {
    path = engine::case_named(name, options.case_folder);
    result = engine::run_case(read(path, options), threads);
    if (result.verdict == Verdict::error) {
      fmt::print(stderr, "veriflex: {}: {}\n", path.string(), result.error_message);
    }
  } catch (const InputError& error) {
    code = exit_code::first_of(code, exit_code::input);
    fmt::print(stderr, "veriflex: {}\n", error.what());
    result = engine::unreadable(path.empty() ? fs::path(name) : path, error.what(), threads);
    if (path.empty() || fs::exists(fs::path(options.out) / (result.c.id + ".h5"))) return result;
  }
  engine::write_result(result, options.out);
  code = exit_code::first_of(code, result.error_kind == "input" ? exit_code::input : exit_code_of(result));
  return result;
}

int run_all(const std::vector<std::string>& names, const Options& options) {
  int code = exit_code::success;
  Json all = Json::array();
  for (const std::string& name : names) {
    const Result result = run_one(name, options, code);
    if (options.json) {
      all.push_back(result_json(result));
    } else {
      print_result(result);
      std::fflush(stdout);
    }
  }
  if (options.json) print_json(all);
  return code;
}

using TemporaryFile = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

// A file without a name, which a child process reads as /dev/fd/<number>.
TemporaryFile temporary_file(const std::string& text) {
  TemporaryFile file(std::tmpfile(), &std::fclose);
  if (!file || std::fwrite(text.data(), 1, text.size(), file.get()) != text.size() ||
      std::fflush(file.get()) != 0) {
    throw OutputError(fs::temp_directory_path().string(), "no temporary file can be written",
                      "Make room there");
  }
  std::rewind(file.get());
  return file;
}

// The report is drawn by a script from the result files and the ledger; it inherits standard output.
int report_command(const std::string& results, const std::string& report) {
  const TemporaryFile ledger = temporary_file(claims_json({results}));  // the script names unreadable files
  std::vector<std::string> words{VERIFLEX_SOURCE_DIR "/scripts/report.py", results, "--claims",
                                 fmt::format("/dev/fd/{}", fileno(ledger.get()))};
  if (!report.empty()) words.insert(words.end(), {"--out", report});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  const int failed = posix_spawn(&child, words[0].c_str(), nullptr, nullptr, arguments.data(), environ);
  if (failed != 0) {
    throw OutputError(words[0], fmt::format("cannot be run ({})", std::strerror(failed)),
                      "It needs Debian's python3; scripts/install-deps installs all that is needed");
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status))
    throw OutputError(words[0], "was killed before the report was complete", "Run it again");
  // A script that breaks off (a missing Python module) exits with 1, which here would mean a failed check.
  return WEXITSTATUS(status) == exit_code::check_failed ? exit_code::output : WEXITSTATUS(status);
}

int verify_command(const Options& options) {
  std::vector<std::string> names;
  for (const CaseHead& head : chosen(options)) names.push_back(head.path.string());
  if (names.empty()) {
    throw InputError({options.case_folder}, fmt::format("holds no case of tier '{}'", options.tier),
                     "nothing to verify", "See veriflex list");
  }
  const int code = run_all(names, options);
  if (options.json) return code;  // standard output is the JSON document
  return exit_code::first_of(code, report_command(options.out, options.report));
}

void add_run_options(CLI::App& command, Options& options) {
  command.add_option("--threads", options.threads, "threads for the loops of a case (default: all cores)")
      ->check(CLI::Range(1, 4096));
  command.add_option("--out", options.out, "folder for the result files")->capture_default_str();
  command.add_flag(
      "--json", options.json,
      "print a JSON array: per case id, verdict, findings, wall_seconds, checks (metric, measured, target, "
      "tolerance, margin, verdict)");
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
  run->footer("Example: veriflex run path/to/mine.toml --set bond.depth=2.0 --out results");
  run->callback([options, &exit_code] { exit_code = run_all(options->cases, *options); });

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
