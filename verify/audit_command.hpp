/// The command `veriflex audit`: how much the checks are worth.
#pragma once

#include <CLI/CLI.hpp>

namespace veriflex {

/// Sets `exit_code` when it has run: 0, or 2 where a result or a case could not be read. What it lists is for
/// people to look at and no failure.
void add_audit_command(CLI::App& app, int& exit_code);

}  // namespace veriflex
