#include "contract_commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>

#include "base/say.hpp"
#include "base/stop.hpp"
#include "choose_cases.hpp"
#include "engine/baseline.hpp"
#include "engine/difference.hpp"
#include "engine/validate.hpp"
#include "exit_code.hpp"
#include "io/file.hpp"
#include "measures/drivers.hpp"
#include "repository.hpp"
#include "run_cases.hpp"
#include "studies/studies.hpp"
#include "threads.hpp"

namespace veriflex {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;
using engine::Case;
using engine::Check;
using engine::Reference;
using engine::Verdict;

// Without the checks against its baseline.
Case read(const std::string& name) {
  Options options;
  options.threads = usable_threads(0);
  return read_without_baseline(engine::case_named(name, repository::cases()), options);
}

std::string shell_word(const std::string& word) {
  const bool plain =
      word.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_./=+,:@%") ==
      std::string::npos;
  if (plain && !word.empty()) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

int validate_command(const std::vector<std::string>& given, bool json) {
  Options options;
  options.cases = given;
  const std::vector<std::string> names = given.empty() ? given : chosen_cases(options);
  std::vector<std::string> problems;
  if (names.empty()) {
    problems =
        engine::problems_of_repository(repository::cases(), repository::references(), studies::readers());
  } else {
    std::vector<fs::path> paths;
    for (const std::string& name : names) {
      try {
        paths.push_back(engine::case_named(name, repository::cases()));
      } catch (const InputError& error) {
        problems.emplace_back(error.what());
      }
    }
    for (std::string& one :
         engine::problems_of(paths, repository::cases(), repository::references(), studies::readers())) {
      problems.push_back(std::move(one));
    }
    for (const fs::path& path : paths) {
      try {
        studies::require_rows(path);
      } catch (const InputError& error) {
        if (std::find(problems.begin(), problems.end(), error.what()) == problems.end()) {
          problems.emplace_back(error.what());
        }
      }
    }
  }
  for (const std::string& problem : problems) complain("{}", problem);
  if (json) {
    print_json(Json{{"problems", problems}});
  } else if (problems.empty()) {
    say("nothing wrong found\n");
  }
  return problems.empty() ? exit_code::success : exit_code::input;
}

void print_check(const Case& c, const Check& check) {
  say("  {} {}: {}\n", to_string(check.kind), check.measure, check.statement);
  if (check.curve) {
    say("      against the curve {} over {} of reference {}\n", check.curve->y, check.curve->x,
        c.references[*check.reference].id);
  } else {
    say("      target {}{} ({}; {})\n", check.target, check.outside ? ", must lie outside" : "",
        check.target_kind, check.reference ? "reference " + c.references[*check.reference].id : check.source);
  }
  say("      {}{}: {}\n", check.uncertainty ? "" : "tolerance ", check.tolerance.text,
      check.tolerance.reason);
  if (check.uncertainty) {
    const engine::Uncertainty& u = *check.uncertainty;
    say("      of reference {}, numerical {}, input {}\n", u.reference,
        u.gci ? *u.gci : fmt::format("{}", u.numerical), u.input);
  }
  if (!check.claims.empty()) say("      judges {} of the ledger\n", fmt::join(check.claims, ", "));
  if (check.refuted) say("      refuted: recorded as {}\n", check.refuted->value);
}

void print_reference(const Reference& reference) {
  say("  {} ({})\n      source    {}\n      obtained  {}\n", reference.id, reference.kind, reference.source,
      reference.obtained);
  for (const std::string& citation : reference.citations) say("      cites     {}\n", citation);
  if (!reference.command.empty()) say("      made by   {}\n", reference.command);
  if (!reference.sha256.empty()) say("      SHA-256   {}\n", reference.sha256);
  if (reference.origin) {
    say("      accepted  {} at revision {} ({}, {}): {}\n", reference.origin->date,
        reference.origin->revision, reference.origin->compiler, reference.origin->machine,
        reference.origin->reason);
  }
}

Json info_json(const Case& c) {
  Json assumed = Json::array(), built = Json::array(), left_out = Json::array(), checks = Json::array(),
       references = Json::array();
  for (const engine::Assumption& a : c.assumed)
    assumed.push_back({{"path", a.path}, {"value", a.value}, {"why", a.why}});
  for (const scene::Built& b : c.study.plan.built) built.push_back({{"module", b.module}, {"what", b.what}});
  for (const scene::LeftOut& l : c.study.plan.left_out)
    left_out.push_back({{"module", l.module}, {"why", l.why}});
  for (const Check& check : c.checks) {
    checks.push_back(
        {{"kind", to_string(check.kind)},
         {"metric", check.measure},
         {"statement", check.statement},
         {"target", check.curve ? Json(nullptr) : Json(check.target)},
         {"target_kind", check.target_kind},
         {"holds", check.outside ? "outside" : "within"},
         {"tolerance", check.tolerance.text},
         {"reason", check.tolerance.reason},
         {"reference", check.reference ? Json(c.references[*check.reference].id) : Json(nullptr)},
         {"claims", check.claims}});
  }
  for (const Reference& r : c.references) {
    references.push_back({{"id", r.id}, {"kind", r.kind}, {"source", r.source}, {"obtained", r.obtained}});
  }
  return {{"id", c.id},
          {"title", c.title},
          {"question", c.question},
          {"equation", c.equation},
          {"tier", c.tier},
          {"driver", c.driver},
          {"topics", c.topics},
          {"sources", c.sources},
          {"assumed", assumed},
          {"built", built},
          {"left_out", left_out},
          {"checks", checks},
          {"references", references},
          {"path", fs::absolute(c.path).string()}};
}

void info_command(const std::string& name, bool json) {
  Case c = read(name);
  engine::compare_with_baseline(c, repository::cases(), repository::references());
  if (json) {
    print_json(info_json(c));
    return;
  }
  say("{}: {}\n\n{}\n\n  {}\n\n", c.id, c.title, c.question, c.equation);
  say("tier {}, driver {}, topics {}\n", c.tier, c.driver, fmt::join(c.topics, ", "));
  say("sources\n");
  for (const std::string& source : c.sources) say("  {}\n", source);
  if (!c.assumed.empty()) say("assumed, because the sources do not say\n");
  for (const engine::Assumption& a : c.assumed) say("  {} = {}: {}\n", a.path, a.value, a.why);
  say("plan\n");
  for (const scene::Built& b : c.study.plan.built) say("  built     {:<12} {}\n", b.module, b.what);
  for (const scene::LeftOut& l : c.study.plan.left_out) say("  left out  {:<12} {}\n", l.module, l.why);
  say("checks\n");
  for (const Check& check : c.checks) print_check(c, check);
  if (!c.references.empty()) say("references\n");
  for (const Reference& reference : c.references) print_reference(reference);
  say("run it\n  veriflex run {}\n", shell_word(c.path.string()));
}

Json changes_json(const std::vector<engine::Change>& changes) {
  Json all = Json::array();
  const auto value = [](const std::optional<double>& of) { return of ? Json(*of) : Json(nullptr); };
  for (const engine::Change& one : changes) {
    all.push_back({{"metric", one.metric}, {"earlier", value(one.earlier)}, {"now", value(one.now)}});
  }
  return all;
}

void print_changes(const std::vector<engine::Change>& changes) {
  const auto text = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.17g}", *value) : std::string("-");
  };
  say("{:<32} {:>24} {:>24} {:>16}\n", "metric", "earlier", "now", "relative change");
  for (const engine::Change& change : changes) {
    std::string relative = "-";
    if (change.earlier && change.now) {
      const double difference = *change.earlier == *change.now ? 0.0 : *change.now - *change.earlier;
      relative = fmt::format("{:.3g}", difference == 0.0 ? 0.0 : difference / std::abs(*change.earlier));
    }
    say("{:<32} {:>24} {:>24} {:>16}\n", change.metric, text(change.earlier), text(change.now), relative);
  }
}

std::vector<engine::RecordChange> table_changes(const Reference& earlier, const engine::Result& result) {
  const observe::Record none{"", "", {}};
  const std::optional<observe::Record> now = engine::table_to_keep(result);
  return engine::record_changes(earlier.table ? *earlier.table : none, now ? *now : none);
}

std::string in_words(const engine::RecordChange& change) {
  return change.what.empty()
             ? fmt::format("by at most {:.3g} of the column's largest magnitude", change.relative)
             : change.what;
}

// What the present baseline says is no reason against a new one.
bool is_admitted(const engine::Result& result, const std::string& baseline) {
  for (std::size_t i = 0; i < result.outcomes.size(); ++i) {
    const std::optional<std::size_t> reference = result.c.checks[i].reference;
    const bool by_baseline = reference && result.c.references[*reference].id == baseline;
    if (result.outcomes[i].verdict == Verdict::fail && !by_baseline) return false;
  }
  return result.has_answer();
}

// The baseline at `path`, if there is one. With `replace` one that cannot be read counts as none.
std::optional<Reference> earlier_baseline(const fs::path& path, bool replace) {
  std::error_code unknown;
  if (!fs::exists(path, unknown)) return std::nullopt;
  std::optional<Reference> earlier;
  try {
    earlier = engine::read_reference(path);
  } catch (const InputError& error) {
    if (!replace) throw;
    complain("{}. It is replaced", error.what());
    return std::nullopt;
  }
  if (!earlier->origin) {
    throw InputError({path.string()}, "is no baseline", "only baselines are renewed", "Move that reference");
  }
  return earlier;
}

int accept_command(const std::string& name, const std::string& reason, bool replace, bool json) {
  const Case c = read(name);
  const fs::path path = engine::baseline_path(c, repository::cases(), repository::references());
  const std::optional<Reference> earlier = earlier_baseline(path, replace);
  const stop::Handlers handlers;
  const int threads = usable_threads(0);
  make_team(threads);
  const engine::Result result = engine::run_case(c, threads);
  if (!is_admitted(result, path.stem().string())) {
    const bool has_none = !result.has_answer();
    complain("{}: not accepted, its verdict is {} ({}). See veriflex run {}, and mend it first",
             c.path.string(), to_string(result.verdict),
             has_none ? result.error_message : "a baseline must be a result that its checks admit",
             shell_word(c.path.string()));
    return has_none ? exit_code::of_error(result.error_kind) : exit_code::check_failed;
  }
  Json told{
      {"baseline", path.string()}, {"changes", nullptr}, {"columns", Json::array()}, {"written", false}};
  const auto end = [&] {
    if (json) print_json(told);
    return exit_code::success;
  };
  if (earlier) {
    const std::vector<engine::Change> found = engine::changes(*earlier, result.seen);
    const std::vector<engine::RecordChange> columns = table_changes(*earlier, result);
    told["changes"] = changes_json(found);
    for (const engine::RecordChange& one : columns)
      told["columns"].push_back({{"column", one.column}, {"change", in_words(one)}});
    if (!json) {
      say("earlier baseline: {}, revision {}\n", earlier->origin->date, earlier->origin->revision);
      print_changes(found);
      for (const engine::RecordChange& one : columns)
        say("column {} of {}: {}\n", one.column, one.record, in_words(one));
    }
    if (!engine::differ(found) && columns.empty() && !replace) {
      if (!json)
        say("the baseline says so already; --replace renews its reason and provenance\n{}\n", path.string());
      return end();
    }
    if (!replace) {
      throw InputError({path.string()}, "holds other values", "a baseline is not overwritten unasked",
                       "Give --replace if the change is wanted");
    }
  } else if (!json) {
    say("no earlier baseline\n");
  }
  const bool of_repository = path.parent_path() == repository::references();
  const std::string command =
      fmt::format("veriflex accept {} --reason {}{}", shell_word(of_repository ? c.id : c.path.string()),
                  shell_word(reason), replace ? " --replace" : "");
  io::write_file(path, engine::baseline_text(result, path, reason, command, earlier));
  told["written"] = true;
  if (!json) say("{}\n", path.string());
  return end();
}

}  // namespace

void add_contract_commands(CLI::App& app, int& exit_code) {
  struct Words {
    std::string name, reason;
    std::vector<std::string> names;
    bool replace = false, json = false;
  };
  const auto options = std::make_shared<Words>();

  CLI::App* info = app.add_subcommand("info", "one case in full: question, plan, checks, references");
  info->add_option("case", options->name, "path of a case file, or id")->required();
  info->footer("Example: veriflex info derive-fene-lj");
  info->add_flag("--json", options->json, "print one JSON object");
  info->callback([options] { info_command(options->name, options->json); });

  CLI::App* validate =
      app.add_subcommand("validate", "check cases, references and ledger without running anything");
  validate->add_option("case", options->names,
                       "paths of case files, ids, or patterns of ids (default: the whole repository)");
  validate->footer("Example: veriflex validate path/to/mine.toml");
  validate->add_flag("--json", options->json, "print the problems as JSON, too");
  validate->callback([options, &exit_code] { exit_code = validate_command(options->names, options->json); });

  CLI::App* accept = app.add_subcommand(
      "accept", "run a case and keep its metrics, or the table of a study, as the baseline of later runs");
  accept->add_option("case", options->name, "path of a case file, or id")->required();
  accept->add_option("--reason", options->reason, "why this result is accepted; kept in the baseline")
      ->required()
      ->check([](const std::string& text) {
        return text.find_first_not_of(" \t\n") == std::string::npos ? std::string("is empty") : std::string();
      });
  accept->add_flag("--replace", options->replace, "replace a baseline that holds other values");
  accept->add_flag("--json", options->json, "print the changes as JSON");
  accept->footer("Example: veriflex accept tensile-fene-lj --reason 'solver tolerance tightened'");
  accept->callback([options, &exit_code] {
    exit_code = accept_command(options->name, options->reason, options->replace, options->json);
  });
}

}  // namespace veriflex
