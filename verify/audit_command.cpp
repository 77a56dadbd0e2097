#include "audit_command.hpp"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/say.hpp"
#include "engine/audit.hpp"
#include "engine/baseline.hpp"
#include "exit_code.hpp"
#include "io/file.hpp"
#include "repository.hpp"
#include "run_cases.hpp"
#include "studies/studies.hpp"

namespace veriflex {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;
using engine::AuditedCheck;
using engine::AuditNote;

struct AuditOptions {
  std::string results = "results";
  std::vector<std::string> against;
  bool json = false;
};

std::vector<engine::StoredResult> read_all(const std::string& folder, int& code) {
  engine::StoredRun run = engine::read_results(engine::result_files(folder));
  for (const std::string& message : run.unreadable) {
    complain("{}", message);
    code = exit_code::input;
  }
  return std::move(run.results);
}

std::vector<fs::path> documents(const fs::path& folder) {
  std::vector<fs::path> all;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".toml") all.push_back(entry.path());
  }
  std::sort(all.begin(), all.end());
  return all;
}

engine::AuditOfCases audit_repository(int& code) {
  std::vector<engine::Case> cases;
  const engine::Readers readers = studies::readers();
  for (const fs::path& path : documents(repository::cases())) {
    try {
      cases.push_back(engine::read_case(path, {}, readers, repository::references()));
      engine::compare_with_baseline(cases.back(), repository::cases(), repository::references());
    } catch (const InputError& error) {
      complain("{}", error.what());
      code = exit_code::input;
    }
  }
  return engine::audit(cases, documents(repository::references()),
                       engine::read_ledger(repository::references()));
}

void print(const char* title, const std::vector<AuditedCheck>& checks) {
  say("\n{} ({})\n", title, checks.size());
  if (checks.empty()) return;
  say("  {:<36} {:<40} {:>9} {:>9} {:>9} {:>9}  {}\n", "case", "metric", "error", "spread", "tolerance",
      "margin", "reason of the tolerance");
  for (const AuditedCheck& c : checks) {
    say("  {:<36} {:<40} {:>9.2g} {:>9} {:>9.2g} {:>9.2g}  {}\n", c.id, c.check.metric, c.check.error,
        c.spread ? fmt::format("{:.2g}", *c.spread) : "-", c.check.tolerance, c.check.margin, c.check.reason);
  }
}

void print(const char* title, const std::vector<AuditNote>& notes) {
  say("\n{} ({})\n", title, notes.size());
  for (const AuditNote& note : notes) say("  {:<60} {}\n", note.what, note.why);
}

Json json_of(const std::vector<AuditedCheck>& checks) {
  Json all = Json::array();
  for (const AuditedCheck& c : checks) {
    all.push_back({{"id", c.id},
                   {"metric", c.check.metric},
                   {"statement", c.check.statement},
                   {"verdict", c.check.verdict},
                   {"holds", c.check.holds},
                   {"error", c.check.error},
                   {"spread", c.spread ? Json(*c.spread) : Json(nullptr)},
                   {"tolerance", c.check.tolerance},
                   {"tolerance_text", c.check.tolerance_text},
                   {"margin", c.check.margin},
                   {"reason", c.check.reason},
                   {"target_kind", c.check.target_kind}});
  }
  return all;
}

Json json_of(const std::vector<AuditNote>& notes) {
  Json all = Json::array();
  for (const AuditNote& note : notes) all.push_back({{"what", note.what}, {"why", note.why}});
  return all;
}

int audit_command(const AuditOptions& asked) {
  int code = exit_code::success;
  const std::vector<engine::StoredResult> results = read_all(asked.results, code);
  std::vector<engine::StoredResult> others;
  for (const std::string& folder : asked.against) {
    for (engine::StoredResult& one : read_all(folder, code)) others.push_back(std::move(one));
  }
  const engine::AuditOfResults seen = engine::audit(results, others);
  const engine::AuditOfCases said = audit_repository(code);
  if (asked.json) {
    print_json({{"checks", json_of(seen.all)},
                {"loose", json_of(seen.loose)},
                {"close", json_of(seen.close)},
                {"noisy", json_of(seen.noisy)},
                {"exact", seen.exact},
                {"without_reason", json_of(said.without_reason)},
                {"own_targets", json_of(said.own_targets)},
                {"without_question", json_of(said.without_question)},
                {"unused_references", json_of(said.unused)},
                {"undecided_claims", json_of(said.undecided)}});
    return code;
  }
  say("{}: {} results, {} checks, {} of them exact\n", asked.results, results.size(), seen.all.size(),
      seen.exact);
  print("every check", seen.all);
  print("tolerances more than 100 times looser than what was observed", seen.loose);
  print("errors within 3 times of their tolerance", seen.close);
  if (!asked.against.empty()) print("spreads between runs within 3 times of the tolerance", seen.noisy);
  print("tolerances without a reason of their own", said.without_reason);
  print("checks whose target this program made", said.own_targets);
  print("cases with neither a claim nor an equation", said.without_question);
  print("references without a case", said.unused);
  print("entries of the ledger without a case", said.undecided);
  return code;
}

}  // namespace

void add_audit_command(CLI::App& app, int& exit_code) {
  const auto asked = std::make_shared<AuditOptions>();
  CLI::App* audit = app.add_subcommand(
      "audit", "how much checks are worth: margins, loose and close tolerances, what nothing judges");
  audit->add_option("results", asked->results, "folder of result files")->capture_default_str();
  audit
      ->add_option(
          "--against", asked->against,
          "folder of results of the same cases with other threads, compiler or machine; may be repeated")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  audit->add_flag("--json", asked->json,
                  "print a JSON object: checks, loose, close, noisy, exact, without_reason, own_targets, "
                  "without_question, unused_references, undecided_claims");
  audit->footer("Example: veriflex audit results --against results-one-thread");
  audit->callback([asked, &exit_code] { exit_code = audit_command(*asked); });
}

}  // namespace veriflex
