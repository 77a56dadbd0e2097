/// The case over a grid of its own keys: one row per run.
#pragma once

#include "engine/case.hpp"
#include "studies/rows.hpp"

namespace veriflex::studies {

/// Of `[sweep]`: `axes`, `timed`. Records `sweep` (a row per run), `sweep_cost`, `orders_along_<axis>` for
/// each axis of numbers from coarse to fine, and the declared records of the last run that came to its end.
engine::Study read_sweep(const io::Table& table, const std::vector<io::Table>& checks, const Base& base,
                         engine::Study measure, const Workspace& workspace);

}  // namespace veriflex::studies
