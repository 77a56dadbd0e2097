/// Baselines: what a case measured when somebody accepted it, to be held against later results.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/reference.hpp"
#include "engine/result.hpp"

namespace veriflex::engine {

/// One metric in the earlier baseline and in the new result; none where one of them lacks it.
struct Change {
  std::string metric;
  std::optional<double> earlier, now;
};

/// Every metric of either, those of the result first.
std::vector<Change> changes(const Reference& earlier, const observe::Observations& now);

/// Whether any metric has another value, or stands in one of them only.
bool differ(const std::vector<Change>& changes);

/// What a baseline keeps of a study of many runs: its table, without what each row cost and why it failed.
/// Nothing for any other case.
std::optional<observe::Record> table_to_keep(const Result& result);

/// Where the baseline of a case stands: among the references for a case of the repository, else beside it.
std::filesystem::path baseline_path(const Case& c, const std::filesystem::path& case_folder,
                                    const std::filesystem::path& reference_folder);

/// Adds a check per value of the case's baseline, if it has one, within the tolerance that the baseline
/// states, and one per column of its table; none for a metric that a check of the case already holds against
/// it, and none for a case changed by `--set`. Throws InputError for a baseline that cannot be read, or with
/// a metric that is no longer measured.
void compare_with_baseline(Case& c, const std::filesystem::path& case_folder,
                           const std::filesystem::path& reference_folder);

/// The baseline of a result as a reference file; the tolerance is that of `earlier`, if there is one. Throws
/// InputError for a metric that is no number, and when the text, read back, does not give what was measured.
std::string baseline_text(const Result& result, const std::filesystem::path& path, const std::string& reason,
                          const std::string& command, const std::optional<Reference>& earlier);

}  // namespace veriflex::engine
