/// The case over a grid of its own keys: one row per run.
#pragma once

#include "engine/case.hpp"
#include "studies/rows.hpp"

namespace veriflex::studies {

/// Of `[sweep]`: `axes`, `timed`, `repeats`, `error`, `reference`, `work`. Records `sweep` (a row per run),
/// `sweep_cost`, `orders_along_<axis>` for each axis of numbers from coarse to fine, the declared records of
/// the last run that came to its end and, with `error`, those of front_records().
engine::Study read_sweep(const io::Table& table, const std::vector<io::Table>& checks, const Base& base,
                         engine::Study measure, const Workspace& workspace);

}  // namespace veriflex::studies
