/// Motion of a network by leap-frog: velocities live at half steps.
/// [wu-qi-2014, text after Eq. 15]
///
///   m v(t + dt/2) = m v(t - dt/2) + dt F(u(t)),   u(t + dt) = u(t) + dt v(t + dt/2)
///
/// with a viscous drag gamma v per node taken at the middle of the step. Second order, reversible without
/// drag, and stable for small oscillations up to dt = 2/omega_max.
#pragma once

#include "solid/integrator.hpp"

namespace veriflex::solid {

/// How finely one step is divided.
struct Substeps {
  int count = 1;        // ignored when `safety` is given
  double safety = 0.0;  // > 0: as many as keep the step below safety * 2/omega_max of the present network
  /// More than the above: a step in which a bond would move by more than a tenth of its distance from a limit
  /// of its law is refused and made anew in twice as many sub-steps, in at most so many. 0: none is refused.
  int most = 0;
};

class Leapfrog final : public Integrator {
 public:
  /// Starts at displacement u and velocity v at time 0. Throws NumericalFailure as step() does when the
  /// energy does not exist at u.
  Leapfrog(const Material& material, const Network& network, Conditions conditions, double dt,
           Substeps substeps, Positions u, Positions v);

  /// Throws NumericalFailure with the step and what_is_inadmissible() when a bond leaves its law's domain or
  /// an angle degenerates, and when a step is refused in as many sub-steps as are allowed; the state is then
  /// that of the last good step.
  void step() override;
  void step(const VelocityCoupling& coupling, Positions& mean) override;

  State state() const override { return {u_, v_, steps_, count_, stiffest_, last_substep_, {}}; }
  void restore(const State& state) override;

  /// Half a kick after carried_velocity(), which is half a (sub-)step old.
  Positions velocity() const override;
  /// Reverses time: a run forward, this, and the same run again end where they began.
  void reverse();

  /// In use; a step that is refused takes more.
  int substeps() const { return count_; }

 private:
  template <class Extra>
  int advance(Extra extra_kick);
  enum class Substepped { Well, Outside, TooFar };
  template <class Extra>
  Substepped make_substeps(int count, Extra extra_kick);
  bool moved_too_far() const;
  void divide();
  bool evaluate(const Positions& u);
  void prescribe(double time, double substep);

  Substeps wanted_;
  int count_ = 1;
  double stiffest_ = 0.0;      // largest bond stiffness when the step was divided
  double last_substep_ = 0.0;  // v_ is half of it old  [T]
  Positions gradient_;
  Positions next_;                                // displacement a sub-step on, until it is known to be good
  Positions bonds_before_, u_before_, v_before_;  // of a sub-step and a step that may be refused
};

}  // namespace veriflex::solid
