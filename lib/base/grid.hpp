/// A box of lattice nodes: its size, the number of a node, and the way round its edges.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

#include "base/mutant.hpp"

namespace veriflex {

/// Nodes stand at the integers 0 .. size - 1 along each axis; x is the fastest.
struct Grid {
  std::array<std::int64_t, 3> size;

  std::int64_t count() const { return size[0] * size[1] * size[2]; }

  std::int64_t index(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return x + size[0] * (y + size[1] * z);
  }

  std::array<std::int64_t, 3> node(std::int64_t index) const {
    return {index % size[0], index / size[0] % size[1], index / size[0] / size[1]};
  }

  /// `at` moved by one box length into the box; at most one box length outside.
  std::int64_t wrap(std::int64_t at, std::size_t axis) const {
    return at < 0             ? at + size[axis] - (planted(Mutant::wrap_one_short) ? 1 : 0)
           : at >= size[axis] ? at - size[axis]
                              : at;
  }
};

/// Calls visit(nodes) for all nodes of a box, some at a time and in order: what is asked of all at once may
/// take more memory than the fluid.
template <class Visit>
void in_parts(const Grid& grid, Visit visit) {
  constexpr std::int64_t at_once = 65536;
  std::vector<std::int64_t> nodes;
  for (std::int64_t from = 0; from < grid.count(); from += at_once) {
    nodes.resize(static_cast<std::size_t>(std::min(at_once, grid.count() - from)));
    std::iota(nodes.begin(), nodes.end(), from);
    visit(std::span<const std::int64_t>(nodes));
  }
}

}  // namespace veriflex
