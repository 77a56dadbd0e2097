/// What cases will take, and what their offers were seen to cost.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/case.hpp"

namespace veriflex {

struct Options;

/// What a case will take, where the work of its run, or of each of its runs, is known before  [s].
std::optional<double> estimated_seconds(const engine::Case& c, const Options& options);

/// Of each case what it took when its result in options.out was made, else what its plan estimates  [s].
std::vector<std::optional<double>> expected_seconds(const std::vector<std::string>& names,
                                                    const Options& options);

/// By how much each offer of a case moved its metrics, at most and over the largest of their kind, in the
/// ablations of it whose results stand in options.out.
std::map<std::string, double> moved_by_offers(const std::string& id, const Options& options);

}  // namespace veriflex
