/// Rows of nodes that make their steps before all others, because a body is near them.
///
/// Whoever acts on single nodes must know their populations between two steps, when the rows beside have made
/// the step before too. So in a block of T steps his rows make all T ahead of the others, those beside them
/// T - 1, the next T - 2 and so on: nothing else need be known. The others then follow in any order that the
/// whole box could be made in, less what has been made.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fluid/blocking.hpp"

namespace veriflex::fluid {

class NearRows {
 public:
  /// Of a block of so many steps: around the rows that are touched now (y + rows z of each, any number of
  /// times), and those beside them, so that what touches them may move on a little.
  NearRows(const RowGrid& grid, std::span<const std::int64_t> touched, std::int64_t steps);

  std::int64_t steps() const { return steps_; }

  /// How many rows make at least one step ahead.
  std::int64_t count() const { return static_cast<std::int64_t>(rows_.size()); }

  /// Whether all of these make every step of the block ahead.
  bool cover(std::span<const std::int64_t> touched) const;

  /// Calls make(step, z, y_begin, y_end) for the rows that make that step ahead, by at most so many threads,
  /// with subnormal numbers taken as zero.
  void make(std::int64_t step, int threads, const MakeRows& make) const;

  /// The same of those of a plane's rows y_begin to y_end - 1 that do not.
  void make_others(std::int64_t step, std::int64_t z, std::int64_t y_begin, std::int64_t y_end,
                   const MakeRows& make) const;

 private:
  std::int64_t steps_of(std::int64_t row) const { return steps_of_row_[static_cast<std::size_t>(row)]; }

  RowGrid grid_;
  std::int64_t steps_;
  std::vector<std::int32_t> steps_of_row_;  // how many a row makes ahead, of all rows
  std::vector<std::int64_t> rows_;          // that make any, one plane after the other
};

}  // namespace veriflex::fluid
