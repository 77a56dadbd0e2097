/// Motion of a network by leap-frog: velocities live at half steps.
/// [wu-qi-2014, text after Eq. 15]
///
///   m v(t + dt/2) = m v(t - dt/2) + dt F(u(t)),   u(t + dt) = u(t) + dt v(t + dt/2)
///
/// with a viscous drag gamma v per node taken at the middle of the step. Second order, reversible without
/// drag, and stable for small oscillations up to dt = 2/omega_max.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "solid/elastic.hpp"
#include "solid/statics.hpp"

namespace veriflex::solid {

/// Prescribed motion of some nodes along one axis: u = amplitude sin(omega t), risen linearly over `ramp`.
struct Drive {
  std::vector<std::int32_t> nodes;
  int axis;
  double amplitude;  // [L]
  double omega;      // [T^-1]
  double ramp;       // duration of the rise; 0 for an abrupt start  [T]

  double at(double time) const;
};

/// How the body is fixed, driven and loaded. An empty matrix is absent: no pass over the nodes is made for
/// it.
struct Conditions {
  double node_mass = 1.0;  // [M]
  double drag = 0.0;       // gamma, force per velocity and node  [M T^-1]
  FixedDofs fixed;         // coordinates that stay where they start
  Positions load;          // dead load  [M L T^-2]
  std::optional<Drive> drive;
};

/// How finely one step is divided.
struct Substeps {
  int count = 1;        // ignored when `safety` is given
  double safety = 0.0;  // > 0: as many as keep the step below safety * 2/omega_max of the present network
  /// More than the above: a step in which a bond would move by more than a tenth of its distance from a limit
  /// of its law is refused and made anew in twice as many sub-steps, in at most so many. 0: none is refused.
  int most = 0;
};

/// A force on some nodes towards a velocity of each: strength (target - v), v being half a (sub-)step old.
struct VelocityCoupling {
  const std::vector<std::int32_t>& nodes;
  const Positions& target;  // one row per node of the list  [L T^-1]
  double strength;          // [M T^-1]
  bool subcycled;           // follows v through the sub-steps, or is frozen at the start of the step
};

class Leapfrog {
 public:
  /// Starts at displacement u and velocity v at time 0. Throws NumericalFailure as step() does when the
  /// energy does not exist at u.
  Leapfrog(const Material& material, const Network& network, Conditions conditions, double dt,
           Substeps substeps, Positions u, Positions v);

  /// Advances by dt. Throws NumericalFailure with the step and what_is_inadmissible() when a bond leaves its
  /// law's domain or an angle degenerates, and when a step is refused in as many sub-steps as are allowed;
  /// the state is then that of the last good step.
  void step();

  /// The same under a coupling. `mean` becomes its mean force over the step, one row per coupled node: what
  /// the other side has to bear  [M L T^-2].
  void step(const VelocityCoupling& coupling, Positions& mean);

  /// Everything that determines the motion from here on, beside what the constructor was given.
  struct State {
    Positions displacement, half_velocity;
    std::int64_t steps;
    int substeps;           // in use, and
    double stiffest = 0.0;  // the largest bond stiffness when they were chosen  [M T^-2]
    double substep = 0.0;   // the last one's length  [T]
  };
  State state() const { return {u_, v_, steps_, count_, stiffest_, last_substep_}; }
  /// Puts a state of this network back: the motion goes on from it bit by bit as it would have there. Throws
  /// NumericalFailure as step() does when the energy does not exist in it.
  void restore(const State& state);

  const Conditions& conditions() const { return conditions_; }
  const Positions& displacement() const { return u_; }
  /// Velocity half a (sub-)step ago: what the scheme carries.
  const Positions& half_velocity() const { return v_; }
  /// Velocity now, second order: half a kick after half_velocity().
  Positions velocity() const;
  /// Reverses time: a run forward, this, and the same run again end where they began.
  void reverse();

  double time() const { return static_cast<double>(steps_) * dt_; }
  std::int64_t steps() const { return steps_; }
  /// In use; a step that is refused takes more.
  int substeps() const { return count_; }

  double kinetic_energy() const;    // of velocity()  [M L^2 T^-2]
  double potential_energy() const;  // elastic, and of the dead load  [M L^2 T^-2]
  Vec3 momentum() const;            // of half_velocity()  [M L T^-1]

 private:
  template <class Extra>
  int advance(Extra extra_kick);
  enum class Substepped { Well, Outside, TooFar };
  template <class Extra>
  Substepped make_substeps(int count, Extra extra_kick);
  bool moved_too_far() const;
  void tell_parts();
  void divide();
  bool evaluate(const Positions& u);
  void prescribe(double time, double substep);
  [[noreturn]] void fail(const std::string& when, const Positions& u) const;

  Material material_;
  const Network& network_;
  Conditions conditions_;
  double dt_;
  Substeps wanted_;
  int count_ = 1;
  double stiffest_ = 0.0;      // largest bond stiffness when the step was divided
  double last_substep_ = 0.0;  // v_ is half of it old  [T]
  std::int64_t steps_ = 0;
  Positions u_, v_, gradient_;
  Positions next_;                                // displacement a sub-step on, until it is known to be good
  Positions bonds_before_, u_before_, v_before_;  // of a sub-step and a step that may be refused
  Workspace work_;
  NetworkParts network_parts_;
  std::vector<parts::Built> parts_;
};

}  // namespace veriflex::solid
