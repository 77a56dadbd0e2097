/// `veriflex claims`: what the paper states, and what results say about it.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

namespace veriflex {

/// The command sets `exit_code` when it has run.
void add_claims_command(CLI::App& app, int& exit_code);

/// The ledger with what the result files of the folders say, as `veriflex claims --json` prints it. Files
/// that cannot be read are left out. Throws InputError for a folder that does not exist.
std::string claims_json(const std::vector<std::filesystem::path>& results);

}  // namespace veriflex
