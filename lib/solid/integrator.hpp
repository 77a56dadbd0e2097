/// How a body moves in time: what leap-frog and the implicit midpoint rule have in common.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/named.hpp"
#include "solid/elastic.hpp"
#include "solid/statics.hpp"

namespace veriflex::solid {

enum class Scheme { LeapFrog, ImplicitMidpoint };
inline constexpr std::array schemes{
    Named<Scheme>{Scheme::LeapFrog, "leap-frog", "leap_frog", "leap-frog"},
    Named<Scheme>{Scheme::ImplicitMidpoint, "implicit-midpoint", "implicit_midpoint",
                  "implicit midpoint rule"},
};

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

/// The coordinates that are fixed or driven.
FixedDofs prescribed_dofs(const Conditions& conditions, Eigen::Index nodes);

/// A force on some nodes towards a velocity of each: strength (target - v), v being what the scheme carries.
struct VelocityCoupling {
  const std::vector<std::int32_t>& nodes;
  const Positions& target;  // one row per node of the list  [L T^-1]
  double strength;          // [M T^-1]
  bool subcycled;           // follows v through the step, or is frozen at its start
};

class Integrator {
 public:
  virtual ~Integrator() = default;
  /// Those that move refer to the network beside them.
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;

  /// Advances by dt. Throws NumericalFailure with the step when it cannot be made; the state is then that of
  /// the last good step.
  virtual void step() = 0;

  /// The same under a coupling. `mean` becomes its mean force over the step, one row per coupled node: what
  /// the other side has to bear  [M L T^-2].
  virtual void step(const VelocityCoupling& coupling, Positions& mean) = 0;

  /// Everything that determines the motion from here on, beside what the constructor was given.
  struct State {
    Positions displacement, velocity;  // the latter as the scheme carries it
    std::int64_t steps;
    int substeps = 1;           // in use, and
    double stiffest = 0.0;      // the largest bond stiffness when they were chosen  [M T^-2]
    double substep = 0.0;       // the last one's length  [T]
    Positions linearised_at{};  // displacement where an implicit scheme took its last factor; may be empty
  };
  virtual State state() const = 0;
  /// Puts a state of this network back: the motion goes on from it bit by bit as it would have there. Throws
  /// NumericalFailure as step() does when the energy does not exist in it.
  virtual void restore(const State& state) = 0;

  const Conditions& conditions() const { return conditions_; }
  const Positions& displacement() const { return u_; }
  /// Velocity as the scheme carries it, which is the one that a coupling sees.
  const Positions& carried_velocity() const { return v_; }
  /// Velocity now, second order.
  virtual Positions velocity() const = 0;

  double time() const { return static_cast<double>(steps_) * dt_; }
  std::int64_t steps() const { return steps_; }

  double kinetic_energy() const;    // of velocity()  [M L^2 T^-2]
  double potential_energy() const;  // elastic, and of the dead load  [M L^2 T^-2]
  Vec3 momentum() const;            // of carried_velocity()  [M L T^-1]

 protected:
  Integrator(const Material& material, const Network& network, Conditions conditions, double dt, Positions u,
             Positions v);
  /// What the body has whatever the scheme.
  void tell_parts();
  [[noreturn]] void fail(const std::string& when, const Positions& u) const;

  Material material_;
  const Network& network_;
  Conditions conditions_;
  double dt_;
  std::int64_t steps_ = 0;
  Positions u_, v_;
  Workspace work_;  // at u_
  std::vector<parts::Built> parts_;

 private:
  NetworkParts network_parts_;
};

}  // namespace veriflex::solid
