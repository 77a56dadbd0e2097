#include "contract_commands.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <omp.h>

#include <memory>

#include "drivers/drivers.hpp"
#include "engine/baseline.hpp"
#include "engine/validate.hpp"
#include "exit_code.hpp"
#include "io/file.hpp"
#include "repository.hpp"

namespace veriflex {

namespace fs = std::filesystem;

namespace {

using engine::Case;
using engine::Check;
using engine::Reference;
using engine::Verdict;

Case read(const std::string& name) {
  return engine::read_case(engine::case_named(name, repository::cases()), {}, drivers::all(),
                           repository::references());
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

int validate_command(const std::vector<std::string>& names) {
  std::vector<std::string> problems;
  if (names.empty()) {
    problems = engine::problems_of_repository(repository::cases(), repository::references(), drivers::all());
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
         engine::problems_of(paths, repository::cases(), repository::references(), drivers::all())) {
      problems.push_back(std::move(one));
    }
  }
  for (const std::string& problem : problems) fmt::print(stderr, "veriflex: {}\n", problem);
  if (problems.empty()) fmt::print("nothing wrong found\n");
  return problems.empty() ? exit_code::success : exit_code::input;
}

void print_check(const Case& c, const Check& check) {
  const bool is_claim = check.question == engine::Question::claim;
  fmt::print("  {} {}: {}\n", is_claim ? "claim" : "code ", check.measure, check.statement);
  if (check.curve) {
    fmt::print("      against the curve {} over {} of reference {}\n", check.curve->y, check.curve->x,
               c.references[*check.reference].id);
  } else {
    fmt::print("      target {}{} ({}; {})\n", check.target, check.outside ? ", must lie outside" : "",
               check.kind, check.reference ? "reference " + c.references[*check.reference].id : check.source);
  }
  fmt::print("      tolerance {}: {}\n", check.tolerance.text, check.tolerance.reason);
  if (is_claim) fmt::print("      judges {} of the ledger\n", fmt::join(check.claims, ", "));
  if (check.refuted) fmt::print("      refuted: recorded as {}\n", check.refuted->value);
}

void print_reference(const Reference& reference) {
  fmt::print("  {} ({})\n      source    {}\n      obtained  {}\n", reference.id, reference.kind,
             reference.source, reference.obtained);
  for (const std::string& citation : reference.citations) fmt::print("      cites     {}\n", citation);
  if (!reference.command.empty()) fmt::print("      made by   {}\n", reference.command);
  if (!reference.sha256.empty()) fmt::print("      SHA-256   {}\n", reference.sha256);
  if (reference.origin) {
    fmt::print("      accepted  {} at revision {} ({}, {}): {}\n", reference.origin->date,
               reference.origin->revision, reference.origin->compiler, reference.origin->machine,
               reference.origin->reason);
  }
}

void info_command(const std::string& name) {
  const Case c = read(name);
  fmt::print("{}: {}\n\n{}\n\n  {}\n\n", c.id, c.title, c.asks, c.equation);
  fmt::print("tier {}, driver {}, topics {}\n", c.tier, c.driver, fmt::join(c.topics, ", "));
  fmt::print("sources\n");
  for (const std::string& source : c.sources) fmt::print("  {}\n", source);
  if (!c.assumed.empty()) fmt::print("assumed, because the sources do not say\n");
  for (const engine::Assumption& a : c.assumed) fmt::print("  {} = {}: {}\n", a.path, a.value, a.why);
  fmt::print("plan\n");
  for (const scene::Built& b : c.study.plan.built) fmt::print("  built     {:<12} {}\n", b.module, b.what);
  for (const scene::LeftOut& l : c.study.plan.left_out)
    fmt::print("  left out  {:<12} {}\n", l.module, l.why);
  fmt::print("checks\n");
  for (const Check& check : c.checks) print_check(c, check);
  if (!c.references.empty()) fmt::print("references\n");
  for (const Reference& reference : c.references) print_reference(reference);
  fmt::print("run it\n  veriflex run {}\n", shell_word(c.path.string()));
}

void print_changes(const std::vector<engine::Change>& changes) {
  const auto text = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.17g}", *value) : std::string("-");
  };
  fmt::print("{:<32} {:>24} {:>24} {:>16}\n", "metric", "earlier", "now", "relative change");
  for (const engine::Change& change : changes) {
    std::string relative = "-";
    if (change.earlier && change.now) {
      const double difference = *change.earlier == *change.now ? 0.0 : *change.now - *change.earlier;
      relative = fmt::format("{:.3g}", difference == 0.0 ? 0.0 : difference / std::abs(*change.earlier));
    }
    fmt::print("{:<32} {:>24} {:>24} {:>16}\n", change.metric, text(change.earlier), text(change.now),
               relative);
  }
}

int accept_command(const std::string& name, const std::string& reason) {
  const Case c = read(name);
  const engine::Result result = engine::run_case(c, omp_get_max_threads());
  if (result.verdict != Verdict::pass) {
    fmt::print(stderr,
               "veriflex: {}: not accepted, its verdict is {} ({}). See veriflex run {}, and mend it first\n",
               c.path.string(), to_string(result.verdict),
               result.verdict == Verdict::error ? result.error_message
                                                : "a baseline must be a result that its checks admit",
               shell_word(c.path.string()));
    return result.verdict == Verdict::error ? exit_code::numerical : exit_code::check_failed;
  }
  const fs::path folder = fs::weakly_canonical(c.path).parent_path();
  const bool of_repository = folder == fs::weakly_canonical(repository::cases());
  const std::string id = c.id + "-baseline";
  const fs::path path = (of_repository ? repository::references() : folder) / (id + ".toml");
  if (fs::exists(path)) {
    const Reference earlier = engine::read_reference(path);
    if (earlier.kind != "baseline") {
      throw InputError({path.string()}, "is no baseline", "only baselines are renewed",
                       "Move that reference");
    }
    fmt::print("earlier baseline: {}, revision {}\n", earlier.origin->date, earlier.origin->revision);
    print_changes(engine::changes(earlier, result.seen));
  } else {
    fmt::print("no earlier baseline\n");
  }
  const std::string command =
      fmt::format("veriflex accept {} --reason {}", shell_word(of_repository ? c.id : c.path.string()),
                  shell_word(reason));
  io::write_file(path, engine::baseline_text(result, id, reason, command));
  fmt::print("{}\n", path.string());
  return exit_code::success;
}

}  // namespace

void add_contract_commands(CLI::App& app, int& exit_code) {
  struct Options {
    std::string name, reason;
    std::vector<std::string> names;
  };
  const auto options = std::make_shared<Options>();

  CLI::App* info = app.add_subcommand("info", "one case in full: question, plan, checks, references");
  info->add_option("case", options->name, "path of a case file, or id")->required();
  info->footer("Example: veriflex info derive-fene-lj");
  info->callback([options] { info_command(options->name); });

  CLI::App* validate =
      app.add_subcommand("validate", "check cases, references and ledger without running anything");
  validate->add_option("case", options->names, "paths of case files, or ids (default: the whole repository)");
  validate->footer("Example: veriflex validate path/to/mine.toml");
  validate->callback([options, &exit_code] { exit_code = validate_command(options->names); });

  CLI::App* accept =
      app.add_subcommand("accept", "run a case and keep its metrics as the baseline of later runs");
  accept->add_option("case", options->name, "path of a case file, or id")->required();
  accept->add_option("--reason", options->reason, "why this result is accepted; kept in the baseline")
      ->required()
      ->check([](const std::string& text) {
        return text.find_first_not_of(" \t\n") == std::string::npos ? std::string("is empty") : std::string();
      });
  accept->footer("Example: veriflex accept tensile-fene-lj --reason 'solver tolerance tightened'");
  accept->callback([options, &exit_code] { exit_code = accept_command(options->name, options->reason); });
}

}  // namespace veriflex
