/// The fluid: D3Q15 BGK in a box, periodic or between walls, with obstacles and forces.
/// [wu-qi-2014, Sec. 2.I]
///
/// A module as seen from outside: what is asked for in a Spec, and a handful of calls per step. The loops
/// behind it are compiled for each storage, force scheme and kind of wall; what a scene does not have costs
/// nothing. At tau = 1 populations are such a thing: density and momentum say all that a collision keeps.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "base/grid.hpp"
#include "base/parts.hpp"
#include "base/vec.hpp"
#include "fluid/blocking.hpp"
#include "fluid/lattice.hpp"
#include "fluid/scheme.hpp"

namespace veriflex::fluid {

/// Fluid that enters at an end of an axis with a given velocity: half-way bounce-back at a wall that moves
/// through itself, so that what is given is the momentum of fluid of density 1. [ladd-1994]
struct Inflow {
  Vec3 velocity;           // [L T^-1]
  bool parabolic = false;  // 4 s (1 - s) of it at the part s of the way between the walls of each other axis
  double rise = 0.0;       // it rises as (1 - cos(pi t/rise))/2 until then  [T]

  /// Of the velocity, after so many steps.
  double risen(std::int64_t steps) const;
};

/// Fluid that leaves at an end of an axis, at a given density: what is carried on from the last two nodes,
/// and a share of the density that is missing.
struct Outflow {
  double density = 1.0;  // [M L^-3]
};

/// Half-way bounce-back walls at both ends of an axis: half a spacing outside the first and the last node. A
/// wall may move; only its motion along itself is meant. In the place of a wall there may be an opening.
/// Where two ends meet, the link across both belongs to the earlier axis.
struct Walls {
  Vec3 low_velocity = Vec3::Zero();                                         // [L T^-1]
  Vec3 high_velocity = Vec3::Zero();                                        // [L T^-1]
  std::array<std::variant<std::monostate, Inflow, Outflow>, 2> openings{};  // at the low and the high end
};

struct Spec {
  Grid grid;
  double relaxation_time;  // tau, more than 1/2  [T]
  Storage storage = Storage::Double;
  Vec3 body_force = Vec3::Zero();  // per volume  [M L^-2 T^-2]
  Scheme scheme = Scheme::FirstOrder;
  std::array<std::optional<Walls>, 3> walls{};  // absent: periodic
  /// Nodes inside of solid voxels, half-way bounce-back around them. They are at rest, whatever is asked of
  /// them: no force acts on them, and they are in no sum.
  std::vector<std::int64_t> obstacle{};
  Representation representation = Representation::Auto;
  /// How populations make many steps at once, see Fluid::advance(); absent: as the caches suggest. The
  /// results are the same, bit by bit.
  std::optional<Blocking> blocking{};
  /// Parts that are there although they do nothing, to show that they change nothing.
  struct Kept {
    bool body_force = false, obstacle = false;
  } kept{};

  bool is_forced() const { return kept.body_force || !body_force.isZero(0.0); }
  bool has_obstacle() const { return kept.obstacle || !obstacle.empty(); }
};

/// Populations or Moments: what this fluid is made of. Only tau = 1 can do without populations, and then
/// nothing else needs them: what walls, obstacles and forces do to a population they do to what leaves its
/// node. Fluid::populations() makes them out of the moments before the last step, and of those that a flow
/// was started from keeps a copy until the first step. Throws BadParameter ("fluid.representation").
Representation representation_of(const Spec& spec);

/// Whether there is neither an obstacle nor an opening, whose links are looked at after each step of all
/// nodes: populations can then make several steps at once.
bool is_made_row_by_row(const Spec& spec);

/// Axes with walls or openings at their ends.
std::array<bool, 3> closed(const Spec& spec);

/// The deviations f - w of one node.
using Populations = std::array<double, Q>;

/// Local equilibrium at density rho and velocity u, as deviations.
/// [wu-qi-2014, Eq. 2]
Populations equilibrium(double rho, const Vec3& u);

/// rho - 1, in the order in which a collision adds up.
double density_deviation(const Populations& h);

/// sum f c  [M L^-2 T^-1]
Vec3 momentum(const Populations& h);

/// Deviatoric and bulk viscous stress, -(1 - 1/(2 tau)) sum (f - f_eq) c c  [M L^-1 T^-2]. Without a force in
/// f_eq.
Mat3 viscous_stress(const Populations& h, double relaxation_time);

/// Forces at single nodes for one step; a node stands in the list once.
struct NodeForces {
  std::span<const std::int64_t> nodes;
  const Positions* force;  // one row per node  [M L^-2 T^-2]
};

/// Sums over all nodes outside of the obstacle.
struct Totals {
  double mass_deviation;    // sum (rho - 1)  [M]
  Vec3 momentum;            // [M L T^-1]
  Vec3 staggered_momentum;  // sum (-1)^(x+y+z+t) rho u: conserved by D3Q15 too, and should stay small
};

/// The worst nodes outside of the obstacle.
struct Extremes {
  double min_density;  // not a number as soon as any node's is not finite
  std::int64_t min_density_node;
  double max_speed;  // of sum f c / rho; not a number as soon as any node is not  [L T^-1]
  std::int64_t max_speed_node;
};

/// Everything that determines a flow from here on, beside its Spec. Between two steps it does not depend on
/// how the populations are stored.
struct State {
  std::int64_t steps;
  std::vector<Populations> populations;  // of each node; 0 inside of the obstacle
  /// Of each node, as a fluid of moments carries them: they differ from the populations' sums in the last
  /// bits and count instead of them. Empty from a fluid of populations.
  std::vector<std::array<double, 4>> moments{};
};

/// Several steps of a fluid with forces at single nodes: the rows of these nodes make them one after the
/// other ahead of all others, which then follow at once, bit by bit as if all had gone together.
class StepsAhead {
 public:
  virtual ~StepsAhead() = default;
  /// How many they may be; fewer are as good.
  virtual std::int64_t most() const = 0;
  /// Whether these rows, y + ny z of each, are among those that are ahead: only there are velocities and
  /// populations known and may forces act until the others have followed.
  virtual bool cover(std::span<const std::int64_t> rows) const = 0;
  /// One step of the rows ahead. Throws Stopped, as Fluid::collide_and_stream() does.
  virtual void collide_and_stream(const NodeForces& forces) = 0;
  /// The same steps of all others. Throws Stopped, and the fluid is then of no use.
  virtual void let_others_follow() = 0;
};

class Fluid {
 public:
  explicit Fluid(Spec spec) : spec_(std::move(spec)) {}
  Fluid(const Fluid&) = delete;
  Fluid& operator=(const Fluid&) = delete;
  virtual ~Fluid() = default;

  const Spec& spec() const { return spec_; }
  std::int64_t steps() const { return steps_; }

  /// Starts at step 0 from the deviations that `at` gives for each node; `at` is called by several threads.
  virtual void start(const std::function<Populations(std::int64_t node)>& at) = 0;

  virtual State state() const;
  /// Puts back a state of a fluid of the same box and storage: it goes on bit by bit as it would have there.
  virtual void restore(const State& state) = 0;

  /// One step. Throws nothing but Stopped, before it does anything: see extremes().
  virtual void collide_and_stream(const NodeForces& forces = {}) = 0;

  /// So many steps without forces at single nodes, bit by bit what as many single ones make of them. Throws
  /// Stopped before a step or in the midst of them, and the fluid is then of no use.
  virtual void advance(std::int64_t steps);

  /// How many steps advance() makes best at once: 1 where one after the other is as good. Populations of a
  /// box that no cache holds, without obstacle and openings, make several.
  virtual std::int64_t steps_at_once() const { return 1; }

  /// At most so many steps with forces in these rows, y + ny z of each; null where one step of all nodes
  /// after the other is as good. The fluid must outlive it and make no other step meanwhile.
  virtual std::unique_ptr<StepsAhead> steps_ahead(std::span<const std::int64_t>, std::int64_t) {
    return nullptr;
  }

  /// Populations of some nodes before the next collision.
  virtual void populations(std::span<const std::int64_t> nodes, std::span<Populations> h) const = 0;

  /// Velocity sum f c / rho of some nodes, one row each, before the next collision  [L T^-1].
  virtual void velocities(std::span<const std::int64_t> nodes, Positions& u) const = 0;

  /// Sums whose last bits do not depend on the number of threads.
  virtual Totals totals() const = 0;
  virtual Extremes extremes() const = 0;

 protected:
  /// Says what has been built: of the nodes themselves, at the ends of rows between walls, of an obstacle.
  struct Bytes {
    double nodes, walls, obstacle;
  };
  void tell_parts(const Bytes& bytes);

  Spec spec_;
  std::int64_t steps_ = 0;

 private:
  std::vector<parts::Built> parts_;
};

/// Memory of the populations or moments  [bytes].
double memory_bytes(const Spec& spec);

/// What a fluid of moments needs more until its first step when it is started from populations; 0 for one of
/// populations  [bytes].
double start_bytes(const Spec& spec);

/// Throws BadParameter ("fluid.nodes") when the fluid does not fit into the memory that is available now.
void require_memory(const Spec& spec);

/// The same of what start() needs more.
void require_start_memory(const Spec& spec);

/// A fluid at rest. Throws BadParameter ("fluid.relaxation_time", "fluid.representation", "fluid.nodes").
std::unique_ptr<Fluid> make_fluid(const Spec& spec);

}  // namespace veriflex::fluid
