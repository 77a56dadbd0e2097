/// Rows of a box that count their steps and notice one that is made too early or twice; and random whole
/// numbers to make boxes of.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <random>
#include <vector>

#include "fluid/blocking.hpp"

namespace veriflex::unit {

inline std::int64_t any(std::mt19937& random, std::int64_t least, std::int64_t most) {
  return std::uniform_int_distribution<std::int64_t>(least, most)(random);
}

class RowOrder {
 public:
  explicit RowOrder(const fluid::RowGrid& grid)
      : grid_(grid), made_(static_cast<std::size_t>(grid.rows * grid.planes)) {}

  /// Of any thread, as fluid::MakeRows is called.
  void make(std::int64_t step, std::int64_t z, std::int64_t y_begin, std::int64_t y_end) {
    if (y_begin < 0 || y_end > grid_.rows || z < 0 || z >= grid_.planes) ++out_of_order_;
    for (std::int64_t y = y_begin; y < y_end; ++y) {
      if (at(y, z) != step) ++out_of_order_;
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        for (std::int64_t dz = -1; dz <= 1; ++dz) {
          if (at(y + dy, z + dz) < step) ++out_of_order_;
        }
      }
      ++at(y, z);
    }
  }

  /// Steps of a row, round the edges of the box.
  std::atomic<std::int64_t>& at(std::int64_t y, std::int64_t z) {
    const auto wrapped = [](std::int64_t i, std::int64_t size) { return (i % size + size) % size; };
    return made_[static_cast<std::size_t>(wrapped(y, grid_.rows) + grid_.rows * wrapped(z, grid_.planes))];
  }

  int out_of_order() const { return out_of_order_; }
  bool all_have_made(std::int64_t steps) const {
    return std::all_of(made_.begin(), made_.end(), [&](const auto& count) { return count == steps; });
  }

 private:
  fluid::RowGrid grid_;
  std::vector<std::atomic<std::int64_t>> made_;
  std::atomic<int> out_of_order_ = 0;
};

}  // namespace veriflex::unit
