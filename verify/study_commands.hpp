/// The commands that put a study over any case: `veriflex sweep`, `boundary`, `ablate` and `merge`.
#pragma once

#include <CLI/CLI.hpp>

namespace veriflex {

/// The commands set `exit_code` when they have run.
void add_study_commands(CLI::App& app, int& exit_code);

}  // namespace veriflex
