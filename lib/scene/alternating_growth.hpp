/// How fast the exchange can grow while its force is frozen over the sub-steps: an alternation, found from
/// symmetric problems alone.
///
/// With the force F frozen over a step of n sub-steps, motions that grow by lambda a step obey, at the
/// markers,
///
///   [Q^-1 + A/(lambda - 1) + (lambda - 1)/m P b(K) (lambda^2 - 2 lambda c(K) + 1)^-1 P^T] F = 0
///
/// with Q = (1 - (1 - V A)^k)/A for k rounds of forcing, c = cos(n theta), b = sin(n theta)/(n sin(theta))
/// and K/(m n^2) = 2 - 2 cos(theta) mode by mode. Where n theta < pi for all modes and V A < 2, the imaginary
/// part of v* m b^-1 (lambda + 1/lambda - 2 c) v + (lambda - 1)^2/lambda g* (lambda - 1 + Q A)^-1 Q g, g = P
/// v, has the sign of lambda's everywhere outside of the unit circle: what grows has a real factor. Above 1
/// these are modes of negative stiffness, as a body has that stands under stress; below -1 the exchange
/// alternates. It does, lambda = - rho, while
///
///   Q^(1/2) [A/(rho + 1) + (rho + 1)/m P b (rho^2 + 2 rho c + 1)^-1 P^T] Q^(1/2)
///
/// has an eigenvalue above 1, and all of them fall as rho rises. For n = 1 and rho = 1 this is the boundary
/// m = K/4 + P (2 - Q A)^-1 Q P^T.
#pragma once

#include <optional>
#include <span>

#include "scene/coupled_step.hpp"

namespace veriflex::scene {

/// Largest eigenvalues that decide which theory holds. `answered` is V S: the part of a slip that a round of
/// forcing takes away at once, for the pattern of forces where it is most, S the largest eigenvalue of A.
struct Scales {
  double stiffness;  // of K  [M T^-2]
  double answered;   // of V A
};
Scales scales_of(const CoupledStep& step);

/// What exceeds a growth of 1 by less is rounding: a body that drifts with the fluid neither grows nor
/// decays.
constexpr double growth_resolution = 1e-5;

class AlternatingGrowth {
 public:
  /// Nothing when that theory does not hold for the step: implicit, force subcycled, damped, a mode that
  /// turns by more than about half a turn in a step, V S of 2 and more, a body that by itself grows fast.
  static std::optional<AlternatingGrowth> of(const CoupledStep& step, const Scales& scales);

  /// Whether something grows by more than that factor, at least 1, in a step.
  bool exceeds(double factor) const;

  /// The largest such factor; 1 when nothing grows by more than growth_resolution.
  double factor() const;

  /// What the body may grow by itself, above 1; growth_resolution when that is nothing.
  double own_growth() const { return own_growth_; }

 private:
  AlternatingGrowth(const CoupledStep& step, double stiffest, double own_growth)
      : step_(step), stiffest_(stiffest), own_growth_(own_growth) {}
  /// Of the largest eigenvalue over 1, to a residual of `tolerance`.
  double excess(double rho, double tolerance) const;

  const CoupledStep& step_;
  double stiffest_;  // of K, and a little  [M T^-2]
  double own_growth_;
  Eigen::MatrixXd root_of_Q_{};  // L of one axis with L L^T = Q; empty for one round, Q = V
};

}  // namespace veriflex::scene
