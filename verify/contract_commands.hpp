/// The commands about what is promised: `veriflex info`, `validate`, `claims` and `accept`.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace veriflex {

/// The commands set `exit_code` when they have run.
void add_contract_commands(CLI::App& app, int& exit_code);

/// The ledger with what the result files of a folder say, as `veriflex claims --json` prints it. Messages
/// about files that cannot be read are added to `problems`.
std::string claims_json(const std::string& results, std::vector<std::string>& problems);

}  // namespace veriflex
