#include "claims_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/say.hpp"
#include "engine/ledger.hpp"
#include "exit_code.hpp"
#include "repository.hpp"

namespace veriflex {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;
using engine::Entry;
using engine::Judged;
using engine::Judgement;
using engine::Ledger;

std::string words(const Judgement& j) {
  if (j.verdict == "pass") return "holds";
  if (j.verdict == "finding") return "refuted";
  return j.verdict;
}

// "published" stands only over what is printed in a publication.
std::string word_for_target(const Judgement& j) {
  return j.target_kind.starts_with("published-") ? "published" : "target";
}

void print_judgement(const Judgement& j) {
  if (j.metric.empty()) {
    say("    {:<8} {}\n", words(j), j.case_id);
    return;
  }
  const std::string wanted = j.outside
                                 ? fmt::format("must lie beyond {:.10g} +- {:.3g}", j.target, j.tolerance)
                                 : fmt::format("{} {:.10g}", word_for_target(j), j.target);
  say("    {:<8} {}: {} measured {:.10g}, {}. {}\n", words(j), j.case_id, j.metric, j.measured, wanted,
      j.statement);
}

std::string counts_in_words(const std::map<std::string, int>& counts) {
  std::vector<std::string> parts;
  for (const std::string& one : engine::standings()) {
    if (one == "unsettled" && counts.at(one) == 0) continue;
    parts.push_back(fmt::format("{} {}", counts.at(one), one == "holds" ? "hold" : one));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

// A benchmark is no statement that could be refuted: what is computed agrees with it, or the program is off.
std::string agreement(const Entry& entry, const std::vector<Judgement>& judgements) {
  const std::string standing = engine::standing(entry, judgements);
  if (standing == "holds") return "agrees";
  const bool departs = std::any_of(judgements.begin(), judgements.end(),
                                   [](const Judgement& j) { return j.verdict == "fail"; });
  return departs ? "does not agree" : standing;
}

void print_agreement(const Judgement& j) {
  if (j.metric.empty()) {
    say("    {:<8} {}\n", words(j), j.case_id);
    return;
  }
  const double error = std::abs(j.measured - j.target), scale = std::abs(j.target);
  const std::string off = j.target == 0.0 ? fmt::format("{:.2g} off, within {:.2g}", error, j.tolerance)
                                          : fmt::format("{:.2g} % off, within {:.2g} %",
                                                        100.0 * error / scale, 100.0 * j.tolerance / scale);
  say("    {:<8} {}: {} measured {:.6g}, {} {:.6g}, {} ({}); {:.3g} s. {}\n",
      j.verdict == "pass" ? "agrees" : j.verdict, j.case_id, j.metric, j.measured, word_for_target(j),
      j.target, off, j.is_uncertainty ? "uncertainty" : "tolerance", j.wall_seconds, j.statement);
}

void print_benchmarks(const Ledger& benchmarks, const Judged& judged) {
  say("\nBenchmarks\n");
  int agree = 0;
  for (std::size_t i = 0; i < benchmarks.entries.size(); ++i) {
    const Entry& entry = benchmarks.entries[i];
    const std::string stands = agreement(entry, judged.entries[i]);
    if (stands == "agrees") ++agree;
    say("{}: {} ({}; {})\n  {}\n", entry.id, stands, entry.kind, entry.where, entry.states);
    if (!entry.conditions.empty()) say("  conditions: {}\n", entry.conditions);
    if (!entry.notes.empty()) say("  notes: {}\n", entry.notes);
    for (const Judgement& j : judged.entries[i]) print_agreement(j);
  }
  say("\n{} benchmarks, {} agree\n", benchmarks.entries.size(), agree);
}

void print_ledger(const Ledger& ledger, const Judged& judged) {
  for (std::size_t i = 0; i < ledger.entries.size(); ++i) {
    const Entry& entry = ledger.entries[i];
    say("{}: {} ({}, {})\n  {}\n", entry.id, engine::standing(entry, judged.entries[i]), entry.where,
        entry.kind, entry.states);
    if (!entry.conditions.empty()) say("  conditions: {}\n", entry.conditions);
    if (!entry.notes.empty()) say("  notes: {}\n", entry.notes);
    for (const Judgement& j : judged.entries[i]) print_judgement(j);
  }
  say("\n{} statements of {}: {}\n", ledger.entries.size(), ledger.citation,
      counts_in_words(engine::count_standings(ledger, judged)));
}

Json json_of(const Judgement& j) {
  Json one{{"case", j.case_id}, {"verdict", j.verdict}};
  if (!j.metric.empty()) {
    one.update({{"metric", j.metric},
                {"statement", j.statement},
                {"target_kind", j.target_kind},
                {"measured", j.measured},
                {"target", j.target},
                {"tolerance", j.tolerance},
                {"is_uncertainty", j.is_uncertainty},
                {"holds", j.outside ? "outside" : "within"},
                {"wall_seconds", j.wall_seconds}});
  }
  return one;
}

Json json_of(const Ledger& ledger, const Judged& judged) {
  Json claims = Json::array();
  for (std::size_t i = 0; i < ledger.entries.size(); ++i) {
    const Entry& entry = ledger.entries[i];
    Json all = Json::array();
    for (const Judgement& j : judged.entries[i]) all.push_back(json_of(j));
    claims.push_back({{"id", entry.id},
                      {"where", entry.where},
                      {"kind", entry.kind},
                      {"standing", engine::standing(entry, judged.entries[i])},
                      {"states", entry.states},
                      {"conditions", entry.conditions},
                      {"notes", entry.notes},
                      {"judged_by", entry.judged_by},
                      {"judgements", all}});
  }
  Json counts;
  const std::map<std::string, int> counted = engine::count_standings(ledger, judged);
  for (const std::string& one : engine::standings()) counts[one] = counted.at(one);
  return {{"citation", ledger.citation}, {"counts", counts}, {"claims", claims}};
}

// What results say about the paper, and about the benchmarks.
struct Ledgers {
  Ledger paper = engine::read_ledger(repository::references());
  Ledger benchmarks = engine::read_benchmarks(repository::references());
  Judged of_paper, of_benchmarks;

  explicit Ledgers(const std::vector<fs::path>& results)
      : of_paper(engine::judge_ledger(paper, results)),
        of_benchmarks(engine::judge_ledger(benchmarks, results)) {}

  std::string text() const {
    Json all = json_of(paper, of_paper);
    all["benchmarks"] = json_of(benchmarks, of_benchmarks)["claims"];
    return all.dump(2, ' ', false, Json::error_handler_t::replace);
  }
};

int claims_command(const std::vector<fs::path>& results, bool json) {
  const Ledgers ledgers(results);
  const Judged& judged = ledgers.of_paper;
  if (json) {
    say("{}\n", ledgers.text());
  } else {
    print_ledger(ledgers.paper, judged);
    print_benchmarks(ledgers.benchmarks, ledgers.of_benchmarks);
  }
  for (const std::string& one : judged.left_out) complain("{}", one);
  for (const std::string& one : judged.unreadable) complain("{}", one);
  return judged.unreadable.empty() ? exit_code::success : exit_code::input;
}

}  // namespace

std::string claims_json(const std::vector<fs::path>& results) { return Ledgers(results).text(); }

void add_claims_command(CLI::App& app, int& exit_code) {
  struct Options {
    std::vector<fs::path> results{"results"};
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* claims = app.add_subcommand(
      "claims", "what the paper states, which benchmarks there are, and what results say about both");
  claims->add_option("--results", options->results, "folders of result files; of a case the newest counts")
      ->expected(1, -1);
  claims->add_flag("--json", options->json, "print one JSON object");
  claims->footer("Example: veriflex claims --results build/release/results results");
  claims->callback([options, &exit_code] { exit_code = claims_command(options->results, options->json); });
}

}  // namespace veriflex
