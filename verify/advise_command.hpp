/// The command that turns a stored sweep into a setting.
#pragma once

#include <CLI/CLI.hpp>

namespace veriflex {

/// `veriflex advise`.
void add_advise_command(CLI::App& app, int& exit_code);

}  // namespace veriflex
