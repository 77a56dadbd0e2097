/// `veriflex report`: the page about a folder of results.
#pragma once

#include <string>

namespace veriflex {

/// Draws the report of the folder `results` into the file `report` (empty: report.html among the results) and
/// prints the table of verdicts, as JSON if asked. Returns the exit code.
int report_command(const std::string& results, const std::string& report, bool json);

}  // namespace veriflex
