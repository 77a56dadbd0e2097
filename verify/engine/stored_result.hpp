/// A result file as plain values: what was measured and judged, for whoever compares or counts results.
#pragma once

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "observe/record.hpp"

namespace veriflex::engine {

/// A row of /checks.
struct StoredCheck {
  std::string metric, kind, statement, verdict, holds, reason, tolerance_text, reference, target_kind, source,
      claim;
  double measured, target, tolerance, error, margin;
  /// Half-widths; no numbers where a tolerance was stated, or the file is older than uncertainties.
  double uncertainty_reference = NAN, uncertainty_numerical = NAN, uncertainty_input = NAN;

  bool has_uncertainty() const { return !std::isnan(uncertainty_reference); }
};

struct StoredReference {
  std::string id, kind, source, sha256;
};

/// A line of a plan: what is built of a module and the memory of it, or why it is left out.
struct StoredPart {
  std::string module, text;
  bool is_built;
};

struct StoredResult {
  std::filesystem::path file;
  std::string id, case_id, variant, title, equation, driver, tier, verdict, outcome;
  std::string error_kind, error_message;  // empty unless the verdict is `error` or `skipped`
  std::int64_t findings;
  std::vector<std::string> topics, overrides, warnings;
  std::string case_text;
  std::vector<StoredPart> plan;
  std::vector<observe::Record> records;
  std::vector<observe::Metric> metrics;
  std::vector<observe::Metric> work;  // `work.<count>` and `built.<part>`: what the run did, and built
  std::vector<StoredCheck> checks;
  std::vector<StoredReference> references;

  std::string program, compiler, flags, build_type, machine, date;
  std::int64_t threads;
  double wall_seconds, cpu_seconds;  // of all phases
  std::vector<double> repeats;       // wall seconds of further runs, made for their time alone
};

/// Throws InputError for a file that is no result of this schema.
StoredResult read_result(const std::filesystem::path& file);

/// Results that can be read, and what is wrong with the others.
struct StoredRun {
  std::vector<StoredResult> results;
  std::vector<std::string> unreadable;
};
StoredRun read_results(const std::vector<std::filesystem::path>& files);

/// All `*.h5` of a folder that are not hidden, sorted. Throws InputError when it is no folder.
std::vector<std::filesystem::path> result_files(const std::filesystem::path& folder);

}  // namespace veriflex::engine
