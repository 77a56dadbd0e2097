#include "case_commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "base/say.hpp"
#include "base/stop.hpp"
#include "claims_command.hpp"
#include "engine/rates.hpp"
#include "engine/result.hpp"
#include "exit_code.hpp"
#include "io/hdf5.hpp"
#include "results_json.hpp"
#include "run_cases.hpp"
#include "threads.hpp"

namespace veriflex {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;
using engine::Case;
using engine::CaseHead;

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

// What one run of a case will take, where its work is known before.
std::optional<double> estimated_seconds(const Case& c, int threads) {
  if (!c.study.expects || c.study.of_many_runs) return std::nullopt;
  const std::optional<scene::ExpectedWork> work = c.study.expects();
  return work ? std::optional(engine::seconds_of(*work, engine::rates(threads))) : std::nullopt;
}

void plan_command(const Options& options) {
  const int threads = usable_threads(options.threads);
  Json all = Json::array();
  for (const std::string& name : options.cases) {
    const Case c = read_case(engine::case_named(name, options.case_folder), options);
    Json built = Json::array();
    Json left_out = Json::array();
    double memory = 0.0;
    if (!options.json) say("{}: {}\n", c.id, c.title);
    for (const scene::Built& b : c.study.plan.built) {
      built.push_back({{"module", b.module}, {"what", b.what}, {"memory_bytes", b.memory_bytes}});
      memory += b.memory_bytes;
      if (!options.json) say("  built     {:<12} {} ({:.3g} MB)\n", b.module, b.what, 1e-6 * b.memory_bytes);
    }
    for (const scene::LeftOut& l : c.study.plan.left_out) {
      left_out.push_back({{"module", l.module}, {"why", l.why}, {"put_in", l.put_in}});
      if (!options.json) say("  left out  {:<12} {}\n", l.module, l.why);
    }
    Json offered = Json::array();
    if (c.study.offers) {
      for (const scene::Offer& offer : c.study.offers()) {
        offered.push_back({{"what", offer.what}, {"saves", offer.saves}, {"setting", offer.setting}});
        if (!options.json)
          say("  offered   {:<12} saves {} (--set '{}')\n", offer.what, offer.saves, offer.setting);
      }
      if (!options.json && !offered.empty())
        say("  what the offers cost in accuracy: veriflex ablate {} --offered; which box is enough: veriflex "
            "sweep {} "
            "--over 'fluid.nodes.0=...' --error METRIC --against-finest\n",
            name, name);
    }
    Json takes = nullptr;
    if (const std::optional<double> seconds = estimated_seconds(c, threads)) {
      takes = *seconds;
      if (!options.json) {
        say("  takes     about {:.2g} s and {:.3g} MB, on this machine with {} thread{}\n", *seconds,
            1e-6 * memory, threads, threads == 1 ? "" : "s");
      }
    }
    Json measures = Json::array();
    for (const observe::Metric& m : engine::measured(c.study)) {
      measures.push_back({{"name", m.name}, {"dimension", m.dimension}, {"meaning", m.meaning}});
      if (options.json) continue;
      say("  measures  {}{}\n", m.name,
          m.meaning.empty() ? "" : fmt::format("  [{}] {}", m.dimension, m.meaning));
    }
    all.push_back({{"id", c.id},
                   {"built", built},
                   {"left_out", left_out},
                   {"offered", offered},
                   {"seconds", takes},
                   {"measures", measures}});
  }
  if (options.json) print_json(all);
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
  if (fs::is_directory(results, unknown)) {
    const fs::path beside = report.empty() ? fs::path(results) : fs::path(report).parent_path();
    code = exit_code::first_of(code, attempted([&] { write_results_json(results, beside); }));
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

// How long a case took when its result here was made; nothing where there is none.
std::optional<double> took(const std::string& path, const Options& options) {
  try {
    const io::Hdf5File file(fs::path(options.out) / (fs::path(path).stem().string() + ".h5"));
    if (file.attribute("/", "outcome") != "completed") return std::nullopt;
    const std::vector<double> phases = file.numbers("/timing/wall_seconds");
    return std::accumulate(phases.begin(), phases.end(), 0.0);
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

// Says what a tier will take: what its cases took last time, or as their plans estimate.
void announce(const std::vector<std::string>& names, const Options& options) {
  double seconds = 0.0;
  std::size_t unknown = 0;
  const int threads = usable_threads(options.threads);
  for (const std::string& name : names) {
    std::optional<double> one = took(name, options);
    if (!one) {
      try {
        one = estimated_seconds(read_without_baseline(name, options), threads);
      } catch (const std::exception&) {  // its own run will say what is wrong with it
      }
    }
    if (one) {
      seconds += *one;
    } else {
      ++unknown;
    }
  }
  const std::string others =
      unknown == 0 ? "" : fmt::format(", and {} more whose time nothing here tells", unknown);
  say("tier {}: {} cases take about {:.2g} s{}\n", options.tier, names.size() - unknown, seconds, others);
  std::fflush(stdout);
}

int verify_command(const Options& options) {
  std::vector<std::string> names;
  for (const CaseHead& head : chosen(options)) names.push_back(head.path.string());
  if (names.empty()) {
    throw InputError({options.case_folder}, fmt::format("holds no case of tier '{}'", options.tier),
                     "nothing to verify", "See veriflex list");
  }
  if (!options.json) announce(names, options);
  const int code = run_cases(names, options, false);
  if (options.json) return code;  // standard output is the JSON document
  if (stop::asked()) {
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
  command.add_option("--junit", options.junit, "also write a report of these cases in the form of JUnit");
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
  run->add_flag("--resume", options->resume,
                "go on from the checkpoint in --out that an earlier run has left, see run.checkpoint");
  run->footer("Example: veriflex run path/to/mine.toml --set bond.epsilon=2.0 --out results");
  run->callback([options, &exit_code] { exit_code = run_cases(options->cases, *options, true); });

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
