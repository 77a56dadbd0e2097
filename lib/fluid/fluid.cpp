#include "fluid/fluid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.hpp"
#include "base/memory.hpp"
#include "base/reduce.hpp"
#include "base/stop.hpp"
#include "base/work.hpp"
#include "fluid/sweep.hpp"

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

constexpr std::array<std::int64_t, 3> velocity(int q) {
  const auto& v = c[static_cast<std::size_t>(q)];
  return {v[0], v[1], v[2]};
}

/// A link that an obstacle cuts. After a step, be it even or odd, what each end sent along the link
/// stands where the other end will look for it, so the two slots are exchanged. The inside of an obstacle is
/// a closed fluid of its own from which nothing leaks, so that the sweep treats no node apart; nobody is
/// shown it: seen from outside an obstacle's nodes are at rest.
struct CutLink {
  std::int64_t node, beyond;  // beyond = node + c(q), wrapped
  int q;                      // of a first-of-pair direction
};

/// 6 w c.u_wall, what a moving wall adds to the population q that comes back to `node`.
struct Gain {
  std::int64_t node;
  int q;
  double value;
};

/// The first axis whose wall the link from `at` along sign c(q) crosses, or -1.
int crossed_wall(const Spec& spec, const std::array<std::int64_t, 3>& at, int q, int sign = 1) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t to = at[axis] + sign * velocity(q)[axis];
    if (spec.walls[axis] && (to < 0 || to >= spec.grid.size[axis])) return static_cast<int>(axis);
  }
  return -1;
}

std::int64_t neighbour(const Grid& grid, const std::array<std::int64_t, 3>& at, int q, int sign = 1) {
  const auto v = velocity(q);
  return grid.index(grid.wrap(at[0] + sign * v[0], 0), grid.wrap(at[1] + sign * v[1], 1),
                    grid.wrap(at[2] + sign * v[2], 2));
}

void add_gains_of(const Spec& spec, std::int64_t node, std::vector<Gain>& gains) {
  const auto at = spec.grid.node(node);
  for (int q = 1; q < Q; ++q) {
    const int axis = crossed_wall(spec, at, q);
    if (axis < 0) continue;
    const auto a = static_cast<std::size_t>(axis);
    const Walls& walls = *spec.walls[a];
    const bool high = velocity(q)[a] > 0;
    const Vec3& u = high ? walls.high_velocity : walls.low_velocity;
    const auto back = velocity(opposite(q));
    const double along = static_cast<double>(back[0]) * u[0] + static_cast<double>(back[1]) * u[1] +
                         static_cast<double>(back[2]) * u[2];
    if (along != 0.0) gains.push_back({node, opposite(q), 6.0 * w(q) * along});
  }
}

/// Of all walls that move.
std::vector<Gain> gains_of(const Spec& spec) {
  const Grid& grid = spec.grid;
  std::vector<std::int64_t> near;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::optional<Walls>& walls = spec.walls[axis];
    if (!walls || (walls->low_velocity.isZero(0.0) && walls->high_velocity.isZero(0.0))) continue;
    const std::size_t a = axis == 0 ? 1 : 0;
    const std::size_t b = axis == 2 ? 1 : 2;
    for (std::int64_t j = 0; j < grid.size[b]; ++j) {
      for (std::int64_t i = 0; i < grid.size[a]; ++i) {
        std::array<std::int64_t, 3> at{};
        at[a] = i;
        at[b] = j;
        near.push_back(grid.index(at[0], at[1], at[2]));
        at[axis] = grid.size[axis] - 1;
        near.push_back(grid.index(at[0], at[1], at[2]));
      }
    }
  }
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  std::vector<Gain> gains;
  for (const std::int64_t node : near) add_gains_of(spec, node, gains);
  return gains;
}

/// Links between the obstacle and the fluid; those that cross a wall are the sweep's own matter.
std::vector<CutLink> links_of(const Spec& spec, const std::vector<bool>& is_obstacle) {
  std::vector<CutLink> links;
  for (const std::int64_t node : spec.obstacle) {
    const auto at = spec.grid.node(node);
    for (int q = 1; q < Q; ++q) {
      if (crossed_wall(spec, at, q) >= 0) continue;
      const std::int64_t beyond = neighbour(spec.grid, at, q);
      if (is_obstacle[static_cast<std::size_t>(beyond)]) continue;
      const bool first_of_pair = q % 2 == 1;
      links.push_back(first_of_pair ? CutLink{node, beyond, q} : CutLink{beyond, node, opposite(q)});
    }
  }
  return links;
}

template <class Real>
class FluidOf final : public Fluid {
 public:
  explicit FluidOf(const Spec& wanted)
      : Fluid(wanted), pages_(allocate_pages(static_cast<std::size_t>(memory_bytes(wanted)))) {
    const Grid& grid = spec_.grid;
    for (int q = 0; q < Q; ++q) {
      lattice_.slots[q] = reinterpret_cast<Real*>(pages_.get() + q * stride_bytes(spec_));
    }
    lattice_.ends = reinterpret_cast<Real*>(pages_.get() + Q * stride_bytes(spec_));
    lattice_.nx = grid.size[0];
    lattice_.ny = grid.size[1];
    lattice_.nz = grid.size[2];
    lattice_.lanes = lanes_for<Real>(grid.size[0]);
    const Vec3& g = spec_.body_force;
    lattice_.forced = !g.isZero(0.0);
    lattice_.scheme = spec_.scheme;
    lattice_.law = visit(spec_.scheme, [&](auto force) {
      return collision<decltype(force), Real>(spec_.relaxation_time, {g[0], g[1], g[2]});
    });
    for (std::size_t axis = 0; axis < 3; ++axis) lattice_.closed[axis] = spec_.walls[axis].has_value();
    for (std::int64_t x = 0; x < grid.size[0]; ++x) place_.push_back(lattice_.place(x));
    gains_ = gains_of(spec_);
    if (!spec_.obstacle.empty()) is_obstacle_.resize(static_cast<std::size_t>(grid.count()));
    for (const std::int64_t node : spec_.obstacle) is_obstacle_[static_cast<std::size_t>(node)] = true;
    for (const CutLink& link : links_of(spec_, is_obstacle_)) {
      links_.push_back({slot(opposite(link.q), link.node) - base(), slot(link.q, link.beyond) - base()});
    }
    start([](std::int64_t) { return Populations{}; });
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
    work::add_nodes(static_cast<std::uint64_t>(spec_.grid.count()),
                    2 * Q * static_cast<std::uint64_t>(bytes_of(spec_.storage)));
    sweep(lattice_, odd());
    add(forces);
    ++steps_;
    const auto links = static_cast<std::int64_t>(links_.size());
#pragma omp parallel for schedule(static) if (links > 1000)
    for (std::int64_t i = 0; i < links; ++i) {
      const SlotPair& pair = links_[static_cast<std::size_t>(i)];
      std::swap(*(base() + pair.first), *(base() + pair.second));
    }
    for (const Gain& gain : gains_) *arriving(gain.q, gain.node) += static_cast<Real>(gain.value);
  }

  void populations(std::span<const std::int64_t> nodes, std::span<Populations> h) const override {
    const auto count = static_cast<std::int64_t>(nodes.size());
#pragma omp parallel for schedule(static)
    for (std::int64_t i = 0; i < count; ++i) {
      const std::int64_t node = nodes[static_cast<std::size_t>(i)];
      h[static_cast<std::size_t>(i)] = inside(node) ? Populations{} : arriving(node);
    }
  }

  void velocities(std::span<const std::int64_t> nodes, Positions& u) const override {
    const auto count = static_cast<std::int64_t>(nodes.size());
    u.resize(count, 3);
#pragma omp parallel for schedule(static)
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
    const Grid& grid = spec_.grid;
    std::vector<Totals> planes(static_cast<std::size_t>(grid.size[2]),
                               Totals{0.0, Vec3::Zero(), Vec3::Zero()});
#pragma omp parallel for schedule(static)
    for (std::int64_t z = 0; z < grid.size[2]; ++z) {
      Totals& sum = planes[static_cast<std::size_t>(z)];
      for (std::int64_t node = grid.index(0, 0, z); node < grid.index(0, 0, z + 1); ++node) {
        if (inside(node)) continue;
        const Populations h = arriving(node);
        const auto [x, y, ignored] = grid.node(node);
        const Vec3 j = momentum(h);
        sum.mass_deviation += density_deviation(h);
        sum.momentum += j;
        sum.staggered_momentum += (x + y + z + steps_) % 2 == 0 ? j : Vec3(-j);
      }
    }
    Totals total{0.0, Vec3::Zero(), Vec3::Zero()};
    for (const Totals& sum : planes) {
      total.mass_deviation += sum.mass_deviation;
      total.momentum += sum.momentum;
      total.staggered_momentum += sum.staggered_momentum;
    }
    return total;
  }

  Extremes extremes() const override {
    const Grid& grid = spec_.grid;
    std::vector<Extremes> planes(static_cast<std::size_t>(grid.size[2]));
#pragma omp parallel for schedule(static)
    for (std::int64_t z = 0; z < grid.size[2]; ++z) {
      const std::int64_t from = grid.index(0, 0, z);
      Extremes worst{INFINITY, from, 0.0, from};
      for (std::int64_t node = from; node < grid.index(0, 0, z + 1); ++node) {
        if (inside(node)) continue;
        const Populations h = arriving(node);
        const double rho = 1.0 + density_deviation(h);
        keep_worse(worst, {std::isfinite(rho) ? rho : NAN, node, momentum(h).norm() / rho, node});
      }
      planes[static_cast<std::size_t>(z)] = worst;
    }
    Extremes worst = planes.front();
    for (const Extremes& plane : planes) keep_worse(worst, plane);
    return worst;
  }

 private:
  struct SlotPair {
    std::int64_t first, second;  // from base()
  };

  /// Populations of each node before the step to come.
  template <class At>
  void put(const At& at) {
    const Grid& grid = spec_.grid;
    // Each slot belongs to one node and direction: threads do not meet.
#pragma omp parallel for
    for (std::int64_t z = 0; z < grid.size[2]; ++z) {
      for (std::int64_t y = 0; y < grid.size[1]; ++y) {
        if (stop::signal.load(std::memory_order_relaxed) != 0) continue;  // nothing may be thrown in here
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

  Populations arriving(std::int64_t node) const {
    Populations h;
    for (int q = 0; q < Q; ++q) h[static_cast<std::size_t>(q)] = static_cast<double>(*arriving(q, node));
    return h;
  }

  bool inside(std::int64_t node) const {
    return !is_obstacle_.empty() && is_obstacle_[static_cast<std::size_t>(node)];
  }

  /// The first of two that are equally bad stays.
  static void keep_worse(Extremes& worst, const Extremes& other) {
    const auto replaces = [](double now, double by, double kept) {
      return !std::isnan(now) && (std::isnan(by) || kept != now);
    };
    const double density = lesser(worst.min_density, other.min_density);
    if (replaces(worst.min_density, other.min_density, density)) {
      worst.min_density = density;
      worst.min_density_node = other.min_density_node;
    }
    const double speed = worse(worst.max_speed, other.max_speed);
    if (replaces(worst.max_speed, other.max_speed, speed)) {
      worst.max_speed = speed;
      worst.max_speed_node = other.max_speed_node;
    }
  }

  /// Between the sweep and the exchange of cut links, a population that left `node` along q stands where its
  /// target would find it without obstacles.
  void add(const NodeForces& forces) {
    const auto count = static_cast<std::int64_t>(forces.nodes.size());
    // A slot is reached from one node only: threads do not meet.
#pragma omp parallel for schedule(static) if (count > 1000)
    for (std::int64_t i = 0; i < count; ++i) {
      const std::int64_t node = forces.nodes[static_cast<std::size_t>(i)];
      const auto at = spec_.grid.node(node);
      const Vec3 g = forces.force->row(i);
      for (int q = 1; q < Q; ++q) {
        const auto v = velocity(q);
        const double kick = 3.0 * w(q) *
                            (g[0] * static_cast<double>(v[0]) + g[1] * static_cast<double>(v[1]) +
                             g[2] * static_cast<double>(v[2]));
        const bool stays = !odd() || crossed_wall(spec_, at, q) >= 0;
        Real* const target = stays ? slot(opposite(q), node) : slot(q, neighbour(spec_.grid, at, q));
        *target += static_cast<Real>(kick);
      }
    }
  }

  Pages pages_;
  Lattice<Real> lattice_{};
  std::vector<std::int64_t> place_;  // of x in its row
  std::vector<bool> is_obstacle_;    // empty without one
  std::vector<SlotPair> links_;
  std::vector<Gain> gains_;
};

}  // namespace

std::array<bool, 3> closed(const Spec& spec) {
  return {spec.walls[0].has_value(), spec.walls[1].has_value(), spec.walls[2].has_value()};
}

Populations equilibrium(double rho, const Vec3& u) {
  Populations h;
  for (int q = 0; q < Q; ++q) {
    const auto v = velocity(q);
    const double cu = static_cast<double>(v[0]) * u[0] + static_cast<double>(v[1]) * u[1] +
                      static_cast<double>(v[2]) * u[2];
    h[static_cast<std::size_t>(q)] =
        w(q) * ((rho - 1.0) + rho * (3.0 * cu + 4.5 * cu * cu - 1.5 * u.squaredNorm()));
  }
  return h;
}

double density_deviation(const Populations& h) {
  double sum = h[0];
  for (std::size_t q = 1; q < Q; q += 2) sum += h[q] + h[q + 1];
  return sum;
}

Vec3 momentum(const Populations& h) {
  Vec3 j = Vec3::Zero();
  for (std::size_t q = 1; q < Q; q += 2) {
    const double along = h[q] - h[q + 1];
    for (int axis = 0; axis < 3; ++axis) j[axis] += along * c[q][static_cast<std::size_t>(axis)];
  }
  return j;
}

Mat3 viscous_stress(const Populations& h, double relaxation_time) {
  const double rho = 1.0 + density_deviation(h);
  const Populations rest = equilibrium(rho, momentum(h) / rho);
  Mat3 sum = Mat3::Zero();
  for (std::size_t q = 1; q < Q; ++q) {
    const Vec3 v(c[q][0], c[q][1], c[q][2]);
    sum += (h[q] - rest[q]) * v * v.transpose();
  }
  return -(1.0 - 0.5 / relaxation_time) * sum;
}

State Fluid::state() const {
  std::vector<std::int64_t> nodes(static_cast<std::size_t>(spec_.grid.count()));
  std::iota(nodes.begin(), nodes.end(), std::int64_t{0});
  State state{steps_, std::vector<Populations>(nodes.size())};
  populations(nodes, state.populations);
  return state;
}

double memory_bytes(const Spec& spec) {
  return static_cast<double>(Q) * static_cast<double>(stride_bytes(spec)) +
         static_cast<double>(end_bytes(spec));
}

void require_memory(const Spec& spec) {
  const double needed = memory_bytes(spec);
  const double available = available_memory_bytes();
  if (needed <= available) return;
  const auto [nx, ny, nz] = spec.grid.size;
  throw BadParameter(
      "fluid.nodes", fmt::format("a box of {} x {} x {} nodes does not fit into memory", nx, ny, nz),
      fmt::format("its populations take {:.3g} GB, {:.3g} GB are available", needed * 1e-9, available * 1e-9),
      spec.storage == Storage::Double ? "Use fewer nodes, or storage = \"float\" for half of it"
                                      : "Use fewer nodes");
}

std::unique_ptr<Fluid> make_fluid(const Spec& spec) {
  if (!(spec.relaxation_time > 0.5)) {
    throw BadParameter("fluid.relaxation_time", fmt::format("'relaxation_time' is {}", spec.relaxation_time),
                       "the viscosity (tau - 1/2)/3 must be positive", "Use more than 0.5, for example 1.0");
  }
  require_memory(spec);
  return visit(spec.storage, [&](auto real) -> std::unique_ptr<Fluid> {
    return std::make_unique<FluidOf<decltype(real)>>(spec);
  });
}

}  // namespace veriflex::fluid
