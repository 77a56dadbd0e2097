/// Which cases a command is about.
#pragma once

#include <string>
#include <vector>

#include "engine/case.hpp"

namespace veriflex {

struct Options;

/// Heads of the cases of options.case_folder that are of the tier and topic asked for; all without these.
/// What cannot be read is of every tier and of no topic.
std::vector<engine::CaseHead> heads_chosen(const Options& options);

/// The cases named: options.cases, where words with `*`, `?` or `[...]` stand for all ids of the folder that
/// they match (and that are of the tier and topic); without names, all of that tier and topic. Throws
/// InputError when there is none, or a pattern matches none.
std::vector<std::string> chosen_cases(const Options& options);

}  // namespace veriflex
