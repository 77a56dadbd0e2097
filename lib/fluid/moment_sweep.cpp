#include "fluid/moment_sweep.hpp"

#include <omp.h>

#include <algorithm>
#include <array>
#include <type_traits>
#include <utility>

#include "base/stop.hpp"
#include "fluid/lanes.hpp"
#include "fluid/subnormals.hpp"
#include "fluid/threads.hpp"
#include "fluid/unroll.hpp"

namespace veriflex::fluid {

namespace {

constexpr int component(int q, std::size_t axis) { return c[static_cast<std::size_t>(q)][axis]; }

// What leaves a row, by where it goes: to nodes of the same row, with what goes straight up and down; to the
// row y + 1; to the row y - 1. The diagonals stand in pairs, c_x = 1 before c_x = -1, upwards before
// downwards.
constexpr int group_size = 5;
using Group = std::array<int, group_size>;
constexpr Group own{0, 1, 2, 5, 6};
constexpr Group onward{3, 7, 14, 9, 12};
constexpr Group backward{4, 11, 10, 13, 8};

/// Of a plane that waits for what comes down from the next one: its sums of H, H c_x and H c_y so far; what
/// came up of H, whose slots take turns; and what goes up of H c_x and H c_y.
enum Waiting { waiting_r, waiting_x, waiting_y, up_r, other_up_r, up_x, up_y, waiting_size };

/// Rows of a tile, such that what waits for the next plane takes half of a second-level cache of 512 KB.
template <class Real>
std::int64_t tile_rows(std::int64_t nx, std::int64_t ny) {
  constexpr std::int64_t budget = 256 * 1024;
  const std::int64_t row = nx * waiting_size * static_cast<std::int64_t>(sizeof(Real));
  const std::int64_t fit = std::max<std::int64_t>(16, budget / row);
  const std::int64_t tiles = (ny + fit - 1) / fit;
  return (ny + tiles - 1) / tiles;
}

/// Numbers of a row of a group. A vector more stands at either end: what comes round from the other.
constexpr std::int64_t group_row(std::int64_t nx, std::int64_t lanes) {
  return group_size * (nx + 2 * lanes);
}

/// What comes back from walls to the nodes of a row.
template <class Real>
struct Returned {
  Real* sums;       // r, x, y, z of each vector of nodes: H and H c
  bool beside;      // whether there are such: a wall is beside the row
  Real ends[2][4];  // the same of its first and last node, with walls along x
};

/// A thread's memory.
template <class Real>
struct Scratch {
  // By row: the last one, the last two, the last three that have sent.
  Real* backward;
  Real* own[2];
  Real* onward[3];
  Returned<Real> returned[2];
  Real* spare_to;  // for planes that are another thread's
  Real* waiting;   // of the rows of a tile

  static std::int64_t size(std::int64_t nx, std::int64_t rows) {
    constexpr std::int64_t most_lanes = register_bytes / sizeof(Real);
    return 6 * group_row(nx, most_lanes) + (2 * 4 + 4 + waiting_size * rows) * nx;
  }

  Scratch(Real* at, std::int64_t nx, std::int64_t lanes) {
    const auto take = [&](std::int64_t count) {
      Real* const here = at;
      at += count;
      return here;
    };
    backward = take(group_row(nx, lanes));
    for (Real*& row : own) row = take(group_row(nx, lanes));
    for (Real*& row : onward) row = take(group_row(nx, lanes));
    for (Returned<Real>& row : returned) row = {take(4 * nx), false, {}};
    spare_to = take(4 * nx);
    waiting = at;
  }
};

/// A row of nodes that sends, y.
template <class Real>
struct Sender {
  const Real* from;   // its moments
  const Real* ahead;  // what is read some rows later
  Real* groups[3];    // own, onward, backward
};

/// A row of nodes y that has all that comes from its plane when y + 1 has sent.
template <class Real>
struct Receiver {
  const Real* own;       // of y
  const Real* onward;    // of y - 1
  const Real* backward;  // of y + 1
  Real* waiting;         // of y
  Real* to;              // moments of y in the plane before
  int up_slot;           // takes what goes up
  int other_up_slot;     // what came up from the plane before
};

constexpr std::array<Group, 3> groups{own, onward, backward};

template <class Real, int lanes>
struct MomentStep {
  using L = Lanes<Real, static_cast<std::size_t>(lanes)>;
  using V = typename L::Type;
  static constexpr int step = group_size * lanes;  // from one vector of a group to the next

  /// Calls work(pointer to population q of the row's first vector, q) for each q that leaves it.
  template <class Do>
  [[gnu::always_inline]] static inline void for_each_leaving(const Sender<Real>& row, Do work) {
    for (std::size_t group = 0; group < 3; ++group) {
      for (std::size_t k = 0; k < group_size; ++k) {
        work(row.groups[group] + step + static_cast<int>(k) * lanes, groups[group][k]);
      }
    }
  }

  /// `law` by value: no store can change it then.
  template <class Force>
  [[gnu::noinline]] static void send(const MomentForce<Real> law, const Sender<Real> row, std::int64_t n) {
    for (std::int64_t i = 0; i < n; ++i) {
      const Real* const at = row.from + i * 4 * lanes;
      constexpr int line = 64 / sizeof(Real);
      for (int part = 0; part < 4 * lanes; part += line) {
        __builtin_prefetch(row.ahead + i * 4 * lanes + part, 0, 2);
      }
      const V M[4] = {L::load(at), L::load(at + lanes), L::load(at + 2 * lanes), L::load(at + 3 * lanes)};
      V H[Q];
      leave<Force>(law, M, H);
      unroll(
          [&](auto place) __attribute__((always_inline)) {
            constexpr std::size_t group = place() / group_size, k = place() % group_size;
            L::store(row.groups[group] + (i + 1) * step + static_cast<int>(k) * lanes, H[groups[group][k]]);
          },
          std::make_integer_sequence<int, Q>{});
    }
  }

  /// Takes out of a row what would leave across walls. `back`: bit q: population q would, all along the row.
  static void turn_back(const Sender<Real>& row, unsigned back, bool ends, std::int64_t n,
                        Returned<Real>& returned) {
    returned.beside = back != 0;
    if (back != 0) std::fill(returned.sums, returned.sums + 4 * n * lanes, Real(0));
    std::fill(&returned.ends[0][0], &returned.ends[0][0] + 8, Real(0));
    for_each_leaving(row, [&](Real* first, int q) {
      if ((back >> q & 1U) != 0) {
        for (std::int64_t i = 0; i < n; ++i) {
          const V H = L::load(first + i * step);
          L::store(first + i * step, V{});
          Real* const sums = returned.sums + i * 4 * lanes;
          L::store(sums, L::load(sums) + H);
          for (std::size_t axis = 0; axis < 3; ++axis) {
            Real* const sum = sums + (static_cast<int>(axis) + 1) * lanes;
            L::store(sum, L::load(sum) - Real(component(q, axis)) * H);
          }
        }
      } else if (ends && component(q, 0) != 0) {
        Real& H = component(q, 0) < 0 ? first[0] : first[(n - 1) * step + lanes - 1];
        Real(&sums)[4] = returned.ends[component(q, 0) < 0 ? 0 : 1];
        sums[0] += H;
        for (std::size_t axis = 0; axis < 3; ++axis) sums[axis + 1] -= Real(component(q, axis)) * H;
        H = Real(0);
      }
    });
  }

  /// What leaves a row at one end comes round at the other.
  static void wrap_ends(const Sender<Real>& row, std::int64_t n) {
    for_each_leaving(
        row, [&](Real * first, int q) __attribute__((always_inline)) {
          if (component(q, 0) > 0) L::store(first - step, L::up(L::load(first + (n - 1) * step)));
          if (component(q, 0) < 0) L::store(first + n * step, L::down(L::load(first)));
        });
  }

  template <bool streams>
  [[gnu::noinline]] static void receive(const Receiver<Real> row, std::int64_t n) {
    for (std::int64_t i = 0; i < n; ++i) {
      const auto here = [&](const Real* group, int k) __attribute__((always_inline)) {
        return L::load(group + (i + 1) * step + k * lanes);
      };
      // Of the pair at k: what comes from both sides along x.
      const auto east = [&](const Real* group, int k) __attribute__((always_inline)) {
        return L::load(group + i * step + k * lanes);
      };
      const auto west = [&](const Real* group, int k) __attribute__((always_inline)) {
        return L::load(group + (i + 2) * step + (k + 1) * lanes);
      };
      Real* const waiting = row.waiting + i * waiting_size * lanes;
      const auto slot = [&](int k) __attribute__((always_inline)) { return waiting + k * lanes; };
      Real* const to = row.to + i * 4 * lanes;
      const auto write = [&](int k, const V& value) __attribute__((always_inline)) {
        if constexpr (streams) {
          L::stream(to + k * lanes, value);
        } else {
          L::store(to + k * lanes, value);
        }
      };

      // What goes down completes the plane before.
      {
        const V on_e = east(row.onward, 3), on_w = west(row.onward, 3);
        const V back_e = east(row.backward, 3), back_w = west(row.backward, 3);
        const V on = on_e + on_w, back = back_e + back_w;
        const V down = here(row.own, 4) + (on + back);
        const V down_x = (on_e - on_w) + (back_e - back_w);
        const V z = L::load(slot(row.up_slot)) - down;
        write(0, L::load(slot(waiting_r)) + down);
        write(1, L::load(slot(waiting_x)) + down_x);
        write(2, L::load(slot(waiting_y)) + (on - back));
        write(3, z);
      }
      // What goes up into the next plane; what came up into this one is needed first.
      const V came_x = L::load(slot(up_x)), came_y = L::load(slot(up_y));
      {
        const V on_e = east(row.onward, 1), on_w = west(row.onward, 1);
        const V back_e = east(row.backward, 1), back_w = west(row.backward, 1);
        const V on = on_e + on_w, back = back_e + back_w;
        const V up_x_now = (on_e - on_w) + (back_e - back_w);
        L::store(slot(row.up_slot), here(row.own, 3) + (on + back));
        L::store(slot(up_x), up_x_now);
        L::store(slot(up_y), on - back);
      }
      // What stays in the plane.
      const V own_e = east(row.own, 1), own_w = west(row.own, 1);
      const V axis_on = here(row.onward, 0), axis_back = here(row.backward, 0);
      const V r = (here(row.own, 0) + (own_e + own_w)) + (axis_on + axis_back);
      L::store(slot(waiting_r), L::load(slot(row.other_up_slot)) + r);
      L::store(slot(waiting_x), came_x + (own_e - own_w));
      L::store(slot(waiting_y), came_y + (axis_on - axis_back));
    }
  }

  /// Adds what came back from walls to what a row of nodes has got.
  static void add_returned(const Receiver<Real>& row, const Returned<Real>& returned, bool ends,
                           std::int64_t n) {
    const int slots[4] = {waiting_r, waiting_x, waiting_y, row.other_up_slot};
    for (std::int64_t i = 0; returned.beside && i < n; ++i) {
      for (int k = 0; k < 4; ++k) {
        Real* const at = row.waiting + (i * waiting_size + slots[k]) * lanes;
        L::store(at, L::load(at) + L::load(returned.sums + (i * 4 + k) * lanes));
      }
    }
    for (int k = 0; ends && k < 4; ++k) {
      row.waiting[slots[k] * lanes] += returned.ends[0][k];
      row.waiting[((n - 1) * waiting_size + slots[k]) * lanes + lanes - 1] += returned.ends[1][k];
    }
  }

  static std::int64_t wrap(std::int64_t at, std::int64_t size) {
    return at < 0 ? at + size : at >= size ? at - size : at;
  }

  /// Populations that would leave a row across walls beside it.
  static unsigned across_walls(const MomentLattice<Real>& lattice, std::int64_t y, std::int64_t z) {
    unsigned back = 0;
    const auto add = [&](std::size_t axis, int sign) {
      for (int q = 1; q < Q; ++q) {
        if (component(q, axis) == sign) back |= 1U << q;
      }
    };
    if (lattice.closed[1] && y == 0) add(1, -1);
    if (lattice.closed[1] && y == lattice.ny - 1) add(1, 1);
    if (lattice.closed[2] && z == 0) add(2, -1);
    if (lattice.closed[2] && z == lattice.nz - 1) add(2, 1);
    return back;
  }

  /// What rows y0 - 1 ... y0 + count of plane z send; completes rows y0 ... of plane z - 1 when `completes`.
  /// `turn`: number of the plane in the thread's order.
  template <class Force>
  static void plane(const MomentLattice<Real>& lattice, Scratch<Real>& scratch, std::int64_t y0,
                    std::int64_t count, std::int64_t z, bool completes, std::int64_t turn) {
    const std::int64_t nx = lattice.nx, n = nx / lanes;
    const std::int64_t from_plane = lattice.ny * wrap(z, lattice.nz), to_plane = lattice.ny * (z - 1);
    const std::int64_t last_row = lattice.ny * lattice.nz - 1;
    const bool walled = lattice.closed[0] || lattice.closed[1] || lattice.closed[2];
    for (std::int64_t s = -1; s <= count; ++s) {
      const std::int64_t y = wrap(y0 + s, lattice.ny), row = from_plane + y;
      Returned<Real>& returned = scratch.returned[(s + 2) % 2];
      const Sender<Real> sender{lattice.from + 4 * nx * row,
                                lattice.from + 4 * nx * std::min(row + 3, last_row),
                                {scratch.own[(s + 2) % 2], scratch.onward[(s + 3) % 3], scratch.backward}};
      send<Force>(lattice.law, sender, n);
      if (walled) {
        turn_back(sender, across_walls(lattice, y, wrap(z, lattice.nz)), lattice.closed[0], n, returned);
      }
      wrap_ends(sender, n);
      if (s < 1) continue;
      const Receiver<Real> receiver{
          scratch.own[(s + 1) % 2],
          scratch.onward[(s + 1) % 3],
          scratch.backward,
          scratch.waiting + (s - 1) * waiting_size * nx,
          completes ? lattice.to + 4 * nx * (to_plane + y0 + s - 1) : scratch.spare_to,
          turn % 2 == 0 ? up_r : other_up_r,
          turn % 2 == 0 ? other_up_r : up_r};
      lattice.streams&& completes ? receive<true>(receiver, n) : receive<false>(receiver, n);
      if (walled) add_returned(receiver, scratch.returned[(s + 1) % 2], lattice.closed[0], n);
    }
  }

  /// Each thread takes planes of its own.
  template <class Force>
  static void all(const MomentLattice<Real>& lattice) {
    const std::int64_t tile = tile_rows<Real>(lattice.nx, lattice.ny);
#pragma omp parallel if (lattice.nx * lattice.ny * lattice.nz >= worth_threads)
    {
      const FlushSubnormals flush;
      const std::int64_t thread = omp_get_thread_num(), threads = omp_get_num_threads();
      Scratch<Real> scratch(lattice.scratch + thread * scratch_size<Real>(lattice.nx, lattice.ny), lattice.nx,
                            lanes);
      const std::int64_t z0 = lattice.nz * thread / threads, z1 = lattice.nz * (thread + 1) / threads;
      for (std::int64_t y0 = 0; y0 < lattice.ny && z0 < z1; y0 += tile) {
        const std::int64_t count = std::min(tile, lattice.ny - y0);
        for (std::int64_t z = z0 - 1; z <= z1 && !stop::asked(); ++z) {
          plane<Force>(lattice, scratch, y0, count, z, z > z0, z - z0 + 1);
        }
      }
      L::finish_stream();
    }
  }

  static void run(const MomentLattice<Real>& lattice) {
    if (!lattice.forced) return all<NoForce>(lattice);
    visit(lattice.scheme, [&](auto force) { all<decltype(force)>(lattice); });
  }
};

template <class Real, int lanes>
void choose(const MomentLattice<Real>& lattice) {
  if (lattice.lanes == lanes) {
    MomentStep<Real, lanes>::run(lattice);
  } else if constexpr (lanes > 1) {
    choose<Real, lanes / 2>(lattice);
  }
}

}  // namespace

template <class Real>
std::int64_t scratch_size(std::int64_t nx, std::int64_t ny) {
  return (Scratch<Real>::size(nx, tile_rows<Real>(nx, ny)) + 63) / 64 * 64;
}

template <class Real>
void sweep(const MomentLattice<Real>& lattice) {
  choose<Real, static_cast<int>(register_bytes / sizeof(Real))>(lattice);
}

template <class Real>
void leave_node(const MomentLattice<Real>& lattice, const Real (&M)[4], Real (&H)[Q]) {
  if (!lattice.forced) return leave<NoForce>(lattice.law, M, H);
  visit(lattice.scheme, [&](auto force) { leave<decltype(force)>(lattice.law, M, H); });
}

template std::int64_t scratch_size<double>(std::int64_t, std::int64_t);
template std::int64_t scratch_size<float>(std::int64_t, std::int64_t);
template void sweep<double>(const MomentLattice<double>&);
template void sweep<float>(const MomentLattice<float>&);
template void leave_node<double>(const MomentLattice<double>&, const double (&)[4], double (&)[Q]);
template void leave_node<float>(const MomentLattice<float>&, const float (&)[4], float (&)[Q]);

}  // namespace veriflex::fluid
