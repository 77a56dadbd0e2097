#include "fluid/near_rows.hpp"

#include <algorithm>

#include "base/stop.hpp"
#include "fluid/subnormals.hpp"

namespace veriflex::fluid {

NearRows::NearRows(const RowGrid& grid, std::span<const std::int64_t> touched, std::int64_t steps)
    : grid_(grid), steps_(steps), steps_of_row_(static_cast<std::size_t>(grid.rows * grid.planes), 0) {
  const auto reach = [this](std::int64_t row, std::int64_t made) {
    std::int32_t& known = steps_of_row_[static_cast<std::size_t>(row)];
    if (known != 0) return;
    known = static_cast<std::int32_t>(made);
    rows_.push_back(row);
  };
  for (const std::int64_t row : touched) reach(row, steps + 1);
  // Rows stand in the list in the order of their distance, so that each is reached by the shortest way.
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const std::int64_t made = steps_of(rows_[i]) - 1;
    if (made == 0) break;
    const std::int64_t y = rows_[i] % grid.rows, z = rows_[i] / grid.rows;
    for (std::int64_t dz = -1; dz <= 1; ++dz) {
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        reach((y + dy + grid.rows) % grid.rows + grid.rows * ((z + dz + grid.planes) % grid.planes), made);
      }
    }
  }
  std::sort(rows_.begin(), rows_.end());
}

bool NearRows::cover(std::span<const std::int64_t> touched) const {
  return std::all_of(touched.begin(), touched.end(),
                     [this](std::int64_t row) { return steps_of(row) >= steps_; });
}

void NearRows::make(std::int64_t step, int threads, const MakeRows& make) const {
#pragma omp parallel num_threads(threads) if (threads > 1)
  {
    const FlushSubnormals flush;
#pragma omp for schedule(static)
    for (std::int64_t part = 0; part < threads; ++part) {
      const std::int64_t end = count() * (part + 1) / threads;
      for (std::int64_t i = count() * part / threads; i < end && !stop::asked();) {
        const std::int64_t row = rows_[static_cast<std::size_t>(i)], z = row / grid_.rows;
        const std::int64_t last = std::min(row + end - i, grid_.rows * (z + 1));
        std::int64_t next = row;
        while (next < last && rows_[static_cast<std::size_t>(i)] == next && steps_of(next) > step) {
          ++next, ++i;
        }
        if (next > row)
          make(step, z, row - grid_.rows * z, next - grid_.rows * z);
        else
          ++i;
      }
    }
  }
}

void NearRows::make_others(std::int64_t step, std::int64_t z, std::int64_t y_begin, std::int64_t y_end,
                           const MakeRows& make) const {
  for (std::int64_t y = y_begin; y < y_end;) {
    const std::int64_t from = y;
    while (y < y_end && steps_of(y + grid_.rows * z) <= step) ++y;
    if (y > from) make(step, z, from, y);
    while (y < y_end && steps_of(y + grid_.rows * z) > step) ++y;
  }
}

}  // namespace veriflex::fluid
