#include "engine/ledger.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "engine/stored_result.hpp"
#include "io/file.hpp"

namespace veriflex::engine {

namespace fs = std::filesystem;

namespace {

// The checks of a result file that cite claims, as (claim, judgement). A run that ended in an error has none.
struct CitedChecks {
  fs::path file;
  std::string case_id, verdict, date, variant;
  std::vector<std::pair<std::string, Judgement>> checks;
};

CitedChecks read_checks(const fs::path& path) {
  const StoredResult result = read_result(path);
  CitedChecks read{path, result.id, result.verdict, result.date, result.variant, {}};
  for (const StoredCheck& check : result.checks) {
    std::istringstream cited(check.claim);
    for (std::string claim; cited >> claim;) {
      read.checks.emplace_back(
          claim, Judgement{result.id, check.verdict, check.metric, check.statement, check.target_kind,
                           check.measured, check.target, check.tolerance, check.holds == "outside",
                           check.has_uncertainty(), result.wall_seconds});
    }
  }
  return read;
}

std::vector<fs::path> all_files(const std::vector<fs::path>& folders) {
  std::vector<fs::path> files;
  for (const fs::path& folder : folders) {
    for (fs::path& file : result_files(folder)) files.push_back(std::move(file));
  }
  std::sort(files.begin(), files.end());
  return files;
}

// One result per case, the newest.
std::vector<CitedChecks> read_results(const std::vector<fs::path>& folders, Judged& judged) {
  std::vector<CitedChecks> cases;
  for (const fs::path& file : all_files(folders)) {
    try {
      CitedChecks read = read_checks(file);
      if (!read.variant.empty()) {
        judged.left_out.push_back(
            fmt::format("{}: left out, its case was changed by --set {}", read.file.string(), read.variant));
        continue;
      }
      const auto twin = std::find_if(cases.begin(), cases.end(),
                                     [&](const CitedChecks& c) { return c.case_id == read.case_id; });
      if (twin == cases.end()) {
        cases.push_back(std::move(read));
        continue;
      }
      if (twin->date < read.date) std::swap(*twin, read);
      judged.left_out.push_back(fmt::format("{}: left out, {} is a newer result of '{}'", read.file.string(),
                                            twin->file.string(), twin->case_id));
    } catch (const InputError& error) {
      judged.unreadable.emplace_back(error.what());
    }
  }
  std::sort(cases.begin(), cases.end(),
            [](const CitedChecks& a, const CitedChecks& b) { return a.case_id < b.case_id; });
  return cases;
}

void check_kind(const io::Table& s, const Entry& entry) {
  if (is_judged(entry.kind)) {
    if (!entry.judged_by.empty()) return;
    s.fail("judged_by", fmt::format("no case judges '{}'", entry.id),
           fmt::format("it is a {}, which a run can contradict", entry.kind),
           "Name the cases, or call it not-decidable or not-compared and say why in its notes");
  }
  const std::string kind = entry.kind == not_decidable ? "not decidable" : "not compared";
  if (!entry.judged_by.empty()) {
    s.fail("judged_by", fmt::format("cases judge '{}', which is {}", entry.id, kind),
           "nothing that a run measures speaks of it", "Choose another kind, or remove the cases");
  }
  if (entry.notes.empty()) {
    s.fail("kind", fmt::format("'{}' is {} without a reason", entry.id, kind),
           "a reader must see why no run judges it", "Say in its notes what is missing");
  }
}

}  // namespace

const std::vector<std::string>& claim_kinds() {
  static const std::vector<std::string> kinds{"published-number", "published-relation", "exact-law",
                                              "reading",          not_decidable,        not_compared};
  return kinds;
}

bool is_judged(const std::string& kind) { return kind != not_decidable && kind != not_compared; }

Ledger read_ledger(const fs::path& reference_folder) {
  const fs::path path = reference_folder / "claims" / "wu-qi-2014.toml";
  return read_ledger(io::parse_document(io::read_file(path), path.string()));
}

Ledger read_benchmarks(const fs::path& reference_folder) {
  const fs::path path = reference_folder / "claims" / "benchmarks.toml";
  return fs::exists(path) ? read_ledger(io::parse_document(io::read_file(path), path.string())) : Ledger{};
}

Ledger read_ledger(const io::Table& top) {
  top.integer("schema", 1, 1);
  Ledger ledger{top.text("citation", ""), top.place("citation"), {}};
  for (const io::Table& s : top.tables("claim")) {
    Entry entry{
        s.text("id"),        s.text("where"),          s.place("where"),    s.choice("kind", claim_kinds()),
        s.text("states"),    s.text("conditions", ""), s.text("notes", ""), s.texts("judged_by"),
        s.place("judged_by")};
    check_kind(s, entry);
    for (const Entry& other : ledger.entries) {
      if (other.id == entry.id) {
        s.fail("id", fmt::format("claim '{}' stands here twice", entry.id), "checks cite claims by their ids",
               "Rename one or join them");
      }
    }
    if (entry.id.find_first_of(" \t\n") != std::string::npos) {
      s.fail("id", fmt::format("the id '{}' has a space", entry.id), "results list ids with spaces between",
             "Use hyphens");
    }
    ledger.entries.push_back(std::move(entry));
  }
  top.finish();
  return ledger;
}

const Entry& find_entry(const Ledger& ledger, const std::string& id, const Place& asked_at) {
  std::vector<std::string> ids;
  for (const Entry& entry : ledger.entries) {
    if (entry.id == id) return entry;
    ids.push_back(entry.id);
  }
  const std::string near = nearest_name(id, ids);
  throw InputError(asked_at, fmt::format("the ledger has no claim '{}'", id),
                   ledger.citation.empty()
                       ? "benchmarks stand in reference/claims/benchmarks.toml"
                       : fmt::format("claims of {} stand in reference/claims", ledger.citation),
                   near.empty() ? "See veriflex claims" : fmt::format("Did you mean '{}'?", near));
}

Judged judge_ledger(const Ledger& ledger, const std::vector<fs::path>& results) {
  Judged judged;
  const std::vector<CitedChecks> cases = read_results(results, judged);
  for (const Entry& entry : ledger.entries) {
    std::vector<Judgement>& found = judged.entries.emplace_back();
    for (const CitedChecks& c : cases) {
      for (const auto& [claim, judgement] : c.checks) {
        if (claim == entry.id) found.push_back(judgement);
      }
    }
    for (const std::string& id : entry.judged_by) {
      if (std::any_of(found.begin(), found.end(), [&](const Judgement& j) { return j.case_id == id; }))
        continue;
      const auto run =
          std::find_if(cases.begin(), cases.end(), [&](const CitedChecks& c) { return c.case_id == id; });
      const bool failed = run != cases.end() && run->verdict == "error";
      Judgement none{};
      none.case_id = id;
      none.verdict = failed ? "error" : "not run";
      found.push_back(none);
    }
  }
  return judged;
}

std::string standing(const Entry& entry, const std::vector<Judgement>& judgements) {
  if (entry.kind == not_decidable) return "not decidable";
  const auto any = [&](const char* verdict) {
    return std::any_of(judgements.begin(), judgements.end(),
                       [&](const Judgement& j) { return j.verdict == verdict; });
  };
  if (any("fail") || any("error")) return "unsettled";
  if (any("pass") && any("finding")) return "refuted in part";
  if (any("finding")) return "refuted";
  return any("pass") ? "holds" : "not run";
}

const std::vector<std::string>& standings() {
  static const std::vector<std::string> all{"holds",         "refuted in part", "refuted",
                                            "not decidable", "not run",         "unsettled"};
  return all;
}

std::map<std::string, int> count_standings(const Ledger& ledger, const Judged& judged) {
  std::map<std::string, int> counts;
  for (const std::string& one : standings()) counts[one] = 0;
  for (std::size_t i = 0; i < ledger.entries.size(); ++i)
    ++counts[standing(ledger.entries[i], judged.entries[i])];
  return counts;
}

}  // namespace veriflex::engine
