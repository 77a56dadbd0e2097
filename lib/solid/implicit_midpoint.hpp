/// Motion of a network by the implicit midpoint rule: a step costs the solution of a static problem, and none
/// is too long for a stiff bond.                                            [hairer-lubich-wanner-2006, II.1.3]
///
///   u' = u + dt (v + v')/2,   m v' = m v + dt F((u + u')/2)
///
/// The middle x = (u + u')/2 minimises energy(x) - load . x + (2 m/dt^2) |x - (u + dt/2 v)|^2, which Newton's
/// method does inside the bonds' domains (see equilibrium()). Second order, symmetric and symplectic; stable
/// for small oscillations at any dt, which it slows down: tan(omega' dt/2) = omega dt/2.
#pragma once

#include <cstdint>

#include "solid/statics.hpp"

namespace veriflex::solid {

class ImplicitMidpoint {
 public:
  /// Starts at displacement u and velocity v at time 0; `load` is dead and may be empty. The network must
  /// outlive the motion.
  ImplicitMidpoint(const Material& material, const Network& network, double node_mass, const FixedDofs& fixed,
                   const Positions& load, double dt, const Positions& u, const Positions& v);

  /// Advances by dt. Throws NumericalFailure, with the step, as equilibrium() does, and when a bond is
  /// outside of its law's domain at the end of the step; the state is then that of the last good step.
  void step();

  const Positions& displacement() const { return u_; }
  const Positions& velocity() const { return v_; }
  double time() const { return static_cast<double>(steps_) * dt_; }
  std::int64_t steps() const { return steps_; }
  /// Newton steps so far: each assembles a Hessian and factorises it.
  std::int64_t newton_steps() const { return newton_steps_; }

 private:
  Material material_;
  const Network& network_;
  double mass_, dt_;
  FixedDofs fixed_;
  Positions load_;
  std::int64_t steps_ = 0, newton_steps_ = 0;
  Positions u_, v_;
  parts::Built part_;
};

}  // namespace veriflex::solid
