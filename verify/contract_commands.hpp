/// The commands about what is promised: `veriflex info`, `validate` and `accept`.
#pragma once

#include <CLI/CLI.hpp>

namespace veriflex {

/// The commands set `exit_code` when they have run.
void add_contract_commands(CLI::App& app, int& exit_code);

}  // namespace veriflex
