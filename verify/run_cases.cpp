#include "run_cases.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <optional>

#include "base/say.hpp"
#include "base/stop.hpp"
#include "engine/attachments.hpp"
#include "engine/baseline.hpp"
#include "engine/result.hpp"
#include "engine/stored_result.hpp"
#include "engine/total_progress.hpp"
#include "exit_code.hpp"
#include "io/file.hpp"
#include "junit.hpp"
#include "print_metrics.hpp"
#include "print_study.hpp"
#include "results_json.hpp"
#include "run_jobs.hpp"
#include "studies/studies.hpp"
#include "threads.hpp"

namespace veriflex {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;
using engine::Case;
using engine::Result;
using engine::Verdict;

engine::Readers readers_for(const Options& options) {
  if (options.is_row) return studies::readers_of_row();
  engine::Readers readers = studies::readers({.program = fs::read_symlink("/proc/self/exe"),
                                              .results = options.out,
                                              .threads = std::max(1, options.threads),
                                              .fresh = options.fresh,
                                              .shard = options.shard,
                                              .shards = options.shards});
  readers.with_checks = options.with_checks;
  return readers;
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
  if (!r.has_answer()) json["error"] = {{"kind", r.error_kind}, {"message", r.error_message}};
  return json;
}

void print_table(const Result& r) {
  print_study(r.seen);
  if (r.outcomes.empty()) {
    print_metrics(r.seen.metrics, "        ");
    return;
  }
  std::size_t width = 6;
  for (const engine::Outcome& o : r.outcomes) width = std::max(width, o.measure.size());
  say("        {:<{}}  {:>24}  {:>24}  {:>9}  {}\n", "metric", width, "measured", "target", "margin",
      "verdict");
  for (const engine::Outcome& o : r.outcomes) {
    const std::string target = o.outside ? fmt::format("beyond {:.10g} +- {:.3g}", o.target, o.tolerance)
                                         : fmt::format("{:.17g}", o.target);
    say("        {:<{}}  {:>24.17g}  {:>24}  {:>9.2g}  {}\n", o.measure, width, o.measured, target, o.margin,
        to_string(o.verdict));
  }
}

// What the measured number had to be.
std::string wanted(const engine::Outcome& o) {
  if (o.outside) return fmt::format("must lie beyond {:.17g} +- {:.3g}", o.target, o.tolerance);
  return fmt::format("target {:.17g}, {} {:.3g}", o.target, o.uncertainty ? "uncertainty" : "tolerance",
                     o.tolerance);
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
  if (!r.has_answer()) say("        {}\n", r.error_message);
  if (with_table && !stored.empty()) say("        result {}\n", stored);
}

int exit_code_of(const Result& r) {
  if (r.verdict == Verdict::fail) return exit_code::check_failed;
  return r.has_answer() ? exit_code::success : exit_code::of_error(r.error_kind);
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
    options_.threads = threads_;
    make_team(threads_);
  }

  // What becomes of a case is stored in any case, before anything is said about it: while it runs, its place
  // is held by a result that says so, so that no earlier verdict outlives a run that is killed.
  Result run(const Asked& asked) {
    stored_.clear();
    if (asked.path.empty()) return not_run(asked, {"input", asked.problem});
    if (stop::asked()) {
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
    std::optional<engine::Checkpoints> checkpoints;
    try {
      c = read_case(asked.path, options_);
      keep_checkpoints(*c, checkpoints);
      if (!store(result)) return result;
    } catch (...) {
      result.fail(engine::current_failure());
      if (options_.is_row && is_file)
        result.c.text = io::read_file(asked.path);  // a row says of which case it is
      if (is_file) store(result);
      return result;
    }
    result = run(*c, checkpoints ? &*checkpoints : nullptr);
    std::error_code none;
    if (checkpoints && result.error_kind == "interrupted" && fs::exists(checkpoints->file(), none)) {
      result.error_message += fmt::format(". Its last checkpoint is {}: run it again with --resume",
                                          checkpoints->file().string());
    }
    const bool is_stored = store(result);
    // A failure would come again.
    const bool is_over = result.verdict != Verdict::error || result.error_kind == "numerical";
    if (checkpoints && is_stored && is_over) checkpoints->remove();
    return result;
  }

  // Of the last case; empty if it could not be stored.
  const std::string& stored() const { return stored_; }

 private:
  // A row of a study is there for its numbers: of its snapshots there would be as many as rows.
  Result run(const Case& c, engine::Checkpoints* checkpoints) const {
    if (options_.is_row) return engine::run_case(c, threads_, options_.repeats);
    const bool goes_on = checkpoints != nullptr && checkpoints->earlier() != nullptr;
    const observe::Attaching attaching(
        engine::attach_to(engine::attachments_folder(c.name(), options_.out),
                          goes_on ? engine::EarlierFiles::stay : engine::EarlierFiles::go));
    return engine::run_case(c, threads_, 0, checkpoints);
  }

  Result not_run(const Asked& asked, const engine::Failure& failure) const {
    return engine::not_run(asked.path.empty() ? fs::path(asked.name) : asked.path, options_.overrides,
                           failure, threads_);
  }

  // Of one run alone: the rows of a study are what is left of it.
  void keep_checkpoints(const Case& c, std::optional<engine::Checkpoints>& checkpoints) const {
    const bool has_some = c.study.run_with_checkpoints && !c.study.runs && !options_.is_row;
    if (has_some) checkpoints.emplace(engine::checkpoint_path(c, options_.out), c, options_.resume);
    if (has_some || !options_.resume) return;
    throw InputError({c.path.string()}, "leaves no checkpoints to go on from",
                     "one run of the driver 'scene' with run.checkpoint does", "Run it without --resume");
  }

  // Whether the result could be written; if not it becomes the error that says why.
  bool store(Result& result) {
    if (options_.shards > 1) return true;  // a part of a study is no result; its rows are kept
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

  Options options_;
  int threads_;
  std::string stored_;
};

// What a case that ran in a program of its own has left.
JunitCase stored_junit_case(const fs::path& path, const Options& options) {
  const std::string name = engine::name_of_variant(path.stem().string(), options.overrides);
  try {
    return junit_case(engine::read_result(fs::path(options.out) / (name + ".h5")));
  } catch (...) {
    const engine::Failure why = engine::current_failure();
    return {name, "unreadable", 0.0, {}, "output", why.message, {}};
  }
}

std::vector<JunitCase> some_of(const std::vector<std::optional<JunitCase>>& cases) {
  std::vector<JunitCase> some;
  for (const std::optional<JunitCase>& one : cases) {
    if (one) some.push_back(*one);
  }
  return some;
}

}  // namespace

int attempted(const std::function<void()>& work) {
  try {
    work();
    return exit_code::success;
  } catch (...) {
    const engine::Failure why = engine::current_failure();
    complain("{}", why.message);
    return exit_code::of_error(why.kind);
  }
}

void print_json(const Json& json) { say("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace)); }

Case read_without_baseline(const fs::path& path, const Options& options) {
  return engine::read_case(path, options.overrides, readers_for(options), repository::references());
}

Case read_case(const fs::path& path, const Options& options) {
  Case c = read_without_baseline(path, options);
  if (!options.is_row) engine::compare_with_baseline(c, repository::cases(), repository::references());
  return c;
}

int run_cases(const std::vector<std::string>& names, const Options& options, bool with_tables,
              std::vector<std::optional<double>> expected) {
  const std::vector<Asked> cases = asked_for(names, options);
  expected.resize(cases.size());
  const int side_by_side = std::min(options.jobs, static_cast<int>(cases.size()));
  engine::TotalProgress progress(std::move(expected), side_by_side);
  int code = exit_code::success;
  Json all = Json::array();
  for (std::size_t i = 0; i < cases.size(); ++i) all.push_back(nullptr);
  std::vector<std::optional<JunitCase>> junit(cases.size());
  Runs runs(options);
  const stop::Handlers handlers;
  const auto run_here = [&](std::size_t i) {
    progress.show(fs::path(cases[i].name).stem().string());
    const Result result = runs.run(cases[i]);
    progress.clear();
    progress.done(i, result.cost.wall_seconds());
    code = exit_code::first_of(code, exit_code_of(result));
    junit[i] = junit_case(result);
    if (result.verdict == Verdict::error) {
      const bool has_place = result.error_kind == "input" || result.error_kind == "output";
      complain("{}{}", has_place ? "" : result.c.path.string() + ": ", result.error_message);
    }
    if (options.json) {
      all[i] = result_json(result, runs.stored());
      return;
    }
    print_result(result, runs.stored(), with_tables);
    if (options.shards > 1)
      say("        shard {} of {}: rows in {}\n", options.shard + 1, options.shards, options.out);
    std::fflush(stdout);
  };
  std::vector<std::size_t> here;  // to be run by this program, one after another
  const auto is_over = [&] { return options.fail_fast && !exit_code::is_well(code); };
  if (side_by_side > 1) {
    Options shared = options;
    shared.threads = usable_threads(options.threads);
    std::vector<Job> jobs;
    for (std::size_t i = 0; i < cases.size(); ++i) {
      if (cases[i].path.empty()) {
        here.push_back(i);
      } else {
        jobs.push_back({i, cases[i].path});
      }
    }
    for (const std::size_t left : run_side_by_side(jobs, shared, with_tables, progress, all, code))
      here.push_back(left);
    for (const Job& job : jobs) {
      const bool was_run = std::find(here.begin(), here.end(), job.number) == here.end();
      if (was_run && !options.junit.empty()) junit[job.number] = stored_junit_case(job.path, options);
    }
    std::sort(here.begin(), here.end());
  } else {
    for (std::size_t i = 0; i < cases.size(); ++i) here.push_back(i);
  }
  std::size_t next = 0;
  while (next < here.size() && !is_over()) run_here(here[next++]);
  if (next < here.size()) {
    complain("{} of {} cases were not run: --fail-fast", here.size() - next, cases.size());
    Json some = Json::array();
    for (const Json& one : all) {
      if (!one.is_null()) some.push_back(one);
    }
    all.swap(some);
  }
  if (options.json) print_json(all);
  if (!options.junit.empty()) {
    code = exit_code::first_of(code, attempted([&] { write_junit(options.junit, some_of(junit)); }));
  }
  std::error_code none;  // where no case was found there is no folder
  if (cases.size() > 1 && fs::is_directory(options.out, none)) {
    code = exit_code::first_of(code, attempted([&] { write_results_json(options.out, options.out); }));
  }
  return code;
}

}  // namespace veriflex
