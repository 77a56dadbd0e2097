/// The command `veriflex diff`: what two runs say differently.
#pragma once

#include <CLI/CLI.hpp>

namespace veriflex {

/// Sets `exit_code` when it has run: 0 nothing is worse, 1 something is, 2 a result could not be read.
void add_diff_command(CLI::App& app, int& exit_code);

}  // namespace veriflex
