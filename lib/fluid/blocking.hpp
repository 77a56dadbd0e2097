/// Several steps of a fluid at once, so that what is read from memory serves all of them.
///
/// A row of nodes may make a step as soon as the rows beside it, round the box's edges too, have made the
/// step before. So rows are taken in tiles, one after the other. Within a tile a front moves along z: the
/// first step of the block is made at the front, each further step one plane behind the one before, and the
/// planes between stay in the cache. A tile is one row further down with each step, into what the tile before
/// has left; the first shrinks from both sides instead, and what it and the last leave around the box's edge
/// is a tile of its own at the end. Threads have slabs of planes that shrink from both sides too, and then
/// fill in what is left between them.
#pragma once

#include <cstdint>
#include <functional>

namespace veriflex::fluid {

/// How many steps are made at once, by tiles of how many rows.
struct Blocking {
  std::int64_t steps;
  std::int64_t rows;
};

/// Rows of a box: so many in each plane, so many planes.
struct RowGrid {
  std::int64_t rows, planes;
};

/// What the largest cache holds of rows of so many bytes, with so many threads: a step at a time where that
/// is the whole box, or where the box is too thin to be divided.
Blocking blocking_for(const RowGrid& grid, std::int64_t row_bytes, int threads);

/// Makes step `step` of the rows y_begin to y_end - 1 of plane z.
using MakeRows =
    std::function<void(std::int64_t step, std::int64_t z, std::int64_t y_begin, std::int64_t y_end)>;

/// Steps 0 to steps - 1 of all rows, `blocking.steps` at once or fewer, by at most so many threads, with
/// subnormal numbers taken as zero. Once a stop is asked for the rest is left as it is.
void make_steps(const RowGrid& grid, std::int64_t steps, const Blocking& blocking, int threads,
                const MakeRows& make);

}  // namespace veriflex::fluid
