#include "engine/validate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "engine/baseline.hpp"
#include "engine/ledger.hpp"
#include "engine/symbols.hpp"
#include "io/file.hpp"

namespace veriflex::engine {

namespace fs = std::filesystem;

namespace {

// Messages in the order found, each once: several checks may name the same broken reference.
class Problems {
 public:
  void add(const std::string& message) {
    if (std::find(all_.begin(), all_.end(), message) == all_.end()) all_.push_back(message);
  }
  void add(const Place& place, const std::string& problem, const std::string& why,
           const std::string& suggestion) {
    add(InputError(place, problem, why, suggestion).what());
  }
  template <class Read>
  void attempt(Read read) {
    try {
      read();
    } catch (const std::exception& error) {
      add(error.what());
    }
  }
  const std::vector<std::string>& all() const { return all_; }

 private:
  std::vector<std::string> all_;
};

// Keys of the bibliography: what stands between `@kind{` and the first comma.
std::vector<std::string> bibliography_keys(const fs::path& reference_folder) {
  const std::string text = io::read_file(reference_folder / "bibliography.bib");
  std::vector<std::string> keys;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    const std::size_t brace = line.find('{');
    if (line.starts_with('@') && brace != std::string::npos) {
      keys.push_back(line.substr(brace + 1, line.find(',') - brace - 1));
    }
    at = end + 1;
  }
  return keys;
}

void check_citation(const std::string& citation, const Place& place, const std::vector<std::string>& keys,
                    Problems& problems) {
  const std::string key = citation.substr(0, citation.find_first_of(", "));
  if (std::find(keys.begin(), keys.end(), key) != keys.end()) return;
  const std::string near = nearest_name(key, keys);
  problems.add(place, fmt::format("the bibliography has no '{}'", key),
               "a citation begins with a key of reference/bibliography.bib, up to the first comma or space",
               near.empty() ? "Add the entry" : fmt::format("Did you mean '{}'?", near));
}

void check_citations(const Case& c, const std::vector<std::string>& keys, Problems& problems) {
  for (const std::string& source : c.sources) check_citation(source, c.sources_at, keys, problems);
  for (const Check& check : c.checks) {
    const bool published = check.target_kind.starts_with("published-") && !check.reference;
    if (published) check_citation(check.source, check.place, keys, problems);
  }
  for (const Reference& reference : c.references) {
    for (const std::string& one : reference.citations) {
      check_citation(one, reference.citations_at, keys, problems);
    }
  }
}

std::vector<fs::path> documents(const fs::path& folder) {
  std::vector<fs::path> all;
  std::error_code missing;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, missing)) {
    if (entry.path().extension() == ".toml") all.push_back(entry.path());
  }
  std::sort(all.begin(), all.end());
  return all;
}

std::vector<Case> check_cases(const std::vector<fs::path>& paths, const fs::path& case_folder,
                              const fs::path& reference_folder, const Readers& readers, Problems& problems) {
  std::vector<std::string> keys;
  problems.attempt([&] { keys = bibliography_keys(reference_folder); });
  std::vector<Case> cases;
  for (const fs::path& path : paths) {
    problems.attempt([&] {
      std::vector<InputError> found;
      const io::Table top = parse_case(io::read_file(path), path.string());
      cases.push_back(read_parts(top, path, readers, reference_folder, found));
      for (const InputError& error : found) problems.add(error.what());
      if (found.empty()) compare_with_baseline(cases.back(), case_folder, reference_folder);
      const bool own = fs::weakly_canonical(path).parent_path() == fs::weakly_canonical(case_folder);
      if (own && !keys.empty()) check_citations(cases.back(), keys, problems);
    });
  }
  return cases;
}

// A baseline is held against its case by `veriflex accept`, whether or not a check asks for it.
bool is_baseline_of(const Reference& reference, const std::vector<Case>& cases) {
  return reference.kind == "baseline" && std::any_of(cases.begin(), cases.end(), [&](const Case& c) {
           return reference.id == c.id + "-baseline";
         });
}

void check_references(const std::vector<Case>& cases, const fs::path& folder, Problems& problems) {
  std::set<std::string> used;
  for (const Case& c : cases) {
    for (const Reference& reference : c.references) used.insert(reference.id);
  }
  for (const fs::path& path : documents(folder)) {
    problems.attempt([&] {
      const Reference reference = read_reference(path);
      if (used.contains(reference.id) || is_baseline_of(reference, cases)) return;
      problems.add({path.string()}, "no case uses this reference", "nothing is ever held against it",
                   "Name it in a check or remove it");
    });
  }
}

void check_ledger(const std::vector<Case>& cases, const Ledger& ledger, const fs::path& reference_folder,
                  Problems& problems) {
  const std::vector<std::string> keys = bibliography_keys(reference_folder);
  if (!ledger.citation.empty()) check_citation(ledger.citation, ledger.citation_at, keys, problems);
  const auto cites = [](const Case& c, const Entry& entry) {
    return std::any_of(c.checks.begin(), c.checks.end(), [&](const Check& k) {
      return std::find(k.claims.begin(), k.claims.end(), entry.id) != k.claims.end();
    });
  };
  for (const Entry& entry : ledger.entries) {
    if (ledger.citation.empty() && entry.kind != "exact-law")
      check_citation(entry.where, entry.where_at, keys, problems);
    for (const std::string& id : entry.judged_by) {
      const auto found = std::find_if(cases.begin(), cases.end(), [&](const Case& c) { return c.id == id; });
      if (found == cases.end() || !cites(*found, entry)) {
        problems.add(entry.judged_by_at, fmt::format("'{}' does not judge '{}'", id, entry.id),
                     found == cases.end() ? "there is no such case" : "no check of that case cites the claim",
                     "Correct judged_by, or cite the claim in the case");
      }
    }
    for (const Case& c : cases) {
      const bool listed =
          std::find(entry.judged_by.begin(), entry.judged_by.end(), c.id) != entry.judged_by.end();
      if (cites(c, entry) && !listed) {
        problems.add(entry.judged_by_at, fmt::format("'{}' is missing in judged_by of '{}'", c.id, entry.id),
                     fmt::format("a check of {} cites the claim", c.path.string()), "Add it");
      }
    }
  }
}

}  // namespace

std::vector<std::string> problems_of(const std::vector<fs::path>& cases, const fs::path& case_folder,
                                     const fs::path& reference_folder, const Readers& readers) {
  Problems problems;
  check_cases(cases, case_folder, reference_folder, readers, problems);
  return problems.all();
}

std::vector<std::string> problems_of_repository(const fs::path& case_folder, const fs::path& reference_folder,
                                                const Readers& readers) {
  Problems problems;
  const std::vector<Case> cases =
      check_cases(documents(case_folder), case_folder, reference_folder, readers, problems);
  check_references(cases, reference_folder, problems);
  problems.attempt([&] { check_ledger(cases, read_ledger(reference_folder), reference_folder, problems); });
  problems.attempt(
      [&] { check_ledger(cases, read_benchmarks(reference_folder), reference_folder, problems); });
  return problems.all();
}

}  // namespace veriflex::engine
