/// What the command line says about itself: a new case, completion for a shell, the manual page.
#pragma once

#include <CLI/CLI.hpp>

namespace veriflex {

void add_new_command(CLI::App& app);

/// `completion` and the hidden `manual`, of all commands that `app` has when they run.
void add_describing_commands(CLI::App& app);

}  // namespace veriflex
