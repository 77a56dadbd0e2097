/// `veriflex show`: what a result file holds.
#pragma once

#include <CLI/CLI.hpp>

namespace veriflex {

void add_show_command(CLI::App& app);

}  // namespace veriflex
