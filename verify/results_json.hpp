/// `results.json`: what the result files of a folder say, for programs. Interface:
/// verify/results.schema.json.
#pragma once

#include <filesystem>

namespace veriflex {

/// Writes `results.json` of all result files of a folder into `beside`, aside and renamed. Files that cannot
/// be read are listed with the reason. Throws OutputError.
void write_results_json(const std::filesystem::path& folder, const std::filesystem::path& beside);

}  // namespace veriflex
