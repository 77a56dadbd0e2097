/// The numbers of a run on the terminal.
#pragma once

#include <string>
#include <vector>

#include "observe/record.hpp"

namespace veriflex {

/// Metrics with all digits, a line each. Of a column in time the last, mean, least and largest value
/// (`.last`,
/// `.mean`, `.min` and `.max` of its name) share a line below these, with ten digits. The lines start with
/// `indent`.
void print_metrics(const std::vector<observe::Metric>& metrics, const std::string& indent);

/// Their names alone, in the order given, those of a column in time in one line again.
void print_names(const std::vector<observe::Metric>& metrics, const std::string& indent);

}  // namespace veriflex
