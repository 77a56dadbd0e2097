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

/// The baseline of a result as a reference file. Throws InputError for a metric that is no number.
std::string baseline_text(const Result& result, const std::string& id, const std::string& reason,
                          const std::string& command);

}  // namespace veriflex::engine
