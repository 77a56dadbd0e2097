#include "fluid/sweep.hpp"

#include <omp.h>

#include <algorithm>
#include <type_traits>
#include <utility>

#include "fluid/lanes.hpp"

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace veriflex::fluid {

namespace {

/// Fluid at rest is full of subnormal numbers, each of which costs a hundred cycles: flushed to zero in this
/// thread while this lives.
class FlushSubnormals {
 public:
#if defined(__SSE2__)
  FlushSubnormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040U); }
  ~FlushSubnormals() { _mm_setcsr(before_); }
#else
  FlushSubnormals() {}
#endif
  FlushSubnormals(const FlushSubnormals&) = delete;
  FlushSubnormals& operator=(const FlushSubnormals&) = delete;

 private:
#if defined(__SSE2__)
  unsigned before_;
#endif
};

template <class Do, int... Is>
inline void unroll(Do work, std::integer_sequence<int, Is...>) {
  (work(std::integral_constant<int, Is>{}), ...);
}

template <class Do>
inline void for_each_population(Do work) {
  unroll(work, std::make_integer_sequence<int, Q>{});
}

constexpr int cx(int q) { return c[static_cast<std::size_t>(q)][0]; }

/// The rows that one row of nodes reads and writes: population q comes from slot[q] and leaves into
/// slot[opposite q].
template <class Real>
struct Row {
  Real* slot[Q];
  Real* own[Q];  // this row's own slots, where walls at its ends send populations back
};

template <class Real, int lanes, bool odd, bool closed>
struct Step {
  using L = Lanes<Real, static_cast<std::size_t>(lanes)>;
  using V = typename L::Type;
  /// Eight cache lines. Fifteen streams are more than some prefetchers follow: asking for data ourselves
  /// raised double from 0.85 to 0.95 of the memory's limit on one machine and changed nothing for float.
  static constexpr std::int64_t ahead = 512 / sizeof(Real);

  /// Vector i of the row; `first` and `last` tell whether it stands at an end.
  template <class Force, bool first, bool last>
  static inline void nodes(const Lattice<Real>& lattice, const Row<Real>& row, std::int64_t i,
                           std::int64_t n) {
    V h[Q];
    V kept[Q];  // with walls: what belongs to the other end of a row and must stay
    for_each_population([&](auto q) {
      constexpr int shift = odd ? cx(q) : 0;
      constexpr bool wraps = (shift == 1 && first) || (shift == -1 && last);
      if constexpr (!wraps) {
        __builtin_prefetch(row.slot[q] + (i - shift) * lanes + ahead, 1);
        h[q] = L::load(row.slot[q] + (i - shift) * lanes);
      } else {
        constexpr std::size_t end = shift == 1 ? 0 : lanes - 1;
        const V across = L::load(row.slot[q] + (shift == 1 ? n - 1 : 0) * lanes);
        h[q] = shift == 1 ? L::up(across) : L::down(across);
        if constexpr (closed) {
          kept[q] = h[q];
          L::set(h[q], end, row.own[q][i * lanes + static_cast<std::int64_t>(end)]);
        }
      }
    });
    collide<Force>(lattice.law, h);
    for_each_population([&](auto q) {
      constexpr int p = opposite(q);
      constexpr int shift = odd ? cx(q) : 0;
      constexpr bool wraps = (shift == 1 && first) || (shift == -1 && last);
      if constexpr (!wraps) {
        L::store(row.slot[q] + (i - shift) * lanes, h[p]);
      } else {
        constexpr std::size_t end = shift == 1 ? 0 : lanes - 1;
        V leaving = h[p];
        if constexpr (closed) L::set(leaving, end, L::get(kept[q], end));
        L::store(row.slot[q] + (shift == 1 ? n - 1 : 0) * lanes,
                 shift == 1 ? L::down(leaving) : L::up(leaving));
      }
    });
    if constexpr (odd && closed) {  // last, because the vectors above may hold the old value of the same slot
      for_each_population([&](auto q) {
        constexpr int shift = cx(q);
        constexpr bool wraps = (shift == 1 && first) || (shift == -1 && last);
        if constexpr (wraps) {
          constexpr std::size_t end = shift == 1 ? 0 : lanes - 1;
          row.own[q][i * lanes + static_cast<std::int64_t>(end)] = L::get(h[opposite(q)], end);
        }
      });
    }
  }

  template <class Force>
  static void along(const Lattice<Real>& lattice, const Row<Real>& row) {
    const std::int64_t n = lattice.nx / lanes;
    if (n == 1) {
      nodes<Force, true, true>(lattice, row, 0, 1);
      return;
    }
    nodes<Force, true, false>(lattice, row, 0, n);
    for (std::int64_t i = 1; i < n - 1; ++i) nodes<Force, false, false>(lattice, row, i, n);
    nodes<Force, false, true>(lattice, row, n - 1, n);
  }

  static std::int64_t wrap(std::int64_t at, std::int64_t size) {
    return at < 0 ? at + size : at >= size ? at - size : at;
  }

  template <class Force>
  static void plane(const Lattice<Real>& lattice, std::int64_t z) {
    for (std::int64_t y = 0; y < lattice.ny; ++y) {
      Row<Real> row;
      for_each_population([&](auto q) {
        constexpr auto v = c[static_cast<std::size_t>(q())];
        row.own[q] = lattice.slots[q] + lattice.row(y, z);
        row.slot[q] = odd ? lattice.slots[opposite(q)] +
                                lattice.row(wrap(y - v[1], lattice.ny), wrap(z - v[2], lattice.nz))
                          : row.own[q];
      });
      along<Force>(lattice, row);
    }
  }

  /// Each thread takes a slab of planes, two at least. Walls at the ends of rows make a row touch vectors
  /// that its neighbours along z change too, so that there the last plane of each slab waits until all others
  /// are done.
  template <class Force>
  static void all(const Lattice<Real>& lattice) {
    constexpr bool waits = odd && closed;
#pragma omp parallel num_threads( \
    static_cast <int>(std::clamp <std::int64_t>(lattice.nz / 2, 1, omp_get_max_threads())))
    {
      const FlushSubnormals flush;
      const std::int64_t threads = omp_get_num_threads();
      const std::int64_t me = omp_get_thread_num();
      const std::int64_t from = lattice.nz * me / threads;
      const std::int64_t to = lattice.nz * (me + 1) / threads;
      for (std::int64_t z = from; z < to - (waits ? 1 : 0); ++z) plane<Force>(lattice, z);
      if constexpr (waits) {
#pragma omp barrier
        plane<Force>(lattice, to - 1);
      }
    }
  }

  static void run(const Lattice<Real>& lattice) {
    switch (lattice.forcing) {
      case Forcing::None:
        return all<NoForce>(lattice);
      case Forcing::FirstOrder:
        return all<FirstOrderForce>(lattice);
      case Forcing::Guo:
        return all<GuoForce>(lattice);
    }
  }
};

template <class Real, int lanes>
void sweep_with(const Lattice<Real>& lattice, bool odd) {
  if (!odd) {
    Step<Real, lanes, false, false>::run(lattice);
  } else if (lattice.closed_x) {
    Step<Real, lanes, true, true>::run(lattice);
  } else {
    Step<Real, lanes, true, false>::run(lattice);
  }
}

template <class Real>
constexpr int most_lanes = static_cast<int>(register_bytes / sizeof(Real));

template <class Real, int lanes>
void choose(const Lattice<Real>& lattice, bool odd) {
  if (lattice.lanes == lanes) {
    sweep_with<Real, lanes>(lattice, odd);
  } else if constexpr (lanes > 1) {
    choose<Real, lanes / 2>(lattice, odd);
  }
}

}  // namespace

template <class Real>
int lanes_for(std::int64_t nx) {
  int lanes = most_lanes<Real>;
  while (nx % lanes != 0) lanes /= 2;
  return lanes;
}

template <class Real>
void sweep(const Lattice<Real>& lattice, bool odd) {
  choose<Real, most_lanes<Real>>(lattice, odd);
}

template int lanes_for<double>(std::int64_t);
template int lanes_for<float>(std::int64_t);
template void sweep<double>(const Lattice<double>&, bool);
template void sweep<float>(const Lattice<float>&, bool);

}  // namespace veriflex::fluid
