/// Ledgers: what the paper states, entry by entry, and what is known of systems that others have solved or
/// measured, and which cases judge it. Verdicts never stand in a ledger: they are found in result files.
/// Schema: reference/README.md.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "io/document.hpp"

namespace veriflex::engine {

/// Kinds of statement: `published-number`, `published-relation`, `exact-law`, `reading` (a number that we
/// read into a sentence without one), and two that no case judges and that say why in their notes: what no
/// run could contradict (a definition, a choice, a sketch, history, words without a number), and what no case
/// is held against yet.
const std::vector<std::string>& claim_kinds();
inline const std::string not_decidable = "not-decidable";
inline const std::string not_compared = "not-compared";

/// Whether a case can judge an entry of that kind.
bool is_judged(const std::string& kind);

struct Entry {
  std::string id;
  std::string where;  // in the paper; without one it begins with a citation
  Place where_at;
  std::string kind;                    // one of claim_kinds()
  std::string states;                  // what is stated there
  std::string conditions;              // under which; empty if none are given
  std::string notes;                   // errata, and why it is not decidable
  std::vector<std::string> judged_by;  // ids of cases; none if and only if none can judge it
  Place judged_by_at;
};

struct Ledger {
  std::string citation;  // of the paper; empty where each entry has its own
  Place citation_at;
  std::vector<Entry> entries;
};

/// The ledger `claims/wu-qi-2014.toml` of a reference folder, and that of the benchmarks,
/// `claims/benchmarks.toml`; without such a file one without entries. Throw InputError.
Ledger read_ledger(const std::filesystem::path& reference_folder);
Ledger read_benchmarks(const std::filesystem::path& reference_folder);

/// The same of a document. Throws InputError: also for an id that stands there twice, for an entry that could
/// be judged and names no case, and for one that none can judge and names some or does not say why.
Ledger read_ledger(const io::Table& top);

/// The entry of that id. Throws InputError at `asked_at`, with the nearest id suggested.
const Entry& find_entry(const Ledger& ledger, const std::string& id, const Place& asked_at);

/// What one check of a result file found out about an entry.
struct Judgement {
  std::string case_id;
  std::string verdict;  // of the check: pass, fail or finding; "error" or "not run" of the case
  std::string metric, statement, target_kind;
  double measured, target, tolerance;
  bool outside;         // the statement holds beyond the tolerance of the target
  bool is_uncertainty;  // the tolerance is the combined uncertainty
  double wall_seconds;  // of the case
};

/// What result files say about the ledger.
struct Judged {
  std::vector<std::vector<Judgement>> entries;  // one list per entry, the cases in the order of their ids
  std::vector<std::string> unreadable;          // a message per file that cannot be read
  std::vector<std::string> left_out;            // a message per file that does not count
};

/// Of all result files of the folders. Cases of `judged_by` without a result are "not run". Of a case that
/// stands in several folders the newest result counts; runs with overrides never do. Throws InputError for a
/// folder that does not exist.
Judged judge_ledger(const Ledger& ledger, const std::vector<std::filesystem::path>& results);

/// Where an entry stands after its checks: "holds", "refuted", "refuted in part" (some checks hold, some
/// refute it), "not decidable", "not run" (also where no case is held against it yet), or "unsettled" when a
/// case that judges it failed or ended in an error.
std::string standing(const Entry& entry, const std::vector<Judgement>& judgements);

/// All standings, in the order in which they are counted.
const std::vector<std::string>& standings();

/// How many entries stand how; every standing is a key.
std::map<std::string, int> count_standings(const Ledger& ledger, const Judged& judged);

}  // namespace veriflex::engine
