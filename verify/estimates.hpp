/// How long cases will take.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/case.hpp"

namespace veriflex {

struct Options;

/// What one run of a case will take, where its work is known before  [s].
std::optional<double> estimated_seconds(const engine::Case& c, int threads);

/// Of each case what it took when its result in options.out was made, else what its plan estimates  [s].
std::vector<std::optional<double>> expected_seconds(const std::vector<std::string>& names,
                                                    const Options& options);

}  // namespace veriflex
