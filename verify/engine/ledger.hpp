/// The ledger of claims: what the paper states, entry by entry, and which cases judge it. Verdicts never
/// stand in the ledger: they are found in result files. Schema: reference/README.md.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "io/document.hpp"

namespace veriflex::engine {

struct Entry {
  std::string id;
  std::string where;                   // in the paper
  std::string states;                  // what is stated there
  std::string conditions;              // under which; empty if none are given
  std::string notes;                   // errata, and what is not known
  std::vector<std::string> judged_by;  // ids of cases; none: not yet judged
  Place judged_by_at;
};

struct Ledger {
  std::string citation;
  Place citation_at;
  std::vector<Entry> entries;
};

/// The ledger `claims/wu-qi-2014.toml` of a reference folder. Throws InputError.
Ledger read_ledger(const std::filesystem::path& reference_folder);

/// The same of a document. Throws InputError: also for an id that stands there twice.
Ledger read_ledger(const io::Section& top);

/// The entry of that id. Throws InputError at `asked_at`, with the nearest id suggested.
const Entry& find_entry(const Ledger& ledger, const std::string& id, const Place& asked_at);

/// What one check of a result file found out about an entry.
struct Judgement {
  std::string case_id;
  std::string verdict;  // of the check: pass, fail or finding; "error" or "not run" of the case
  std::string metric, statement;
  double measured, target;
};

/// Per entry, what the result files of `results` say, the cases in the order of their ids. Cases of
/// `judged_by` without a result file are "not run". A file that cannot be read adds a message to `problems`.
std::vector<std::vector<Judgement>> judgements(const Ledger& ledger, const std::filesystem::path& results,
                                               std::vector<std::string>& problems);

}  // namespace veriflex::engine
