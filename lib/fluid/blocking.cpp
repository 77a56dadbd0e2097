#include "fluid/blocking.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/memory.hpp"
#include "base/mutant.hpp"
#include "base/stop.hpp"
#include "fluid/subnormals.hpp"

namespace veriflex::fluid {

namespace {

struct Interval {
  std::int64_t begin, end;
};

/// What a block of so many steps takes off a tile or a slab that shrinks from both sides.
std::int64_t lost(std::int64_t steps) { return 2 * (steps - 1); }

/// The tiles of a block of steps.
class Tiles {
 public:
  Tiles(std::int64_t rows, std::int64_t steps, std::int64_t width) : rows_(rows) {
    // A first tile that is narrower would have to make rows that it had already left.
    const std::int64_t first = std::max(width, lost(steps));
    if (rows <= first) return;
    const std::int64_t others = (rows - first + width - 1) / width;
    for (std::int64_t i = 0; i <= others; ++i) ends_.push_back(first + (rows - first) * i / others);
  }

  std::size_t count() const { return ends_.empty() ? 1 : ends_.size() + 1; }

  /// Rows of a tile that make this step; those below 0 and from rows on are beyond the box's edge.
  Interval at(std::size_t tile, std::int64_t step) const {
    if (ends_.empty()) return {0, rows_};
    if (tile == 0) return {step, ends_[0] - step};
    if (tile == ends_.size()) return {rows_ - step, rows_ + step};
    return {ends_[tile - 1] - step + (planted(Mutant::tile_edge_left_out) ? 1 : 0), ends_[tile] - step};
  }

 private:
  std::int64_t rows_;
  std::vector<std::int64_t> ends_;  // of the tiles before the first step, but for the last; empty: one tile
};

/// Some steps of the tiles of a box, from step `from` on.
struct Block {
  const RowGrid& grid;
  const MakeRows& make;
  std::int64_t from, steps;
  Tiles tiles;

  void rows(std::size_t tile, std::int64_t step, std::int64_t z) const {
    const Interval y = tiles.at(tile, step);
    const std::int64_t plane = z < grid.planes ? z : z - grid.planes;
    const std::int64_t inside = std::min(y.end, grid.rows);
    if (y.begin < inside) make(from + step, plane, y.begin, inside);
    if (y.end > grid.rows) make(from + step, plane, 0, y.end - grid.rows);
  }

  /// Of planes `begin` to `end` - 1, less one more at both ends with each step.
  void shrinking(std::int64_t begin, std::int64_t end) const {
    for (std::size_t tile = 0; tile < tiles.count(); ++tile) {
      for (std::int64_t front = begin; front < end && !stop::asked(); ++front) {
        for (std::int64_t step = 0; step < steps && front - step >= begin + step; ++step) {
          rows(tile, step, front - step);
        }
      }
    }
  }

  /// What shrinking() has left of the planes on both sides of the edge below plane `edge`.
  void growing(std::int64_t edge) const {
    for (std::size_t tile = 0; tile < tiles.count(); ++tile) {
      for (std::int64_t front = edge; front < edge + lost(steps) && !stop::asked(); ++front) {
        for (std::int64_t step = (front - edge) / 2 + 1; step < steps; ++step) {
          rows(tile, step, front - step);
        }
      }
    }
  }
};

}  // namespace

Blocking blocking_for(const RowGrid& grid, std::int64_t row_bytes, int threads) {
  const Cache cache = largest_cache();
  if (grid.rows * grid.planes * row_bytes <= cache.bytes) return {1, grid.rows};
  // Other programs have their part of a cache.
  const double share = 0.6 * static_cast<double>(cache.bytes) / std::min(threads, cache.processors);
  const double held = share / static_cast<double>(row_bytes);
  // Memory moves 1/steps + 1/rows of what as many single steps would; wide tiles make longer pieces of
  // memory.
  const std::int64_t longest = lost(grid.planes) < 4 ? 1 : grid.planes / (2 * threads) + 1;
  const std::int64_t steps = std::clamp<std::int64_t>(std::llround(0.5 * std::sqrt(held)), 1, longest);
  return {steps, std::max<std::int64_t>(1, std::llround(held / static_cast<double>(steps)))};
}

void make_steps(const RowGrid& grid, std::int64_t steps, const Blocking& blocking, int threads,
                const MakeRows& make) {
  const std::int64_t longest = std::min(blocking.steps, grid.planes / 2 + 1);
  const std::int64_t blocks = (steps + longest - 1) / longest;
  const std::int64_t thinnest = std::max<std::int64_t>(1, lost(longest));
  const std::int64_t slabs = std::clamp<std::int64_t>(grid.planes / thinnest, 1, threads);
  const auto edge = [&](std::int64_t slab) { return grid.planes * slab / slabs; };
#pragma omp parallel num_threads(static_cast <int>(slabs))
  {
    const FlushSubnormals flush;
    for (std::int64_t i = 0; i < blocks; ++i) {
      const std::int64_t from = steps * i / blocks;
      const std::int64_t count = steps * (i + 1) / blocks - from;
      const Block block{grid, make, from, count, Tiles(grid.rows, count, blocking.rows)};
#pragma omp for schedule(static)
      for (std::int64_t slab = 0; slab < slabs; ++slab) block.shrinking(edge(slab), edge(slab + 1));
#pragma omp for schedule(static)
      for (std::int64_t slab = 0; slab < slabs; ++slab) block.growing(edge(slab + 1));
    }
  }
}

}  // namespace veriflex::fluid
