/// The commands about bond laws: `veriflex derive` and `veriflex calibrate`.
#pragma once

#include <CLI/CLI.hpp>

namespace veriflex {

void add_derive_command(CLI::App& app);
void add_calibrate_command(CLI::App& app);

}  // namespace veriflex
