#include "engine/ledger.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "io/file.hpp"
#include "io/hdf5.hpp"

namespace veriflex::engine {

namespace fs = std::filesystem;

namespace {

// The checks of a result file that cite a claim, as (claim, judgement). A run that ended in an error has
// none.
struct CitedChecks {
  std::string case_id, verdict;
  std::vector<std::pair<std::string, Judgement>> checks;
};

CitedChecks read_checks(const fs::path& path) {
  const io::Hdf5File file(path);
  CitedChecks read{file.attribute("/", "id"), file.attribute("/", "verdict"), {}};
  const std::vector<std::string> claims = file.texts("/checks/claim");
  const std::vector<std::string> verdicts = file.texts("/checks/verdict");
  const std::vector<std::string> metrics = file.texts("/checks/metric");
  const std::vector<std::string> statements = file.texts("/checks/statement");
  const std::vector<double> measured = file.numbers("/checks/measured");
  const std::vector<double> targets = file.numbers("/checks/target");
  for (const std::size_t size :
       {verdicts.size(), metrics.size(), statements.size(), measured.size(), targets.size()}) {
    if (size != claims.size()) {
      throw InputError({path.string()}, "the columns of /checks differ in length",
                       "the file is not as its schema says", "Run the case again");
    }
  }
  for (std::size_t i = 0; i < claims.size(); ++i) {
    if (claims[i].empty()) continue;
    read.checks.emplace_back(
        claims[i], Judgement{read.case_id, verdicts[i], metrics[i], statements[i], measured[i], targets[i]});
  }
  return read;
}

}  // namespace

Ledger read_ledger(const fs::path& reference_folder) {
  const fs::path path = reference_folder / "claims" / "wu-qi-2014.toml";
  return read_ledger(io::parse_document(io::read_file(path), path.string()));
}

Ledger read_ledger(const io::Section& top) {
  top.integer("schema", 1, 1);
  Ledger ledger{top.text("citation"), top.place("citation"), {}};
  for (const io::Section& s : top.tables("claim")) {
    Entry entry{s.text("id"),        s.text("where"),      s.text("states"),    s.text("conditions", ""),
                s.text("notes", ""), s.texts("judged_by"), s.place("judged_by")};
    for (const Entry& other : ledger.entries) {
      if (other.id == entry.id) {
        s.fail("id", fmt::format("claim '{}' stands here twice", entry.id), "checks cite claims by their ids",
               "Rename one or join them");
      }
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
                   fmt::format("claims of {} stand in reference/claims", ledger.citation),
                   near.empty() ? "See veriflex claims" : fmt::format("Did you mean '{}'?", near));
}

std::vector<std::vector<Judgement>> judgements(const Ledger& ledger, const fs::path& results,
                                               std::vector<std::string>& problems) {
  std::vector<fs::path> files;
  std::error_code missing;
  for (const fs::directory_entry& entry : fs::directory_iterator(results, missing)) {
    if (entry.path().extension() == ".h5") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<CitedChecks> cases;
  for (const fs::path& file : files) {
    try {
      cases.push_back(read_checks(file));
    } catch (const InputError& error) {
      problems.emplace_back(error.what());
    }
  }
  std::vector<std::vector<Judgement>> all;
  for (const Entry& entry : ledger.entries) {
    std::vector<Judgement>& found = all.emplace_back();
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
      found.push_back({id, failed ? "error" : "not run", "", "", 0.0, 0.0});
    }
  }
  return all;
}

}  // namespace veriflex::engine
