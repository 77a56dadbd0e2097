/// One BGK collision of as many nodes as V has lanes.
/// [wu-qi-2014, Eqs. 1-2, 5-6, 12; guo-2002]
///
/// Populations are deviations h = f - w, so that a fluid nearly at rest keeps the digits of small
/// differences. They are relaxed as even and odd parts of opposite pairs. The density and momentum that a
/// collision conserves are put back by the rest population and the axis pairs instead of relying on weights
/// that add up to one: in float such sums are off by 1e-8, and that error would grow with every step.
#pragma once

#include <cstddef>
#include <type_traits>

#include "base/mutant.hpp"
#include "fluid/force_scheme.hpp"
#include "fluid/lanes.hpp"
#include "fluid/lattice.hpp"

namespace veriflex::fluid {

/// No body force: in the place of a ForceScheme.
struct NoForce {
  static constexpr bool shifts_velocity = false;
  static constexpr bool changes_N = false;
};

/// What a collision needs beside the populations, computed once: divisions and products of constants would
/// otherwise be repeated for every vector of nodes, because the compiler cannot know that storing a
/// population leaves them as they are.
template <class Real>
struct Collision {
  Real k;           // (1 - omega)/2, omega = 1/tau
  Real omega_24;    // omega/24
  Real omega_72;    // omega/72
  Real half_g[3];   // half of the body force per volume  [M L^-2 T^-2]
  Real N_force[3];  // what the force adds to N, over 24
  Real o_force[4];  // what it adds to o of the diagonal pairs beyond N
};

/// `g`: body force per volume  [M L^-2 T^-2].
template <ForceScheme Force, class Real>
Collision<Real> collision(double relaxation_time, const double (&g)[3]) {
  const Real omega =
      static_cast<Real>(1.0 / ((planted(Mutant::tau_off_by_1e_4) ? 1.0001 : 1.0) * relaxation_time +
                               (planted(Mutant::tau_off_by_half) ? 0.5 : 0.0)));
  Collision<Real> law{.k = Real(0.5) * (Real(1) - omega),
                      .omega_24 = omega / Real(24),
                      .omega_72 = omega / Real(planted(Mutant::diagonal_weight_doubled) ? 36 : 72),
                      .half_g = {},
                      .N_force = {},
                      .o_force = {}};
  const Real of_N = Force::of_N(omega) / Real(24);
  const Real beyond_N = Force::beyond_N(omega) / Real(24);
  for (int i = 0; i < 3; ++i) {
    law.half_g[i] = Real(planted(Mutant::body_force_doubled) ? 1.0 : 0.5) * static_cast<Real>(g[i]);
    law.N_force[i] = of_N * static_cast<Real>(g[i]);
  }
  for (std::size_t pair = 0; pair < 4; ++pair) {
    const auto& v = c[7 + 2 * pair];
    law.o_force[pair] =
        beyond_N * (Real(v[0]) * static_cast<Real>(g[0]) + Real(v[1]) * static_cast<Real>(g[1]) +
                    Real(v[2]) * static_cast<Real>(g[2]));
  }
  return law;
}

/// h holds the populations before the collision, and after it those that leave: h[q] along c[q].
///
/// With pairs' half sums e and half differences o, s = h + h_opposite, a = h - h_opposite, k = (1 - omega)/2:
///   e = k s + w [omega (rho - 1) - 3/2 u.N + 9/2 (c.u)(c.N)],   o = k a + 3 w c.M,   h = e + o, h_opposite =
///   e - o
/// where M = omega J, N = M without force. Everything is scaled such that most constants disappear: U = 3/2
/// u, and M and N over 24, so that 3 w c.M = c.M and 9/2 w (c.u)(c.N) = (c.U)(c.N) for the diagonal pairs.
template <class Force, class Real, class V>
[[gnu::always_inline]] inline void collide(const Collision<Real>& law, V (&h)[Q]) {
  constexpr bool forced = !std::is_same_v<Force, NoForce>;
  const auto all = [](Real value) { return V{} + value; };
  const V k = all(law.k);
  const V half = all(Real(0.5));

  const V s0 = h[1] + h[2], s1 = h[3] + h[4], s2 = h[5] + h[6];
  const V s3 = h[7] + h[8], s4 = h[9] + h[10], s5 = h[11] + h[12], s6 = h[13] + h[14];
  const V a3 = h[7] - h[8], a4 = h[9] - h[10], a5 = h[11] - h[12], a6 = h[13] - h[14];
  const V density = h[0] + (((s0 + s1) + s2) + ((s3 + s4) + (s5 + s6)));  // rho - 1
  const V jx = (h[1] - h[2]) + ((a3 + a4) + (a5 + a6));
  const V jy = (h[3] - h[4]) + ((a3 + a4) - (a5 + a6));
  const V jz = (h[5] - h[6]) + ((a3 - a4) + (a5 - a6));

  V Jx = jx, Jy = jy, Jz = jz;  // rho u
  if constexpr (Force::shifts_velocity) {
    Jx += planted(Mutant::velocity_not_shifted) ? Real(0) : law.half_g[0];
    Jy += law.half_g[1];
    Jz += law.half_g[2];
  }
  const V inverse = Real(1.5) / (Real(1) + density);
  const V Ux = Jx * inverse, Uy = Jy * inverse, Uz = Jz * inverse;
  V Nx = law.omega_24 * Jx, Ny = law.omega_24 * Jy, Nz = law.omega_24 * Jz;
  if constexpr (Force::changes_N) {
    Nx += law.N_force[0];
    Ny += law.N_force[1];
    Nz += law.N_force[2];
  }
  // 3 w c.M of a diagonal pair out of c.N: what is between them is the same for all nodes.
  const auto from_N = [&](const V& along, int pair) {
    if constexpr (!forced) return along;
    return along + law.o_force[pair];
  };
  // Half of the momentum after the collision, less what the diagonal pairs take of it.
  const auto half_of = [&](const V& j, int axis, const V& taken) {
    if constexpr (!forced) return multiply_add(half, j, -taken);
    return multiply_add(half, j, law.half_g[axis] - taken);
  };

  const V xx = Ux * Nx, yy = Uy * Ny, zz = Uz * Nz;
  const V eight = all(Real(8));
  const V base = multiply_add(all(Real(planted(Mutant::collision_without_u_squared) ? 0 : -1) / Real(3)),
                              (xx + yy) + zz, law.omega_72 * density);
  const V base8 = eight * base;
  const V e0 = multiply_add(k, s0, multiply_add(eight, xx, base8));
  const V e1 = multiply_add(k, s1, multiply_add(eight, yy, base8));
  const V e2 = multiply_add(k, s2, multiply_add(eight, zz, base8));
  const V Up = Ux + Uy, Um = Ux - Uy, Np = Nx + Ny, Nm = Nx - Ny;
  const V N3 = Np + Nz, N4 = Np - Nz, N5 = Nm + Nz, N6 = Nm - Nz;  // c.N
  const V e3 = multiply_add(k, s3, multiply_add(Up + Uz, N3, base));
  const V e4 = multiply_add(k, s4, multiply_add(Up - Uz, N4, base));
  const V e5 = multiply_add(k, s5, multiply_add(Um + Uz, N5, base));
  const V e6 = multiply_add(k, s6, multiply_add(Um - Uz, N6, base));
  const V o3 = multiply_add(k, a3, from_N(N3, 0));
  const V o4 = multiply_add(k, a4, from_N(N4, 1));
  const V o5 = multiply_add(k, a5, from_N(N5, 2));
  const V o6 = multiply_add(k, a6, from_N(N6, 3));
  const V o34 = o3 + o4, o56 = o5 + o6;
  const V o0 = half_of(jx, 0, o34 + o56);
  const V o1 = half_of(jy, 1, o34 - o56);
  const V o2 = half_of(jz, 2, (o3 - o4) + (o5 - o6));

  h[0] = multiply_add(all(Real(-2)), ((e0 + e1) + e2) + ((e3 + e4) + (e5 + e6)), density);
  h[1] = e0 + o0;
  h[2] = e0 - o0;
  h[3] = e1 + o1;
  h[4] = e1 - o1;
  h[5] = e2 + o2;
  h[6] = e2 - o2;
  h[7] = e3 + o3;
  h[8] = e3 - o3;
  h[9] = e4 + o4;
  h[10] = e4 - o4;
  h[11] = e5 + o5;
  h[12] = e5 - o5;
  h[13] = e6 + o6;
  h[14] = e6 - o6;
}

}  // namespace veriflex::fluid
