#include "case_commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/say.hpp"
#include "base/stop.hpp"
#include "choose_cases.hpp"
#include "estimates.hpp"
#include "exit_code.hpp"
#include "print_metrics.hpp"
#include "report_command.hpp"
#include "run_cases.hpp"
#include "threads.hpp"

namespace veriflex {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;
using engine::Case;
using engine::CaseHead;

void list_command(const Options& options) {
  const std::vector<CaseHead> heads = heads_chosen(options);
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
  const int threads = usable_threads(options.threads);
  Json all = Json::array();
  for (const std::string& name : chosen_cases(options)) {
    const Case c = read_case(engine::case_named(name, options.case_folder), options);
    Json built = Json::array();
    Json left_out = Json::array();
    double memory = 0.0;
    if (!options.json) say("{}: {}\n", c.id, c.title);
    if (!options.json && !c.study.lacks.empty()) say("  skipped   {}\n", c.study.lacks);
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
      const std::map<std::string, double> moved = moved_by_offers(c.id, options);
      for (const scene::Offer& offer : c.study.offers()) {
        const auto seen = moved.find(offer.what);
        const Json moves = seen == moved.end() ? Json(nullptr) : Json(seen->second);
        offered.push_back(
            {{"what", offer.what}, {"saves", offer.saves}, {"setting", offer.setting}, {"moves", moves}});
        if (options.json) continue;
        say("  offered   {:<12} saves {} (--set '{}')\n", offer.what, offer.saves, offer.setting);
        if (seen != moved.end())
          say("            {:<12} moves the metrics by {:.2g} at most, as an ablation here has seen\n", "",
              seen->second);
      }
      if (!options.json && !offered.empty())
        say("  what the offers cost in accuracy: veriflex ablate {} --offered; which box is enough: veriflex "
            "sweep {} "
            "--over 'fluid.nodes.0=...' --error METRIC --against-finest\n",
            name, name);
    }
    Json takes = nullptr;
    if (const std::optional<double> seconds = estimated_seconds(c, options)) {
      takes = *seconds;
      if (!options.json) {
        say("  takes     about {:.2g} s and {:.3g} MB, on this machine with {} thread{}\n", *seconds,
            1e-6 * memory, threads, threads == 1 ? "" : "s");
      }
    }
    Json measures = Json::array();
    const std::vector<observe::Metric> measured = engine::measured(c.study);
    for (const observe::Metric& m : measured)
      measures.push_back({{"name", m.name}, {"dimension", m.dimension}, {"meaning", m.meaning}});
    if (!options.json) print_names(measured, "  measures  ");
    all.push_back({{"id", c.id},
                   {"lacks", c.study.lacks},
                   {"built", built},
                   {"left_out", left_out},
                   {"offered", offered},
                   {"seconds", takes},
                   {"measures", measures}});
  }
  if (options.json) print_json(all);
}

// Says what a tier will take.
void announce(const std::vector<std::optional<double>>& expected, const Options& options) {
  double seconds = 0.0;
  std::size_t unknown = 0;
  for (const std::optional<double>& one : expected) {
    if (one) {
      seconds += *one;
    } else {
      ++unknown;
    }
  }
  const std::string others =
      unknown == 0 ? "" : fmt::format(", and {} more whose time nothing here tells", unknown);
  say("tier {}: {} cases take about {:.2g} s{}\n", options.tier, expected.size() - unknown, seconds, others);
  std::fflush(stdout);
}

int verify_command(const Options& options) {
  const std::vector<std::string> names = chosen_cases(options);
  const std::vector<std::optional<double>> expected = expected_seconds(names, options);
  if (!options.json) announce(expected, options);
  const int ran = run_cases(names, options, false, expected);
  const int code = exit_code::is_well(ran) ? exit_code::success : ran;  // the report says what was skipped
  if (options.json) return code;  // standard output is the JSON document
  if (stop::asked()) {
    complain("{}: no report is drawn", stop::reason());
    return exit_code::first_of(code, exit_code::numerical);
  }
  return exit_code::first_of(code, report_command(options.out, options.report, false));
}

int run_command(const Options& options) {
  const std::vector<std::string> names = chosen_cases(options);
  return run_cases(names, options, true,
                   names.size() > 1 && isatty(STDERR_FILENO) == 1 ? expected_seconds(names, options)
                                                                  : std::vector<std::optional<double>>{});
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

void add_many_options(CLI::App& command, Options& options) {
  command
      .add_option("-j,--jobs", options.jobs,
                  "cases side by side, which share the threads; those that are timed run alone, after the "
                  "others")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command.add_flag("--fail-fast", options.fail_fast,
                   "start no other case once one has failed or ended in an error");
}

void add_case_names(CLI::App& command, Options& options) {
  command.add_option("case", options.cases, "paths of case files, ids, or patterns of ids like 'cost-*'");
}

void add_settings(CLI::App& command, Options& options) {
  command.add_option("--set", options.overrides, "replace a value of the case, key=value; may be repeated")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
}

void add_labels(CLI::App& command, Options& options) {
  command
      .add_option("--tier", options.tier,
                  "only cases of this tier (quick, full, paper), of those that are not named in full")
      ->check(CLI::IsMember(engine::tiers()));
  command.add_option("--topic", options.topic, "only cases with this topic, likewise");
}

void add_case_folder(CLI::App& command, Options& options) {
  command.add_option("--cases", options.case_folder, "folder of case files")->capture_default_str();
}

}  // namespace

void add_case_commands(CLI::App& app, int& exit_code) {
  const auto options = std::make_shared<Options>();

  CLI::App* list = app.add_subcommand("list", "the cases there are");
  add_labels(*list, *options);
  list->add_flag("--json", options->json, "print a JSON array");
  add_case_folder(*list, *options);
  list->footer("Example: veriflex list --topic tensile");
  list->callback([options] { list_command(*options); });

  CLI::App* plan = app.add_subcommand("plan", "what a case will build and leave out, without running it");
  add_case_names(*plan, *options);
  add_labels(*plan, *options);
  add_settings(*plan, *options);
  plan->add_flag("--json", options->json, "print a JSON array");
  add_case_folder(*plan, *options);
  plan->footer("Example: veriflex plan tensile-fene-lj --set 'solid.nodes=[8, 8, 40]'");
  plan->callback([options] { plan_command(*options); });

  CLI::App* run = app.add_subcommand("run", "run cases, judge them and write a result file each");
  add_case_names(*run, *options);
  add_labels(*run, *options);
  add_settings(*run, *options);
  add_run_options(*run, *options);
  add_many_options(*run, *options);
  add_case_folder(*run, *options);
  run->add_flag("--resume", options->resume,
                "go on from the checkpoint in --out that an earlier run has left, see run.checkpoint");
  run->footer(
      "Example: veriflex run path/to/mine.toml --set bond.epsilon=2.0 --out results\n"
      "         veriflex run 'tensile-*' --tier quick --jobs 4");
  run->callback([options, &exit_code] { exit_code = run_command(*options); });

  CLI::App* job = app.add_subcommand("job", "one of the cases that run side by side");
  job->group("");  // not shown: run and verify call it
  add_case_names(*job, *options);
  add_settings(*job, *options);
  add_run_options(*job, *options);
  add_case_folder(*job, *options);
  job->add_flag("--resume", options->resume, "as of run");
  job->add_flag("--brief", options->brief, "without tables");
  job->callback([options, &exit_code] {
    prctl(PR_SET_PDEATHSIG, SIGTERM);  // it does not outlive the command that asked for it
    exit_code = run_cases(options->cases, *options, !options->brief);
  });

  CLI::App* verify = app.add_subcommand("verify", "run every case of a tier and write the report");
  verify->add_option("case", options->cases, "patterns of ids: only cases of the tier that match one");
  verify->add_option("--tier", options->tier, "quick, full or paper")
      ->default_str("quick")
      ->check(CLI::IsMember(engine::tiers()));
  verify->add_option("--topic", options->topic, "only cases with this topic");
  add_run_options(*verify, *options);
  add_many_options(*verify, *options);
  add_case_folder(*verify, *options);
  verify->footer("Example: veriflex verify --tier quick --out results --jobs 4");
  verify->callback([options, &exit_code] {
    if (options->tier.empty()) options->tier = "quick";
    exit_code = verify_command(*options);
  });

  CLI::App* report =
      app.add_subcommand("report", "draw the report from result files and print the table of verdicts");
  report->add_option("results", options->out, "folder of result files")->capture_default_str();
  report->add_option("--out", options->report,
                     "the HTML file to write (default: report.html among the results)");
  report->add_flag("--json", options->json, "print the verdicts as JSON");
  report->footer("Example: veriflex report results --out report.html");
  report->callback(
      [options, &exit_code] { exit_code = report_command(options->out, options->report, options->json); });
}

}  // namespace veriflex
