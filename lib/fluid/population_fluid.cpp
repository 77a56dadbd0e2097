#include "fluid/population_fluid.hpp"

#include <omp.h>

#include <algorithm>

#include "base/memory.hpp"
#include "base/mutant.hpp"
#include "base/stop.hpp"
#include "base/work.hpp"
#include "fluid/blocking.hpp"
#include "fluid/links.hpp"
#include "fluid/near_rows.hpp"
#include "fluid/reductions.hpp"
#include "fluid/subnormals.hpp"
#include "fluid/sweep.hpp"
#include "fluid/threads.hpp"
#include "fluid/unroll.hpp"

namespace veriflex::fluid {

namespace {

constexpr std::int64_t cache_line = 64;

/// Bytes from one population's array to the next: rows, and padding to five lines beyond a page. Equal places
/// of the fifteen arrays then differ in their last twelve bits, by which processors first compare the
/// addresses of loads with those of earlier stores, and do not fall into the same sets of the caches.
std::int64_t stride_bytes(const Spec& spec) {
  const std::int64_t page = 4096;
  const std::int64_t bytes = spec.grid.count() * bytes_of(spec.storage);
  return (bytes + page - 1) / page * page + 5 * cache_line;
}

/// Of the populations that come back from walls along x.
std::int64_t end_bytes(const Spec& spec) {
  if (!spec.walls[0]) return 0;
  return ends_per_row * spec.grid.size[1] * spec.grid.size[2] * bytes_of(spec.storage);
}

template <class Real>
class PopulationFluid final : public Fluid {
 public:
  explicit PopulationFluid(const Spec& wanted)
      : Fluid(wanted), pages_(allocate_pages(static_cast<std::size_t>(population_bytes(wanted)))) {
    for (int q = 0; q < Q; ++q) {
      lattice_.slots[q] = reinterpret_cast<Real*>(pages_.get() + q * stride_bytes(spec_));
    }
    lattice_.ends = reinterpret_cast<Real*>(pages_.get() + Q * stride_bytes(spec_));
    describe<Real>(spec_, lattice_);
    const Vec3& g = spec_.body_force;
    lattice_.law = visit(spec_.scheme, [&](auto force) {
      return collision<decltype(force), Real>(spec_.relaxation_time, {g[0], g[1], g[2]});
    });
    for (std::int64_t x = 0; x < lattice_.nx; ++x) place_.push_back(lattice_.place(x));
    gains_ = gains_of(spec_);
    is_obstacle_ = inside_of(spec_);
    outlets_ = outlets_of(spec_, is_obstacle_);
    for (const CutLink& link : links_of(spec_, is_obstacle_)) {
      links_.push_back({slot(opposite(link.q), link.node) - base(), slot(link.q, link.beyond) - base()});
    }
    start([](std::int64_t) { return Populations{}; });
    const auto ends = static_cast<double>(end_bytes(spec_));
    tell_parts({.nodes = population_bytes(spec_) - ends,
                .walls = ends + parts::array_bytes(gains_, outlets_),
                .obstacle = parts::array_bytes(is_obstacle_, links_)});
  }

  void start(const std::function<Populations(std::int64_t)>& at) override {
    steps_ = 0;
    put(at);
    stop_if_asked("fluid step", 0);
  }

  void restore(const State& state) override {
    steps_ = state.steps;
    put([&](std::int64_t node) { return state.populations[static_cast<std::size_t>(node)]; });
    stop_if_asked("fluid step", steps_);
  }

  void collide_and_stream(const NodeForces& forces) override {
    stop_if_asked("fluid step", steps_ + 1);
    count_work(1);
    prepare(outlets_, [this](std::int64_t node) { return arriving(node); });
    sweep(lattice_, odd());
    stop_if_asked("fluid step", steps_ + 1);  // a sweep that saw it is not whole
    add(forces);
    ++steps_;
    const auto links = static_cast<std::int64_t>(links_.size());
#pragma omp parallel for schedule(static) if (links > 1000)
    for (std::int64_t i = 0; i < links; ++i) {
      const SlotPair& pair = links_[static_cast<std::size_t>(i)];
      std::swap(*(base() + pair.first), *(base() + pair.second));
    }
    const FlushSubnormals flush;
    for (const Gain& gain : gains_) {
      const double risen = gain.inflow != nullptr ? gain.inflow->risen(steps_) : 1.0;
      *arriving(gain.q, gain.node) += static_cast<Real>(risen * gain.value);
    }
    for (const Outlet& outlet : outlets_) let_out(outlet);
  }

  void advance(std::int64_t steps) override {
    if (std::min(blocking().steps, steps) < 2) return Fluid::advance(steps);
    stop_if_asked("fluid step", steps_ + 1);
    count_work(steps);
    make_many(steps, rows_of_next_steps(), nullptr);
    stop_if_asked("fluid step", steps_ + 1);
    steps_ += steps;
  }

  std::int64_t steps_at_once() const override { return blocking().steps; }

  std::unique_ptr<StepsAhead> steps_ahead(std::span<const std::int64_t> rows, std::int64_t most) override {
    // Those ahead make their steps one by one, and there are the more of them the longer a block is.
    for (std::int64_t steps = std::min(blocking().steps, most); steps > 1; steps /= 2) {
      NearRows near(row_grid(), rows, steps);
      if (3 * near.count() < lattice_.ny * lattice_.nz)
        return std::make_unique<Ahead>(*this, std::move(near));
    }
    return nullptr;
  }

  void populations(std::span<const std::int64_t> nodes, std::span<Populations> h) const override {
    const auto count = static_cast<std::int64_t>(nodes.size());
#pragma omp parallel for schedule(static) if (count >= worth_threads)
    for (std::int64_t i = 0; i < count; ++i) {
      const std::int64_t node = nodes[static_cast<std::size_t>(i)];
      h[static_cast<std::size_t>(i)] = inside(node) ? Populations{} : arriving(node);
    }
  }

  void velocities(std::span<const std::int64_t> nodes, Positions& u) const override {
    const auto count = static_cast<std::int64_t>(nodes.size());
    u.resize(count, 3);
#pragma omp parallel for schedule(static) if (count >= worth_threads)
    for (std::int64_t i = 0; i < count; ++i) {
      const std::int64_t node = nodes[static_cast<std::size_t>(i)];
      if (inside(node)) {
        u.row(i).setZero();
        continue;
      }
      const Populations h = arriving(node);
      u.row(i) = momentum(h).transpose() / (1.0 + density_deviation(h));
    }
  }

  Totals totals() const override {
    return totals_of(spec_.grid, steps_, moments_of_rows(),
                     [this](std::int64_t node) { return inside(node); });
  }

  Extremes extremes() const override {
    return extremes_of(spec_.grid, moments_of_rows(), [this](std::int64_t node) { return inside(node); });
  }

 private:
  class Ahead final : public StepsAhead {
   public:
    Ahead(PopulationFluid& fluid, NearRows near)
        : fluid_(fluid), near_(std::move(near)), first_(fluid.steps_), rows_(fluid.rows_of_next_steps()) {}

    std::int64_t most() const override { return near_.steps(); }
    bool cover(std::span<const std::int64_t> rows) const override { return near_.cover(rows); }

    void collide_and_stream(const NodeForces& forces) override {
      stop_if_asked("fluid step", fluid_.steps_ + 1);
      const std::int64_t step = fluid_.steps_ - first_;
      const bool alone = near_.count() * fluid_.lattice_.nx < worth_threads;
      const int threads = alone ? 1 : omp_get_max_threads();
      near_.make(step, threads, [&](std::int64_t, std::int64_t z, std::int64_t y_begin, std::int64_t y_end) {
        rows_[static_cast<std::size_t>(step % 2)](fluid_.lattice_, z, y_begin, y_end);
      });
      stop_if_asked("fluid step", fluid_.steps_ + 1);
      fluid_.add(forces);
      if (!fluid_.gains_.empty()) {
        near_.make(step, 1, [&](std::int64_t, std::int64_t z, std::int64_t y_begin, std::int64_t y_end) {
          fluid_.gain(z, y_begin, y_end);
        });
      }
      ++fluid_.steps_;
    }

    void let_others_follow() override {
      const std::int64_t steps = fluid_.steps_ - first_;
      if (steps == 0) return;
      fluid_.count_work(steps);
      fluid_.make_many(steps, rows_, &near_);
      stop_if_asked("fluid step", fluid_.steps_ + 1);
    }

   private:
    PopulationFluid& fluid_;
    NearRows near_;
    std::int64_t first_;  // steps of the fluid before the first
    std::array<Rows<Real>, 2> rows_;
  };

  /// After a step, be it even or odd, what each end sent along a cut link stands where the other end will
  /// look for it, so the two slots are exchanged. The inside of an obstacle is a closed fluid of its own from
  /// which nothing leaks, so that the sweep treats no node apart; nobody is shown it: seen from outside an
  /// obstacle's nodes are at rest.
  struct SlotPair {
    std::int64_t first, second;  // from base()
  };

  void count_work(std::int64_t steps) const {
    work::add_nodes(static_cast<std::uint64_t>(steps * spec_.grid.count()),
                    2 * Q * static_cast<std::uint64_t>(bytes_of(spec_.storage)));
  }

  RowGrid row_grid() const { return {lattice_.ny, lattice_.nz}; }

  Blocking blocking() const {
    if (!is_made_row_by_row(spec_)) return {1, lattice_.ny};
    if (spec_.blocking) return *spec_.blocking;
    return blocking_for(row_grid(), Q * lattice_.nx * std::int64_t{sizeof(Real)}, omp_get_max_threads());
  }

  std::array<Rows<Real>, 2> rows_of_next_steps() const {
    return {rows_of(lattice_, odd()), rows_of(lattice_, !odd())};
  }

  /// So many steps of all rows, less what those near a body have made of them.
  void make_many(std::int64_t steps, const std::array<Rows<Real>, 2>& rows, const NearRows* near) {
    const MakeRows all = [&](std::int64_t step, std::int64_t z, std::int64_t y_begin, std::int64_t y_end) {
      rows[static_cast<std::size_t>(step % 2)](lattice_, z, y_begin, y_end);
      gain(z, y_begin, y_end);
    };
    const MakeRows others = [&](std::int64_t step, std::int64_t z, std::int64_t y_begin, std::int64_t y_end) {
      near->make_others(step, z, y_begin, y_end, all);
    };
    make_steps(row_grid(), steps, blocking(), omp_get_max_threads(), near != nullptr ? others : all);
  }

  /// What moving walls add to rows that have just made a step. It stands in a slot of the same node after
  /// either kind of step.
  void gain(std::int64_t z, std::int64_t y_begin, std::int64_t y_end) {
    const auto before = [](const Gain& gain, std::int64_t node) { return gain.node < node; };
    const std::int64_t end = lattice_.nx * (y_end + lattice_.ny * z);
    auto at =
        std::lower_bound(gains_.begin(), gains_.end(), lattice_.nx * (y_begin + lattice_.ny * z), before);
    for (; at != gains_.end() && at->node < end; ++at) *slot(at->q, at->node) += static_cast<Real>(at->value);
  }

  /// Populations of each node before the step to come.
  template <class At>
  void put(const At& at) {
    const Grid& grid = spec_.grid;
    // Each slot belongs to one node and direction: threads do not meet.
#pragma omp parallel for
    for (std::int64_t z = 0; z < grid.size[2]; ++z) {
      for (std::int64_t y = 0; y < grid.size[1]; ++y) {
        if (stop::asked()) continue;
        for (std::int64_t x = 0; x < grid.size[0]; ++x) {
          const std::int64_t node = grid.index(x, y, z);
          const Populations h = at(node);
          for (int q = 0; q < Q; ++q) *arriving(q, node) = static_cast<Real>(h[static_cast<std::size_t>(q)]);
        }
      }
    }
  }

  bool odd() const { return steps_ % 2 == 1; }
  Real* base() const { return lattice_.slots[0]; }

  Real* slot(int q, std::int64_t node) const {
    const std::int64_t x = node % lattice_.nx;
    const std::int64_t from_wall = velocity(q)[0] == 1 ? 0 : velocity(q)[0] == -1 ? lattice_.nx - 1 : -1;
    if (lattice_.closed[0] && x == from_wall) {
      return lattice_.ends + ends_per_row * (node / lattice_.nx) + end_of_row(q);
    }
    return lattice_.slots[q] + (node - x) + place_[static_cast<std::size_t>(x)];
  }

  /// Where population q of this node stands before the step to come.
  Real* arriving(int q, std::int64_t node) const {
    if (!odd()) return slot(q, node);
    const auto at = spec_.grid.node(node);
    if (crossed_wall(spec_, at, q, -1) >= 0) return slot(q, node);
    return slot(opposite(q), neighbour(spec_.grid, at, q, -1));
  }

  /// The same of all its populations. Nodes beside walls apart, a neighbour's place is looked up per axis.
  std::array<Real*, Q> all_arriving(std::int64_t node) const {
    std::array<Real*, Q> slots;
    const auto at = spec_.grid.node(node);
    if (is_beside_wall(at)) {
      for (int q = 0; q < Q; ++q) slots[static_cast<std::size_t>(q)] = arriving(q, node);
      return slots;
    }
    // Where a population with c_i = 1, 0, -1 comes from.
    std::int64_t from[3][3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (int v = -1; v <= 1; ++v)
        from[axis][v + 1] = odd() ? spec_.grid.wrap(at[axis] - v, axis) : at[axis];
    }
    for (std::int64_t& x : from[0]) x = place_[static_cast<std::size_t>(x)];
    for_each_population([&](auto q) {
      constexpr auto v = c[static_cast<std::size_t>(q())];
      slots[q()] = lattice_.slots[odd() ? opposite(q) : q()] +
                   lattice_.row(from[1][v[1] + 1], from[2][v[2] + 1]) + from[0][v[0] + 1];
    });
    return slots;
  }

  bool is_beside_wall(const std::array<std::int64_t, 3>& at) const {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (lattice_.closed[axis] && (at[axis] == 0 || at[axis] == spec_.grid.size[axis] - 1)) return true;
    }
    return false;
  }

  Populations arriving(std::int64_t node) const {
    const std::array<Real*, Q> slots = all_arriving(node);
    Populations h;
    for (std::size_t q = 0; q < Q; ++q) h[q] = static_cast<double>(*slots[q]);
    return h;
  }

  bool inside(std::int64_t node) const {
    return !is_obstacle_.empty() && is_obstacle_[static_cast<std::size_t>(node)];
  }

  /// Population q of a row of nodes before the step to come, each where its node has its place.
  void arriving_row(int q, std::int64_t y, std::int64_t z, std::vector<double>& h) const {
    const std::int64_t nx = lattice_.nx, lanes = lattice_.lanes;
    const auto v = velocity(q);
    const auto comes_back = [&](std::size_t axis, std::int64_t from) {
      return lattice_.closed[axis] && (from < 0 || from >= spec_.grid.size[axis]);
    };
    const bool stands_here = !odd() || comes_back(1, y - v[1]) || comes_back(2, z - v[2]);
    const Real* const row = stands_here
                                ? lattice_.slots[q] + lattice_.row(y, z)
                                : lattice_.slots[opposite(q)] + lattice_.row(spec_.grid.wrap(y - v[1], 1),
                                                                             spec_.grid.wrap(z - v[2], 2));
    // One node further along x is one vector further; at the row's end it is the next lane of the other end.
    const std::int64_t shift = stands_here ? 0 : v[0];
    const std::int64_t first = shift == 1 ? lanes : 0, last = shift == -1 ? nx - lanes : nx;
    for (std::int64_t i = first; i < last; ++i) {
      h[static_cast<std::size_t>(i)] = static_cast<double>(row[i - shift * lanes]);
    }
    for (std::int64_t lane = 0; shift != 0 && lane < lanes; ++lane) {
      const std::int64_t from = (lane - shift + lanes) % lanes;
      const std::int64_t to_vector = shift == 1 ? 0 : nx - lanes, from_vector = nx - lanes - to_vector;
      h[static_cast<std::size_t>(to_vector + lane)] = static_cast<double>(row[from_vector + from]);
    }
    if (lattice_.closed[0] && v[0] != 0) {
      const std::int64_t x = v[0] == 1 ? 0 : nx - 1;
      h[static_cast<std::size_t>(place_[static_cast<std::size_t>(x)])] =
          static_cast<double>(*slot(q, spec_.grid.index(x, y, z)));
    }
  }

  /// Added up in the order of density_deviation() and momentum().
  auto moments_of_rows() const {
    const auto nx = static_cast<std::size_t>(lattice_.nx);
    return [this, nx, h = std::vector<double>(nx), back = std::vector<double>(nx),
            sums = std::vector<double>(4 * nx)](std::int64_t y, std::int64_t z, RowMoments& row) mutable {
      double* const density = sums.data();
      arriving_row(0, y, z, h);
      std::fill(sums.begin(), sums.end(), 0.0);
      std::copy(h.begin(), h.end(), density);
      for (int q = 1; q < Q; q += 2) {
        arriving_row(q, y, z, h);
        arriving_row(q + 1, y, z, back);
        for (std::size_t i = 0; i < nx; ++i) density[i] += h[i] + back[i];
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const double along = c[static_cast<std::size_t>(q)][axis];
          double* const j = density + (axis + 1) * nx;
          for (std::size_t i = 0; along != 0.0 && i < nx; ++i) j[i] += (h[i] - back[i]) * along;
        }
      }
      for (std::size_t x = 0; x < nx; ++x) {
        const auto at = static_cast<std::size_t>(place_[x]);
        row.density_deviation[x] = density[at];
        for (std::size_t axis = 0; axis < 3; ++axis) row.momentum[axis][x] = density[(axis + 1) * nx + at];
      }
    };
  }

  /// A wall has turned back what leaves across an outflow.
  void let_out(const Outlet& outlet) {
    for (int q = 1; q < Q; ++q) {
      if ((outlet.out >> q & 1U) == 0) continue;
      *arriving(opposite(q), outlet.node) = static_cast<Real>(outlet.returned[static_cast<std::size_t>(q)]);
    }
  }

  /// Between the sweep and the exchange of cut links, a population that left a node along q stands where the
  /// opposite one came from.
  void add(const NodeForces& forces) {
    const auto count = static_cast<std::int64_t>(forces.nodes.size());
    // A slot is reached from one node only: threads do not meet.
#pragma omp parallel for schedule(static) if (count > 1000)
    for (std::int64_t i = 0; i < count; ++i) {
      const std::array<Real*, Q> slots = all_arriving(forces.nodes[static_cast<std::size_t>(i)]);
      const Vec3 g = forces.force->row(i);
      for (int q = 1; q < Q; ++q) {
        const double kick = (planted(Mutant::node_force_halved) ? 1.5 : 3.0) * w(q) * along(q, g);
        *slots[static_cast<std::size_t>(opposite(q))] += static_cast<Real>(kick);
      }
    }
  }

  Pages pages_;
  Lattice<Real> lattice_{};
  std::vector<std::int64_t> place_;  // of x in its row
  std::vector<bool> is_obstacle_;    // empty without one
  std::vector<SlotPair> links_;
  std::vector<Gain> gains_;
  std::vector<Outlet> outlets_;
};

}  // namespace

double population_bytes(const Spec& spec) {
  return static_cast<double>(Q) * static_cast<double>(stride_bytes(spec)) +
         static_cast<double>(end_bytes(spec));
}

std::unique_ptr<Fluid> make_population_fluid(const Spec& spec) {
  return visit(spec.storage, [&](auto real) -> std::unique_ptr<Fluid> {
    return std::make_unique<PopulationFluid<decltype(real)>>(spec);
  });
}

}  // namespace veriflex::fluid
