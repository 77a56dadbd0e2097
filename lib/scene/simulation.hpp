/// A scene in motion: one step as the method section writes it.                    [wu-qi-2014, Eqs. 8-12]
///
/// Within a step: velocities are interpolated at the present markers of all bodies from the same present
/// populations; each body moves under its internal forces and F_int = rho_f V (u_f - u_s); - F_int, its mean
/// over the sub-steps, is spread where u_f was interpolated, and at nodes under several bodies the reactions
/// add up; the fluid collides and streams. A scene without fluid, or without bodies, makes the same step with
/// what it has.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "coupling/summed.hpp"
#include "scene/moving_body.hpp"

namespace veriflex::scene {

/// Everything that determines a run of a scene from here on.
struct State {
  std::int64_t steps;
  std::optional<fluid::State> fluid;  // absent in a scene without one
  std::vector<MovingBody::State> bodies;
};

/// The same force on every node outside of the obstacle, which changes with time.
class UniformForce {
 public:
  UniformForce(const fluid::Spec& fluid, std::function<Vec3(std::int64_t step)> force);
  /// At that step, until the next call.
  fluid::NodeForces at(std::int64_t step);

 private:
  std::function<Vec3(std::int64_t)> force_;
  std::vector<std::int64_t> nodes_;
  Positions on_nodes_;
  parts::Built part_;
};

class Simulation {
 public:
  /// The bodies as they start, in the scene's initial flow. Throws BadParameter and
  /// NumericalFailure.
  explicit Simulation(Scene scene);

  /// So many steps. `after_each` is called after each of them where there is a body: it may look at bodies,
  /// but not at the fluid, which may be a block of steps behind. Throws NumericalFailure with the step when a
  /// bond, an angle or a marker leaves its range.
  void advance(std::int64_t steps = 1, const std::function<void()>& after_each = {});

  /// How many steps advance() makes best at once; the results are the same. 1 without a fluid, or where a
  /// force acts on all of its nodes.
  std::int64_t steps_at_once() const;

  /// The state between two steps, and back to one of the same scene: the run then goes on bit by bit as it
  /// went from there. What the last step exchanged is no part of it and is not known until the next.
  State state() const;
  void restore(const State& state);

  std::int64_t steps() const { return steps_; }
  bool has_fluid() const { return fluid_ != nullptr; }
  const fluid::Fluid& fluid() const { return *fluid_; }
  std::size_t body_count() const { return bodies_.size(); }
  const MovingBody& body(std::size_t i = 0) const { return *bodies_[i]; }

  /// rho u of the fluid and m v of the bodies together; conserved in a periodic box when no coordinate is
  /// held, driven or loaded and no motion given  [M L T^-1].
  Vec3 momentum() const;

  struct Spent {
    double wall = 0.0;
    double cpu = 0.0;  // of all threads
  };
  struct Seconds {
    Spent fluid, coupling, solid;
    Spent near;  // of the fluid's: of rows of the fluid that made their steps ahead of the others, with the
                 // bodies near them
  };
  /// Of the parts of a scene with a fluid; without one, all time is the solid's, and none of it stands here.
  const Seconds& seconds() const { return seconds_; }

 private:
  bool is_bare_fluid() const { return fluid_ && bodies_.empty() && !uniform_; }
  fluid::NodeForces on_fluid();
  std::vector<std::int64_t> touched_rows() const;
  void step();
  bool steps_ahead(std::int64_t most, const std::function<void()>& after_each);
  void locate();
  class Stopwatch;
  fluid::NodeForces exchange(Stopwatch& watch);

  std::int64_t steps_ = 0;
  std::unique_ptr<fluid::Fluid> fluid_;              // null without one
  std::vector<std::unique_ptr<MovingBody>> bodies_;  // in the scene's order
  std::vector<MovingBody*> coupled_;                 // those that meet the fluid
  std::unique_ptr<UniformForce> uniform_;            // null without one
  std::unique_ptr<coupling::SummedForces> sum_;      // null unless several of these act on the fluid
  Seconds seconds_;
};

}  // namespace veriflex::scene
