/// What each part of a case does: runs without it, or with another in its place, beside the run as it stands.
#pragma once

#include "engine/case.hpp"
#include "studies/rows.hpp"

namespace veriflex::studies {

/// Of `[ablate]`: `[[ablate.variants]]` with `name`, `without` (keys or tables that are removed) and `set`
/// (values that are put in), `timed`. Records `ablate` (a row per variant, the case itself first),
/// `ablate_difference` (how far each metric is moved) and `ablate_cost`.
engine::Study read_ablate(const io::Table& table, const std::vector<io::Table>& checks, const Base& base,
                          engine::Study measure, const Workspace& workspace);

}  // namespace veriflex::studies
