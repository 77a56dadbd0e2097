/// What leaves a node at tau = 1, out of nothing but its density and momentum.
/// [wu-qi-2014, Eqs. 1-2, 5-6, 12; guo-2002]
///
/// At tau = 1 a collision keeps nothing else: f = f_eq, and the force's term. Moments are carried as
/// M = 216 (rho - 1, sum f c), and populations as H = 216 (f - w). With D = 3 (rho - 1), n = 9 sum f c,
/// r = 1/(18 rho) all weights become small whole numbers:
///   rest 16 (D - r J.N),  axes 8 (D - r J.N) + 24 r J_a N_a +- 8 P_a,  diagonals D - r J.N + 3 r (c.J)(c.N)
///   +- c.P
/// where without force J = N = P = n. What is left are the divisions of M by 72 and 24, made with the
/// constant in two parts: rounded to nearest they are off by as much in either direction, whereas a rounded
/// constant would be off in one, which would grow with every step.
#pragma once

#include <cstddef>
#include <type_traits>

#include "base/mutant.hpp"
#include "fluid/collide.hpp"
#include "fluid/lanes.hpp"
#include "fluid/lattice.hpp"

namespace veriflex::fluid {

/// Of M = 216 (rho - 1, sum f c).
constexpr double moment_scale = 216.0;

/// A body force in a collision at tau = 1, in the units of n = 9 sum f c.
template <class Real>
struct MomentForce {
  Real on_J[3];  // J - n
  Real on_N[3];  // N - J
  Real on_P[3];  // P - N
};

/// `g`: body force per volume  [M L^-2 T^-2].
template <ForceScheme Force, class Real>
MomentForce<Real> moment_force(const double (&g)[3]) {
  constexpr double omega = 1.0;
  MomentForce<Real> force{};
  for (int i = 0; i < 3; ++i) {
    force.on_J[i] = static_cast<Real>(
        Force::shifts_velocity && !planted(Mutant::moment_force_unshifted) ? 4.5 * g[i] : 0.0);
    force.on_N[i] = static_cast<Real>(9.0 * Force::of_N(omega) * g[i]);
    force.on_P[i] = static_cast<Real>(9.0 * Force::beyond_N(omega) * g[i]);
  }
  return force;
}

/// H[q] leaves along c[q]. Force: NoForce or a ForceScheme.
template <class Force, class Real, class V>
[[gnu::always_inline]] inline void leave(const MomentForce<Real>& force, const V (&M)[4], V (&H)[Q]) {
  const auto all = [](Real value) { return V{} + value; };
  const auto over = [&](const V& value, double divisor) __attribute__((always_inline)) {
    const Real high = static_cast<Real>(1.0L / divisor);
    const Real low = static_cast<Real>(1.0L / divisor - static_cast<long double>(high));
    return multiply_add(value, all(high), value * low);
  };
  const V D = over(M[0], 72.0);
  V J[3], N[3], P[3];
  for (int i = 0; i < 3; ++i) {
    P[i] = N[i] = J[i] = over(M[i + 1], 24.0);
    if constexpr (!std::is_same_v<Force, NoForce>) {
      if constexpr (Force::shifts_velocity) P[i] = N[i] = J[i] = J[i] + force.on_J[i];
      if constexpr (Force::changes_N) P[i] = N[i] = N[i] + force.on_N[i];
      P[i] = P[i] + force.on_P[i];
    }
  }
  const V r =
      Real(planted(Mutant::moments_without_squares) ? 0 : 1) / multiply_add(all(Real(6)), D, all(Real(18)));
  const V r3 = Real(3) * r, r24 = Real(8) * r3;
  V JN[3];
  for (int i = 0; i < 3; ++i) JN[i] = J[i] * N[i];
  const V even = multiply_add(-r, JN[0] + (JN[1] + JN[2]), D);
  const V even8 = Real(8) * even;
  H[0] = even8 + even8;
  for (int i = 0; i < 3; ++i) {
    const V e = multiply_add(r24, JN[i], even8);
    const V odd = Real(8) * P[i];
    H[2 * i + 1] = e + odd;
    H[2 * i + 2] = e - odd;
  }
  // c.v of the diagonal pairs.
  const auto on_diagonals = [](const V(&v)[3], V(&along)[4]) __attribute__((always_inline)) {
    const V plus = v[0] + v[1], minus = v[0] - v[1];
    along[0] = plus + v[2];
    along[1] = plus - v[2];
    along[2] = minus + v[2];
    along[3] = minus - v[2];
  };
  V cJ[4], cN[4], cP[4];
  on_diagonals(J, cJ);
  if constexpr (std::is_same_v<Force, NoForce>) {
    for (int pair = 0; pair < 4; ++pair) cP[pair] = cN[pair] = cJ[pair];
  } else {
    on_diagonals(N, cN);
    on_diagonals(P, cP);
  }
  for (int pair = 0; pair < 4; ++pair) {
    const V e = multiply_add(r3, cJ[pair] * cN[pair], even);
    H[2 * pair + 7] = e + cP[pair];
    H[2 * pair + 8] = e - cP[pair];
  }
}

}  // namespace veriflex::fluid
