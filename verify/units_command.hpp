/// `veriflex units`: the numbers of a case in lattice units and in SI, or the lattice's of a flow.
#pragma once

#include <CLI/CLI.hpp>

namespace veriflex {

void add_units_command(CLI::App& app);

}  // namespace veriflex
