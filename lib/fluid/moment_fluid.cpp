#include "fluid/moment_fluid.hpp"

#include <omp.h>

#include <algorithm>

#include "base/memory.hpp"
#include "base/mutant.hpp"
#include "base/stop.hpp"
#include "base/work.hpp"
#include "fluid/links.hpp"
#include "fluid/moment_sweep.hpp"
#include "fluid/reductions.hpp"
#include "fluid/sweep.hpp"
#include "fluid/threads.hpp"

namespace veriflex::fluid {

namespace {

/// Bytes from one copy of the moments to the other. The low bits of equal places differ, as in the fluid of
/// populations.
std::int64_t copy_bytes(const Spec& spec) {
  constexpr std::int64_t page = 4096, cache_line = 64;
  const std::int64_t bytes = 4 * spec.grid.count() * bytes_of(spec.storage);
  return (bytes + page - 1) / page * page + 5 * cache_line;
}

std::int64_t thread_bytes(const Spec& spec) {
  return visit(spec.storage, [&](auto real) {
    return scratch_size<decltype(real)>(spec.grid.size[0], spec.grid.size[1]) *
           static_cast<std::int64_t>(sizeof real);
  });
}

/// The force on one node in the last step.
struct Push {
  std::int64_t node;
  Vec3 force;  // [M L^-2 T^-2]
};

/// What a force g adds to the population that leaves its node along q.
double kick(int q, const Vec3& g) {
  return (planted(Mutant::moment_push_halved) ? 1.5 : 3.0) * w(q) * along(q, g);
}

template <class Real>
class MomentFluid final : public Fluid {
 public:
  explicit MomentFluid(const Spec& wanted)
      : Fluid(wanted), pages_(allocate_pages(static_cast<std::size_t>(2 * copy_bytes(wanted)))) {
    describe<Real>(spec_, lattice_);
    const Vec3& g = spec_.body_force;
    lattice_.law = visit(spec_.scheme, [&](auto force) {
      return moment_force<decltype(force), Real>({g[0], g[1], g[2]});
    });
    // What fits the third-level cache is better left there.
    constexpr std::int64_t cached = std::int64_t{1} << 20;
    lattice_.streams = lattice_.lanes == lanes_for<Real>(64) && 2 * copy_bytes(spec_) > cached;
    for (std::int64_t x = 0; x < lattice_.nx; ++x) place_.push_back(lattice_.place(x, 0));
    gains_ = gains_of(spec_);
    is_obstacle_ = inside_of(spec_);
    shores_ = shores_of(spec_, is_obstacle_);
    outlets_ = outlets_of(spec_, is_obstacle_);
    leave_node(lattice_, {}, leaving_obstacle_);
    provide_scratch();
    stop_if_asked("fluid step", 0);
    tell_parts({.nodes = moment_bytes(spec_),
                .walls = parts::array_bytes(gains_, outlets_),
                .obstacle = parts::array_bytes(is_obstacle_, shores_)});
  }

  void start(const std::function<Populations(std::int64_t)>& at) override {
    steps_ = 0;
    put(at);
    stop_if_asked("fluid step", 0);
  }

  State state() const override {
    State state = Fluid::state();
    state.moments.resize(state.populations.size());
    const std::int64_t count = spec_.grid.count();
#pragma omp parallel for schedule(static)
    for (std::int64_t node = 0; node < count; ++node) {
      for (std::size_t k = 0; k < 4; ++k) {
        state.moments[static_cast<std::size_t>(node)][k] = static_cast<double>(present(node)[stride(k)]);
      }
    }
    return state;
  }

  void restore(const State& state) override {
    steps_ = state.steps;
    put([&](std::int64_t node) { return state.populations[static_cast<std::size_t>(node)]; });
    if (!state.moments.empty() && !planted(Mutant::moments_not_restored)) {
      const std::int64_t count = spec_.grid.count();
#pragma omp parallel for schedule(static)
      for (std::int64_t node = 0; node < count; ++node) {
        for (std::size_t k = 0; k < 4; ++k) {
          present(node)[stride(k)] = static_cast<Real>(state.moments[static_cast<std::size_t>(node)][k]);
        }
      }
    }
    stop_if_asked("fluid step", steps_);
  }

  void collide_and_stream(const NodeForces& forces) override {
    stop_if_asked("fluid step", steps_ + 1);
    work::add_nodes(static_cast<std::uint64_t>(spec_.grid.count()),
                    2 * 4 * static_cast<std::uint64_t>(bytes_of(spec_.storage)));
    provide_scratch();
    prepare(outlets_, [this](std::int64_t node) { return arriving(node); });
    given_.reset();
    given_part_ = parts::Built();  // not = {}: in a template clang 14 leaves that argument undestroyed
    lattice_.from = copy(present_);
    lattice_.to = copy(1 - present_);
    sweep(lattice_);
    stop_if_asked("fluid step", steps_ + 1);  // a sweep that saw it is not whole
    turn_back_at_obstacle();
    present_ = 1 - present_;
    stepped_ = true;
    ++steps_;
    for (const Gain& gain : gains_) add(gain.node, gain.q, gained(gain));
    add(forces);
    for (const Outlet& outlet : outlets_) let_out(outlet);
    for (const std::int64_t node : spec_.obstacle) {
      for (std::size_t k = 0; k < 4; ++k) present(node)[stride(k)] = Real(0);
    }
  }

  void populations(std::span<const std::int64_t> nodes, std::span<Populations> h) const override {
    const auto count = static_cast<std::int64_t>(nodes.size());
#pragma omp parallel for schedule(static) if (count >= worth_threads)
    for (std::int64_t i = 0; i < count; ++i) {
      h[static_cast<std::size_t>(i)] = arriving(nodes[static_cast<std::size_t>(i)]);
    }
  }

  void velocities(std::span<const std::int64_t> nodes, Positions& u) const override {
    const auto count = static_cast<std::int64_t>(nodes.size());
    u.resize(count, 3);
#pragma omp parallel for schedule(static) if (count >= worth_threads)
    for (std::int64_t i = 0; i < count; ++i) {
      const Moments here = moments(nodes[static_cast<std::size_t>(i)]);
      u.row(i) = here.momentum.transpose() / (1.0 + here.density_deviation);
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
  Real* copy(int which) const { return reinterpret_cast<Real*>(pages_.get() + which * copy_bytes(spec_)); }
  std::ptrdiff_t stride(std::size_t k) const { return static_cast<std::ptrdiff_t>(k) * lattice_.lanes; }

  /// The first moment of a node in a copy; the others stand a stride further each.
  Real* at(int which, std::int64_t node) const {
    const std::int64_t x = node % lattice_.nx;
    return copy(which) + 4 * (node - x) + place_[static_cast<std::size_t>(x)];
  }
  Real* present(std::int64_t node) const { return at(present_, node); }

  bool inside(std::int64_t node) const {
    return !is_obstacle_.empty() && is_obstacle_[static_cast<std::size_t>(node)];
  }

  Moments moments(std::int64_t node) const {
    const Real* const M = present(node);
    const auto moment = [&](std::size_t k) { return static_cast<double>(M[stride(k)]) / moment_scale; };
    return {moment(0), Vec3(moment(1), moment(2), moment(3))};
  }

  auto moments_of_rows() const {
    const auto nx = static_cast<std::size_t>(lattice_.nx), lanes = static_cast<std::size_t>(lattice_.lanes);
    return [this, nx, lanes, sums = std::vector<double>(4 * nx)](std::int64_t y, std::int64_t z,
                                                                 RowMoments& row) mutable {
      const Real* const M = copy(present_) + 4 * lattice_.nx * (y + lattice_.ny * z);
      for (std::size_t i = 0; i < 4 * nx; ++i) sums[i] = static_cast<double>(M[i]) / moment_scale;
      for (std::size_t x = 0; x < nx; ++x) {
        const double* const at = sums.data() + place_[x];
        row.density_deviation[x] = at[0];
        for (std::size_t axis = 0; axis < 3; ++axis) row.momentum[axis][x] = at[(axis + 1) * lanes];
      }
    };
  }

  void provide_scratch() {
    const int threads = omp_get_max_threads();
    if (threads <= scratch_threads_) return;
    scratch_ = allocate_pages(static_cast<std::size_t>(threads * thread_bytes(spec_)));
    scratch_threads_ = threads;
    lattice_.scratch = reinterpret_cast<Real*>(scratch_.get());
  }

  /// Populations of each node before the step to come, and their moments.
  template <class At>
  void put(const At& populations_at) {
    require_start_memory(spec_);
    const Grid& grid = spec_.grid;
    given_ = allocate_pages(static_cast<std::size_t>(grid.count()) * sizeof(Populations));
    given_part_ = parts::Built(parts::Kind::InitialFlow, start_bytes(spec_));
    stepped_ = false;
#pragma omp parallel for
    for (std::int64_t row = 0; row < grid.size[1] * grid.size[2]; ++row) {
      if (stop::asked()) continue;
      for (std::int64_t x = 0; x < grid.size[0]; ++x) {
        const std::int64_t node = grid.size[0] * row + x;
        const Populations h = inside(node) ? Populations{} : populations_at(node);
        given()[node] = h;
        const Vec3 j = momentum(h);
        Real* const M = present(node);
        M[0] = static_cast<Real>(moment_scale * density_deviation(h));
        for (std::size_t axis = 0; axis < 3; ++axis) {
          M[stride(axis + 1)] = static_cast<Real>(moment_scale * j[static_cast<Eigen::Index>(axis)]);
        }
      }
    }
  }

  Populations* given() const { return reinterpret_cast<Populations*>(given_.get()); }

  /// Adds to the population q that arrives at a node.
  void add(std::int64_t node, int q, double value) { add(present(node), q, value); }
  void add(Real* M, int q, double value) const {
    const auto& v = c[static_cast<std::size_t>(q)];
    const double scaled = moment_scale * value;
    M[0] += static_cast<Real>(scaled);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (v[axis] != 0) M[stride(axis + 1)] += static_cast<Real>(v[axis] * scaled);
    }
  }

  /// Obstacles stay at rest in the sweep, so that nothing leaves them but what the body force makes of rest;
  /// in its place comes what the fluid's own node sent.
  void turn_back_at_obstacle() {
    const auto count = static_cast<std::int64_t>(shores_.size());
#pragma omp parallel for schedule(static) if (count > 1000)
    for (std::int64_t i = 0; i < count; ++i) {
      const Shore& shore = shores_[static_cast<std::size_t>(i)];
      Real H[Q];
      leave(present_, shore.node, H);
      Real sum[4] = {};
      for (int q = 1; q < Q; ++q) {
        if ((shore.cut >> q & 1U) == 0) continue;
        const int back = opposite(q);
        const Real more = H[q] - leaving_obstacle_[back];
        sum[0] += more;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          sum[axis + 1] += Real(c[static_cast<std::size_t>(back)][axis]) * more;
        }
      }
      Real* const M = at(1 - present_, shore.node);
      for (std::size_t k = 0; k < 4; ++k) M[stride(k)] += sum[k];
    }
  }

  double gained(const Gain& gain) const {
    return gain.inflow != nullptr ? gain.inflow->risen(steps_) * gain.value : gain.value;
  }

  /// What leaves a node along q in the last step, with the force on it.
  double left(std::int64_t node, int q) const {
    Real H[Q];
    leave(1 - present_, node, H);
    return static_cast<double>(H[q]) / moment_scale + kick(q, pushed(node));
  }

  /// A wall has turned back what leaves across an outflow.
  void let_out(const Outlet& outlet) {
    for (int q = 1; q < Q; ++q) {
      if ((outlet.out >> q & 1U) == 0) continue;
      add(outlet.node, opposite(q), outlet.returned[static_cast<std::size_t>(q)] - left(outlet.node, q));
    }
  }

  /// What leaves a node of one of the copies.
  void leave(int which, std::int64_t node, Real (&H)[Q]) const {
    const Real* const from = at(which, node);
    const Real M[4] = {from[0], from[stride(1)], from[stride(2)], from[stride(3)]};
    leave_node(lattice_, M, H);
  }

  /// The force on a node in the last step.
  Vec3 pushed(std::int64_t node) const {
    const auto push = std::lower_bound(pushes_.begin(), pushes_.end(), node,
                                       [](const Push& a, std::int64_t b) { return a.node < b; });
    return push != pushes_.end() && push->node == node ? push->force : Vec3(Vec3::Zero());
  }

  /// Made again from the moments before the last step and its forces.
  Populations arriving(std::int64_t node) const {
    if (inside(node)) return {};
    if (!stepped_) return given_ ? given()[node] : Populations{};
    const auto here = spec_.grid.node(node);
    Populations h;
    for (int q = 0; q < Q; ++q) {
      std::int64_t source = node;
      int direction = opposite(q);  // of what comes back from a wall or an obstacle
      if (crossed_wall(spec_, here, q, -1) < 0) {
        const std::int64_t before = neighbour(spec_.grid, here, q, -1);
        if (!inside(before)) {
          source = before;
          direction = q;
        }
      }
      h[static_cast<std::size_t>(q)] = left(source, direction);
    }
    for (auto gain = std::lower_bound(gains_.begin(), gains_.end(), node,
                                      [](const Gain&a, std::int64_t b) { return a.node < b; });
         gain != gains_.end() && gain->node == node; ++gain) {
      h[static_cast<std::size_t>(gain->q)] += gained(*gain);
    }
    const auto outlet = std::lower_bound(outlets_.begin(), outlets_.end(), node,
                                         [](const Outlet& a, std::int64_t b) { return a.node < b; });
    if (outlet == outlets_.end() || outlet->node != node) return h;
    for (int q = 1; q < Q; ++q) {
      double& back = h[static_cast<std::size_t>(opposite(q))];
      if ((outlet->out >> q & 1U) != 0) back = outlet->returned[static_cast<std::size_t>(q)];
    }
    return h;
  }

  /// Forces act on what leaves their nodes: on the moments of their neighbours.
  void add(const NodeForces& forces) {
    pushes_.clear();
    for (std::size_t i = 0; i < forces.nodes.size(); ++i) {
      if (inside(forces.nodes[i])) continue;
      pushes_.push_back({forces.nodes[i], forces.force->row(static_cast<Eigen::Index>(i))});
    }
    const auto before = [](const Push& a, const Push& b) { return a.node < b.node; };
    if (!std::is_sorted(pushes_.begin(), pushes_.end(), before)) {
      std::sort(pushes_.begin(), pushes_.end(), before);
    }
    // Several forces meet at a node: each thread adds all that comes to planes of its own, in the order of
    // the list.
#pragma omp parallel if (pushes_.size() > 1000)
    {
      const auto threads = static_cast<unsigned>(omp_get_num_threads());
      const auto thread = static_cast<unsigned>(omp_get_thread_num());
      const auto mine = [=](std::int64_t z) { return static_cast<unsigned>(z) % threads == thread; };
      const bool open = is_obstacle_.empty() && !spec_.walls[0] && !spec_.walls[1] && !spec_.walls[2];
      for (const Push& push : pushes_) open ? add_in_open(push, mine) : add(push, mine);
    }
  }

  template <class Mine>
  void add(const Push& push, const Mine& mine) {
    const Grid& grid = spec_.grid;
    const auto here = grid.node(push.node);
    for (int q = 1; q < Q; ++q) {
      std::int64_t target = push.node;
      std::int64_t z = here[2];
      int direction = opposite(q);  // turned back by a wall or an obstacle
      if (crossed_wall(spec_, here, q) < 0) {
        const std::int64_t beyond = neighbour(grid, here, q);
        if (!inside(beyond)) {
          target = beyond;
          z = grid.wrap(here[2] + velocity(q)[2], 2);
          direction = q;
        }
      }
      if (mine(z)) add(target, direction, kick(q, push.force));
    }
  }

  /// The same where nothing turns anything back: no link has to be asked for.
  template <class Mine>
  void add_in_open(const Push& push, const Mine& mine) {
    const Grid& grid = spec_.grid;
    const auto [x, y, z] = grid.node(push.node);
    // Of the neighbours at -1, 0 and 1 along each axis: whose plane it is, where its row begins, its place in
    // it.
    bool is_mine[3];
    std::int64_t row[3][3], in_row[3];
    for (int k = 0; k < 3; ++k) {
      const std::int64_t plane = grid.wrap(z + k - 1, 2);
      is_mine[k] = mine(plane);
      for (int j = 0; j < 3; ++j) row[k][j] = grid.index(0, grid.wrap(y + j - 1, 1), plane);
      in_row[k] = place_[static_cast<std::size_t>(grid.wrap(x + k - 1, 0))];
    }
    for (int q = 1; q < Q; ++q) {
      const auto& v = c[static_cast<std::size_t>(q)];
      if (!is_mine[v[2] + 1]) continue;
      add(copy(present_) + 4 * row[v[2] + 1][v[1] + 1] + in_row[v[0] + 1], q, kick(q, push.force));
    }
  }

  Pages pages_;
  Pages scratch_;
  int scratch_threads_ = 0;
  MomentLattice<Real> lattice_{};
  int present_ = 0;       // the copy that holds the moments before the step to come
  bool stepped_ = false;  // whether the other holds those before the last one
  parts::Built given_part_;
  Pages given_;                      // populations that the flow was started from, until its first step
  std::vector<std::int64_t> place_;  // of x in its row
  std::vector<bool> is_obstacle_;    // empty without one
  std::vector<Shore> shores_;
  Real leaving_obstacle_[Q];
  std::vector<Gain> gains_;
  std::vector<Outlet> outlets_;
  std::vector<Push> pushes_;  // of the last step, in the order of the nodes
};

}  // namespace

double moment_bytes(const Spec& spec) {
  return 2.0 * static_cast<double>(copy_bytes(spec)) +
         static_cast<double>(omp_get_max_threads()) * static_cast<double>(thread_bytes(spec));
}

std::unique_ptr<Fluid> make_moment_fluid(const Spec& spec) {
  return visit(spec.storage, [&](auto real) -> std::unique_ptr<Fluid> {
    return std::make_unique<MomentFluid<decltype(real)>>(spec);
  });
}

}  // namespace veriflex::fluid
