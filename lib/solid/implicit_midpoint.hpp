/// Motion of a network by the implicit midpoint rule: a step costs the solution of a static problem, and none
/// is too long for a stiff bond.                                            [hairer-lubich-wanner-2006, II.1.3]
///
///   u' = u + dt (v + v')/2,   m v' = m v + dt F((u + u')/2) - dt gamma (u' - u)/dt
///
/// The middle x = (u + u')/2 minimises energy(x) - load . x + (2 m/dt^2) |x - (u + dt/2 v)|^2, and drag and a
/// coupling that follows the velocity of the step, (u' - u)/dt, add squares of their own. Newton's method
/// finds it inside the bonds' domains with a factor that is kept from step to step (newton_with()). Second
/// order, symmetric and symplectic; stable for small oscillations at any dt, which it slows down: tan(omega'
/// dt/2) = omega dt/2.
#pragma once

#include "solid/integrator.hpp"
#include "solid/newton.hpp"

namespace veriflex::solid {

class ImplicitMidpoint final : public Integrator {
 public:
  /// Starts at displacement u and velocity v at time 0. The network must outlive the motion. Throws
  /// NumericalFailure when the energy does not exist at u.
  ImplicitMidpoint(const Material& material, const Network& network, Conditions conditions, double dt,
                   Positions u, Positions v);

  /// Throws NumericalFailure, with the step, as equilibrium() does, and when a bond is outside of its law's
  /// domain at the end of the step.
  void step() override;
  void step(const VelocityCoupling& coupling, Positions& mean) override;

  State state() const override { return {u_, v_, steps_, 1, 0.0, dt_, kept_.at}; }
  void restore(const State& state) override;

  /// Free coordinates carry it; those that are prescribed have the mean velocity of their last step.
  Positions velocity() const override { return v_; }

  /// Newton steps so far.
  std::int64_t newton_steps() const { return newton_steps_; }

 private:
  void advance(const Positions& load, const Inertia& inertia);
  Inertia inertia() const;
  Positions load() const;
  bool evaluate(const Positions& u);

  FixedDofs prescribed_;  // fixed or driven
  KeptFactor kept_;
  std::int64_t newton_steps_ = 0;
  parts::Built part_;
};

}  // namespace veriflex::solid
