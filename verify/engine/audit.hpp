/// How much checks are worth: tolerances beside what was observed, and what nothing judges.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/case.hpp"
#include "engine/ledger.hpp"
#include "engine/stored_result.hpp"

namespace veriflex::engine {

/// A check of a result, and how far other runs of the same case (threads, compilers, machines) measured
/// apart.
struct AuditedCheck {
  std::string id;
  StoredCheck check;
  std::optional<double> spread;  // largest |measured - measured elsewhere|; none without another run of it

  /// What the tolerance has to cover: the error, or the spread where that is more.
  double observed() const;
  /// How many times the tolerance is that; infinite for an error of exactly 0.
  double looseness() const;
};

/// What the results say. A finding has its own measure (recorded.relative) and is in none of the lists but
/// `all`.
struct AuditOfResults {
  std::vector<AuditedCheck> all;
  std::vector<AuditedCheck> loose;  // more than 100 times looser than what was observed, loosest first
  std::vector<AuditedCheck> close;  // the error within 3 times of the tolerance, closest first
  std::vector<AuditedCheck> noisy;  // the spread within 3 times of the tolerance
  std::size_t exact = 0;            // of checks with an error of exactly 0
};
AuditOfResults audit(const std::vector<StoredResult>& results, const std::vector<StoredResult>& others);

/// A check of a case: `case: metric`, and what is said about it.
struct AuditNote {
  std::string what, why;
};

/// What cases, references and ledger say, without any run.
struct AuditOfCases {
  std::vector<AuditNote>
      without_reason;                  // checks whose tolerance has none of its own: "", "none", "as above"
  std::vector<AuditNote> own_targets;  // checks whose target this program made
  std::vector<AuditNote> without_question;  // cases with neither a claim nor an equation
  std::vector<AuditNote> unused;            // references that no case is held against
  std::vector<AuditNote> undecided;         // entries of the ledger that no case judges
};
AuditOfCases audit(const std::vector<Case>& cases, const std::vector<std::filesystem::path>& references,
                   const Ledger& ledger);

}  // namespace veriflex::engine
