/// The tables of a study on the terminal.
#pragma once

#include "observe/record.hpp"

namespace veriflex {

/// Rows with their axes, outcome, some metrics (errors first) and run time; orders of those metrics;
/// boundaries. Nothing when these were not measured by a study.
void print_study(const observe::Observations& seen);

}  // namespace veriflex
