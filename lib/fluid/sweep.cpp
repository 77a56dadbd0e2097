#include "fluid/sweep.hpp"

#include <omp.h>

#include <algorithm>

#include "base/mutant.hpp"
#include "base/stop.hpp"
#include "fluid/lanes.hpp"
#include "fluid/subnormals.hpp"
#include "fluid/threads.hpp"
#include "fluid/unroll.hpp"

namespace veriflex::fluid {

namespace {

constexpr int cx(int q) { return c[static_cast<std::size_t>(q)][0]; }

/// The rows that one row of nodes reads and writes: population q comes from slot[q] and leaves into
/// slot[opposite q].
template <class Real>
struct Row {
  Real* slot[Q];
  Real* ends;         // this row's part of Lattice::ends
  unsigned back = 0;  // bit q: population q comes back from a wall beside the row, from the same node
};

template <class Real, int lanes, bool odd, bool closed>
struct Step {
  using L = Lanes<Real, static_cast<std::size_t>(lanes)>;
  using V = typename L::Type;
  /// Asks for what the sweep reads next: an even step reads each array line by line, an odd one turns at the
  /// ends of its rows, and fifteen such streams are more than prefetchers follow. Into the first-level cache
  /// not more than a row ahead, it can wait for few lines at a time; the second-level cache waits for the
  /// memory. On a fast memory 0.8 -> 0.9 of its limit.
  [[gnu::always_inline]] static inline void ask_ahead(const Real* at) {
    constexpr std::int64_t line = 64 / sizeof(Real);
    if constexpr (odd) {
      __builtin_prefetch(at + 4 * line, 0, 3);
      __builtin_prefetch(at + 64 * line, 0, 2);
    } else {
      __builtin_prefetch(at + 8 * line, 0, 2);
    }
  }

  /// Vector i of the row; `first` and `last` tell whether it stands at an end, `beside` whether a wall is
  /// beside the row.
  template <class Force, bool beside, bool first, bool last>
  [[gnu::always_inline]] static inline void nodes(const Collision<Real>& law, const Row<Real>& row,
                                                  std::int64_t i, std::int64_t n) {
    V h[Q];
    for_each_population([&](auto q) __attribute__((always_inline)) {
      constexpr int shift = odd ? cx(q) : 0;
      constexpr bool wraps = (shift == 1 && first) || (shift == -1 && last);
      if (!wraps || (beside && (row.back >> q & 1U) != 0)) {
        const Real* const at = row.slot[q] + (i - shift) * lanes;
        ask_ahead(at);
        h[q] = L::load(at);
      } else {
        const Real* const at = row.slot[q] + (shift == 1 ? n - 1 : 0) * lanes;
        ask_ahead(at);
        h[q] = shift == 1 ? (planted(Mutant::row_end_not_turned) ? L::load(at) : L::up(L::load(at)))
                          : L::down(L::load(at));
      }
      if constexpr (closed && cx(q) == 1 && first)
        L::set(h[q], 0, planted(Mutant::wall_ends_ignored) ? Real(0) : row.ends[end_of_row(q)]);
      if constexpr (closed && cx(q) == -1 && last) L::set(h[q], lanes - 1, row.ends[end_of_row(q)]);
    });
    collide<Force>(law, h);
    for_each_population([&](auto q) __attribute__((always_inline)) {
      constexpr int p = opposite(q);
      constexpr int shift = odd ? cx(q) : 0;
      constexpr bool wraps = (shift == 1 && first) || (shift == -1 && last);
      if constexpr (closed && cx(q) == 1 && first) row.ends[end_of_row(q)] = L::get(h[p], 0);
      if constexpr (closed && cx(q) == -1 && last) row.ends[end_of_row(q)] = L::get(h[p], lanes - 1);
      if (!wraps || (beside && (row.back >> q & 1U) != 0)) {
        L::store(row.slot[q] + (i - shift) * lanes, h[p]);
      } else {
        L::store(row.slot[q] + (shift == 1 ? n - 1 : 0) * lanes, shift == 1 ? L::down(h[p]) : L::up(h[p]));
      }
    });
  }

  /// `law` by value: no store of a population can change it then.
  template <class Force, bool beside>
  [[gnu::noinline]] static void along(const Collision<Real> law, const Row<Real>& row, std::int64_t n) {
    if constexpr (!odd && !closed) {  // nothing crosses the ends of a row
      for (std::int64_t i = 0; i < n; ++i) nodes<Force, beside, false, false>(law, row, i, n);
    } else {
      if constexpr (lanes == 1) {
        if (n == 1) return nodes<Force, beside, true, true>(law, row, 0, 1);
      }
      nodes<Force, beside, true, false>(law, row, 0, n);
      for (std::int64_t i = 1; i < n - 1; ++i) nodes<Force, beside, false, false>(law, row, i, n);
      nodes<Force, beside, false, true>(law, row, n - 1, n);
    }
  }

  static std::int64_t wrap(std::int64_t at, std::int64_t size) {
    return at < 0 ? at + size : at >= size ? at - size : at;
  }

  static Row<Real> row_at(const Lattice<Real>& lattice, std::int64_t y, std::int64_t z) {
    Row<Real> row;
    row.ends = closed ? lattice.ends + ends_per_row * (y + lattice.ny * z) : nullptr;
    if constexpr (!odd) {
      const std::int64_t here = lattice.row(y, z);
      for_each_population([&](auto q)
                              __attribute__((always_inline)) { row.slot[q] = lattice.slots[q] + here; });
      return row;
    }
    const std::int64_t ys[3] = {wrap(y + 1, lattice.ny), y,
                                wrap(y - 1, lattice.ny)};  // where c_y + 1 is from
    const std::int64_t zs[3] = {wrap(z + 1, lattice.nz), z, wrap(z - 1, lattice.nz)};
    std::int64_t from[3][3];
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) from[i][j] = lattice.row(ys[i], zs[j]);
    }
    for_each_population([&](auto q) __attribute__((always_inline)) {
      constexpr auto v = c[static_cast<std::size_t>(q())];
      row.slot[q] = lattice.slots[opposite(q)] + from[v[1] + 1][v[2] + 1];
    });
    const bool beside_y = lattice.closed[1] && (y == 0 || y == lattice.ny - 1);
    const bool beside_z = lattice.closed[2] && (z == 0 || z == lattice.nz - 1);
    if (beside_y || beside_z) turn_back(lattice, y, z, row);
    return row;
  }

  /// A population that would come across a wall beside the row comes from the same node's slot of its own,
  /// where the step before left what went towards the wall. Its pointer is moved such that it is found at the
  /// place of the neighbour.
  static void turn_back(const Lattice<Real>& lattice, std::int64_t y, std::int64_t z, Row<Real>& row) {
    const auto across = [](bool closed_axis, std::int64_t from, std::int64_t size) {
      return closed_axis && (from < 0 || from >= size);
    };
    for (int q = 1; q < Q; ++q) {
      const auto& v = c[static_cast<std::size_t>(q)];
      if (across(lattice.closed[1], y - v[1], lattice.ny) ||
          across(lattice.closed[2], z - v[2], lattice.nz)) {
        row.slot[q] = lattice.slots[q] + lattice.row(y, z) +
                      (planted(Mutant::turned_back_one_node_off) ? 0 : v[0]) * lanes;
        row.back |= 1U << q;
      }
    }
  }

  template <class Force>
  static void rows(const Lattice<Real>& lattice, std::int64_t z, std::int64_t y_begin, std::int64_t y_end) {
    const std::int64_t n = lattice.nx / lanes;
    for (std::int64_t y = y_begin; y < y_end; ++y) {
      const Row<Real> row = row_at(lattice, y, z);
      if constexpr (odd) {
        if (row.back != 0) {
          along<Force, true>(lattice.law, row, n);
          continue;
        }
      }
      along<Force, false>(lattice.law, row, n);
    }
  }

  static Rows<Real> of(const Lattice<Real>& lattice) {
    if (!lattice.forced) return rows<NoForce>;
    return visit(lattice.scheme, [](auto force) -> Rows<Real> { return rows<decltype(force)>; });
  }
};

template <class Real, int lanes>
Rows<Real> rows_with(const Lattice<Real>& lattice, bool odd) {
  if (lattice.closed[0]) {
    return odd ? Step<Real, lanes, true, true>::of(lattice) : Step<Real, lanes, false, true>::of(lattice);
  }
  return odd ? Step<Real, lanes, true, false>::of(lattice) : Step<Real, lanes, false, false>::of(lattice);
}

template <class Real>
constexpr int max_lanes = static_cast<int>(register_bytes / sizeof(Real));

template <class Real, int lanes>
Rows<Real> choose(const Lattice<Real>& lattice, bool odd) {
  if constexpr (lanes > 1) {
    if (lattice.lanes != lanes) return choose<Real, lanes / 2>(lattice, odd);
  }
  return rows_with<Real, lanes>(lattice, odd);
}

}  // namespace

template <class Real>
int lanes_for(std::int64_t nx) {
  int lanes = max_lanes<Real>;
  while (lanes > 1 && (nx % lanes != 0 || nx == lanes)) lanes /= 2;  // a row of vectors has two ends
  return lanes;
}

template <class Real>
Rows<Real> rows_of(const Lattice<Real>& lattice, bool odd) {
  return choose<Real, max_lanes<Real>>(lattice, odd);
}

template <class Real>
void sweep(const Lattice<Real>& lattice, bool odd) {
  const Rows<Real> rows = rows_of(lattice, odd);
  // Each thread takes planes of its own, and no slot is another's.
#pragma omp parallel if (lattice.nx * lattice.ny * lattice.nz >= worth_threads)
  {
    const FlushSubnormals flush;
#pragma omp for schedule(static)
    for (std::int64_t z = 0; z < lattice.nz; ++z) {
      if (!stop::asked()) rows(lattice, z, 0, lattice.ny);
    }
  }
}

template int lanes_for<double>(std::int64_t);
template int lanes_for<float>(std::int64_t);
template Rows<double> rows_of(const Lattice<double>&, bool);
template Rows<float> rows_of(const Lattice<float>&, bool);
template void sweep<double>(const Lattice<double>&, bool);
template void sweep<float>(const Lattice<float>&, bool);

}  // namespace veriflex::fluid
