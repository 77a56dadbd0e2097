/// The commands about cases: `veriflex list`, `plan`, `run`, `verify` and `report`.
#pragma once

#include <CLI/CLI.hpp>

namespace veriflex {

/// The commands set `exit_code` when they have run: 0, or the first of 4, 2, 3, 1 that occurred.
void add_case_commands(CLI::App& app, int& exit_code);

}  // namespace veriflex
