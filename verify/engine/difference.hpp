/// What differs between two runs of the same cases: results before and after a change of the program, on two
/// machines, with two compilers.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/stored_result.hpp"

namespace veriflex::engine {

struct NumberChange {
  std::string name;
  double before, after;
  double relative;  // |after - before| over the larger of both; infinite where either is not finite
};

/// A check before and after; none where only the other run has it.
struct CheckChange {
  std::optional<StoredCheck> before, after;

  const StoredCheck& either() const { return after ? *after : *before; }
  bool verdict_changed() const;
  bool is_finding() const;           // before or after, and not the same
  bool requirement_changed() const;  // target or tolerance
  double margin_change() const;      // absolute; 0 where only one run has it
};

/// A column of a record.
struct RecordChange {
  std::string record, column;
  std::string what;       // why its numbers cannot be compared; empty: they are
  double relative = 0.0;  // largest change over the column's largest magnitude
};

struct ReferenceChange {
  std::string id, before,
      after;  // sha256 of its data; "none" where it has no data or stands in one run alone
};

struct SlowDown {
  double before, after;  // wall seconds
  std::string why;       // what makes the comparison an honest one
};

struct CaseDifference {
  std::string id;
  std::string verdict_before, verdict_after;
  std::string error_before, error_after;
  bool text_changed = false;
  std::vector<CheckChange> checks;  // those in which anything differs, in the order of the later run
  std::size_t same_checks = 0;
  std::vector<NumberChange> metrics;  // largest relative change first; counts of work among them
  std::size_t same_metrics = 0;       // bit for bit
  std::vector<std::string> lost_metrics, new_metrics;
  std::vector<RecordChange> records;
  std::size_t same_records = 0;
  std::vector<ReferenceChange> references;
  std::vector<std::string> plan, warnings;  // lines with "- " or "+ "
  std::optional<SlowDown> slow_down;
  std::vector<std::string> worse;  // new failures, new errors, lost checks, in words

  /// Everything but times, bit for bit.
  bool is_same() const;
};

struct RunDifference {
  std::vector<CaseDifference> cases;     // in both runs, by id
  std::vector<std::string> lost, added;  // ids
  std::vector<std::string> worse;        // of all cases, lost ones and new ones that fail among them

  bool is_same() const;
};

/// The columns of one record that are not the same, bit for bit, before and after.
std::vector<RecordChange> record_changes(const observe::Record& before, const observe::Record& after);

/// Of one case, or of two cases that are to be compared all the same. Times are left out (records `*_cost`,
/// and what reports seconds), and a slow-down is none but where repeats do not overlap, or where single runs
/// of the same machine and threads differ by more than half in wall and processor time.
CaseDifference difference(const StoredResult& before, const StoredResult& after);

/// Of two runs, by the ids of their results.
RunDifference difference(const std::vector<StoredResult>& before, const std::vector<StoredResult>& after);

}  // namespace veriflex::engine
