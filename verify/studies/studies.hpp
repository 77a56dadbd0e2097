/// The studies over any case.
#pragma once

#include "engine/case.hpp"
#include "studies/rows.hpp"

namespace veriflex::studies {

/// The tables that make a case a study: `sweep`, `boundary`, `ablate`.
const std::vector<std::string>& tables();

/// Reads cases with all drivers, and with their studies, whose rows go to the workspace. Without one a case
/// can be looked at, not run.
engine::Readers readers(const Workspace& workspace = {});

/// Throws InputError where a case can be read, and no row of its study (of some, where there are many):
/// nothing reads a key of its axes, say.
void require_rows(const std::filesystem::path& path);

/// Reads the one run that a row of a study is: without the study and without checks.
engine::Readers readers_of_row();

}  // namespace veriflex::studies
