#include "diff_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/say.hpp"
#include "diff_runs.hpp"
#include "exit_code.hpp"
#include "io/file.hpp"
#include "run_cases.hpp"

namespace veriflex {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;
using engine::StoredResult;

constexpr std::size_t most_rows = 10;  // of a table on a terminal

struct DiffOptions {
  std::string before, after, html;
  bool json = false;
};

// Reads what can be read, and notes what cannot.
std::vector<StoredResult> read_side(const std::string& where, DiffSide& side) {
  side.where = where;
  std::error_code unknown;
  const bool is_file = fs::is_regular_file(where, unknown);
  engine::StoredRun run =
      engine::read_results(is_file ? std::vector<fs::path>{where} : engine::result_files(where));
  std::vector<StoredResult> results = std::move(run.results);
  side.unreadable = std::move(run.unreadable);
  for (const StoredResult& r : results) {
    const std::string maker =
        fmt::format("program {:.20}, {}, {} threads, {}", r.program, r.compiler, r.threads, r.machine);
    if (std::find(side.made_by.begin(), side.made_by.end(), maker) == side.made_by.end()) {
      side.made_by.push_back(maker);
    }
  }
  side.results = results.size();
  if (results.empty() && side.unreadable.empty()) {
    throw InputError({where}, "holds no results", "there is nothing to compare",
                     "Name the folder that veriflex run or verify wrote to with --out");
  }
  return results;
}

Diff compare(const DiffOptions& asked) {
  std::error_code unknown;
  const bool one_file = fs::is_regular_file(asked.before, unknown);
  if (one_file != fs::is_regular_file(asked.after, unknown)) {
    throw InputError({asked.after}, one_file ? "is no result file" : "is no folder of results",
                     "two folders are compared, or two files", "Name two of a kind");
  }
  Diff diff{};
  std::vector<StoredResult> before = read_side(asked.before, diff.before);
  std::vector<StoredResult> after = read_side(asked.after, diff.after);
  // Two files are asked to be compared whatever they are called.
  if (one_file && !before.empty() && !after.empty()) before.front().id = after.front().id;
  diff.difference = engine::difference(before, after);
  return diff;
}

void print_side(const char* name, const DiffSide& side) {
  say("{}  {}: {} results\n", name, side.where, side.results);
  for (const std::string& maker : side.made_by) say("        {}\n", maker);
}

void print_table(const DiffTable& table) {
  say("\n{} ({})\n", table.title, table.rows.size());
  std::size_t id = 0, what = 0, before = 0, after = 0;
  const std::size_t shown = std::min(table.rows.size(), most_rows);
  for (std::size_t i = 0; i < shown; ++i) {
    id = std::max(id, table.rows[i].id.size());
    what = std::max(what, table.rows[i].what.size());
    before = std::max(before, table.rows[i].before.size());
    after = std::max(after, table.rows[i].after.size());
  }
  for (std::size_t i = 0; i < shown; ++i) {
    const DiffRow& row = table.rows[i];
    std::string line = fmt::format("  {:<{}}  {:<{}}  {:>{}}  {:>{}}  {}", row.id, id, row.what, what,
                                   row.before, before, row.after, after, row.change);
    line.erase(line.find_last_not_of(' ') + 1);
    say("{}\n", line);
  }
  if (table.rows.size() > shown) say("  and {} more (--json or --html has all)\n", table.rows.size() - shown);
}

void print(const Diff& diff) {
  print_side("before", diff.before);
  print_side("after ", diff.after);
  say("{}\n", summary_of(diff));
  if (diff.is_same()) {
    say("same, bit for bit, but for times\n");
  } else if (diff.difference.worse.empty()) {
    say("nothing is worse\n");
  } else {
    say("\nworse ({})\n", diff.difference.worse.size());
    for (const std::string& one : diff.difference.worse) say("  {}\n", one);
  }
  for (const DiffTable& table : tables_of(diff.difference)) print_table(table);
}

Json json_of(const DiffSide& side) {
  return {{"where", side.where},
          {"results", side.results},
          {"made_by", side.made_by},
          {"unreadable", side.unreadable}};
}

Json json_of(const std::optional<engine::StoredCheck>& check) {
  if (!check) return nullptr;
  return {{"verdict", check->verdict},    {"measured", check->measured},   {"holds", check->holds},
          {"target", check->target},      {"tolerance", check->tolerance}, {"margin", check->margin},
          {"statement", check->statement}};
}

Json json_of(const engine::CaseDifference& d) {
  Json checks = Json::array(), metrics = Json::array(), records = Json::array(), references = Json::array();
  for (const engine::CheckChange& c : d.checks) {
    checks.push_back(
        {{"metric", c.either().metric}, {"before", json_of(c.before)}, {"after", json_of(c.after)}});
  }
  for (const engine::NumberChange& m : d.metrics) {
    metrics.push_back({{"name", m.name}, {"before", m.before}, {"after", m.after}, {"relative", m.relative}});
  }
  for (const engine::RecordChange& r : d.records) {
    records.push_back(
        {{"record", r.record}, {"column", r.column}, {"what", r.what}, {"relative", r.relative}});
  }
  for (const engine::ReferenceChange& r : d.references) {
    references.push_back({{"id", r.id}, {"before", r.before}, {"after", r.after}});
  }
  Json slower = nullptr;
  if (d.slow_down) {
    slower = {{"before", d.slow_down->before}, {"after", d.slow_down->after}, {"why", d.slow_down->why}};
  }
  return {{"id", d.id},
          {"same", d.is_same()},
          {"worse", d.worse},
          {"verdict", {{"before", d.verdict_before}, {"after", d.verdict_after}}},
          {"error", {{"before", d.error_before}, {"after", d.error_after}}},
          {"case_text_changed", d.text_changed},
          {"checks", checks},
          {"same_checks", d.same_checks},
          {"metrics", metrics},
          {"same_metrics", d.same_metrics},
          {"lost_metrics", d.lost_metrics},
          {"new_metrics", d.new_metrics},
          {"records", records},
          {"same_records", d.same_records},
          {"references", references},
          {"plan", d.plan},
          {"warnings", d.warnings},
          {"slow_down", slower}};
}

Json json_of(const Diff& diff) {
  Json cases = Json::array();
  for (const engine::CaseDifference& d : diff.difference.cases) cases.push_back(json_of(d));
  return {{"before", json_of(diff.before)},
          {"after", json_of(diff.after)},
          {"same", diff.is_same()},
          {"worse", diff.difference.worse},
          {"cases", cases},
          {"only_before", diff.difference.lost},
          {"only_after", diff.difference.added}};
}

int diff_command(const DiffOptions& asked) {
  const Diff diff = compare(asked);
  int code = diff.difference.worse.empty() ? exit_code::success : exit_code::check_failed;
  for (const DiffSide* side : {&diff.before, &diff.after}) {
    for (const std::string& message : side->unreadable) {
      complain("{}", message);
      code = exit_code::input;
    }
  }
  if (!asked.html.empty()) io::write_file(asked.html, html_of(diff));
  if (asked.json) {
    print_json(json_of(diff));
  } else {
    print(diff);
  }
  return code;
}

}  // namespace

void add_diff_command(CLI::App& app, int& exit_code) {
  const auto asked = std::make_shared<DiffOptions>();
  CLI::App* diff = app.add_subcommand("diff", "what two runs of the same cases say differently");
  diff->add_option("before", asked->before, "folder of result files, or one result file")->required();
  diff->add_option("after", asked->after, "the same of the later run")->required();
  diff->add_flag(
      "--json", asked->json,
      "print a JSON object: before, after, same, worse (in words), cases (each with all that changed), "
      "only_before, only_after");
  diff->add_option("--html", asked->html, "also write a page that needs no other file");
  diff->footer(
      "Exit codes: 0 nothing is worse, 1 a new failure or error, or a case or check that is gone, 2 a result "
      "cannot be read.\nTimes never count. Example: veriflex diff results-of-yesterday results");
  diff->callback([asked, &exit_code] { exit_code = diff_command(*asked); });
}

}  // namespace veriflex
