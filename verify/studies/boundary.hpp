/// Where the outcome of a case changes along one of its keys.
#pragma once

#include "engine/case.hpp"
#include "studies/rows.hpp"

namespace veriflex::studies {

/// Of `[boundary]`: `key`, `from`, `to`, `points`, `scale`, `accuracy`, `criterion`, `axes`, `timed`. At each
/// combination of the axes the key is looked at in `points` places; the first change of the outcome from
/// `from` on is narrowed by bisection, all changes are counted: nothing is assumed beyond the places looked
/// at. Records `outcome_boundary` (a row per combination) and `outcome_boundary_rows` (a row per run).
engine::Study read_boundary(const io::Table& table, const std::vector<io::Table>& checks, const Base& base,
                            engine::Study measure, const Workspace& workspace);

}  // namespace veriflex::studies
