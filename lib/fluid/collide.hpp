/// One BGK collision of as many nodes as V has lanes.                             [wu-qi-2014, Eqs. 1-7, 12;
/// guo-2002]
///
/// Populations are deviations h = f - w, so that a fluid nearly at rest keeps the digits of small
/// differences. They are relaxed as even and odd parts of opposite pairs. The density and momentum that a
/// collision conserves are put back by the rest population and the axis pairs instead of relying on weights
/// that add up to one: in float such sums are off by 1e-8, and that error would grow with every step.
#pragma once

#include <type_traits>

#include "fluid/lanes.hpp"
#include "fluid/lattice.hpp"

namespace veriflex::fluid {

/// No body force.
struct NoForce {};

/// Adds 3 w g.c after the collision; the velocity is sum f c / rho.
struct FirstOrderForce {};

/// The velocity is (sum f c + g/2) / rho, the source (1 - omega/2) w [3 (c - u) + 9 (c.u) c].g
struct GuoForce {};

template <class Real>
struct Collision {
  Real omega;  // 1/tau
  Real g[3];   // body force per volume  [M L^-2 T^-2]
};

/// h holds the populations before the collision, and after it those that leave: h[q] along c[q].
///
/// With pairs' half sums e and half differences o, s = h + h_opposite, a = h - h_opposite, k = (1 - omega)/2:
///   e = k s + w [omega (rho - 1) - 3/2 u.N + 9/2 (c.u)(c.N)],   o = k a + 3 w c.M,   h = e + o, h_opposite =
///   e - o
/// where M = omega J, N = M without force. Everything is scaled such that most constants disappear: U = 3/2
/// u, and M and N over 24, so that 3 w c.M = c.M and 9/2 w (c.u)(c.N) = (c.U)(c.N) for the diagonal pairs.
template <class Force, class Real, class V>
inline void collide(const Collision<Real>& law, V (&h)[Q]) {
  constexpr bool forced = !std::is_same_v<Force, NoForce>;
  constexpr bool second_order = std::is_same_v<Force, GuoForce>;
  const auto all = [](Real value) { return V{} + value; };
  const V k = all(Real(0.5) * (Real(1) - law.omega));
  const V half = all(Real(0.5));

  const V s0 = h[1] + h[2], s1 = h[3] + h[4], s2 = h[5] + h[6];
  const V s3 = h[7] + h[8], s4 = h[9] + h[10], s5 = h[11] + h[12], s6 = h[13] + h[14];
  const V a3 = h[7] - h[8], a4 = h[9] - h[10], a5 = h[11] - h[12], a6 = h[13] - h[14];
  const V density = h[0] + (((s0 + s1) + s2) + ((s3 + s4) + (s5 + s6)));  // rho - 1
  const V jx = (h[1] - h[2]) + ((a3 + a4) + (a5 + a6));
  const V jy = (h[3] - h[4]) + ((a3 + a4) - (a5 + a6));
  const V jz = (h[5] - h[6]) + ((a3 - a4) + (a5 - a6));

  V Jx = jx, Jy = jy, Jz = jz;  // rho u
  if constexpr (second_order) {
    Jx += Real(0.5) * law.g[0];
    Jy += Real(0.5) * law.g[1];
    Jz += Real(0.5) * law.g[2];
  }
  const V inverse = Real(1.5) / (Real(1) + density);
  const V Ux = Jx * inverse, Uy = Jy * inverse, Uz = Jz * inverse;
  const Real rate = law.omega / Real(24);
  V Nx = rate * Jx, Ny = rate * Jy, Nz = rate * Jz;
  const Real part = (second_order ? Real(1) - Real(0.5) * law.omega : Real(1)) / Real(24);
  if constexpr (second_order) {
    Nx += Real(2) * part * law.g[0];
    Ny += Real(2) * part * law.g[1];
    Nz += Real(2) * part * law.g[2];
  }
  // 3 w c.M of a diagonal pair out of c.N: what is between them is the same for all nodes.
  const Real between = second_order ? -part : part;
  const auto from_N = [&](const V& along, int y, int z) {
    if constexpr (!forced) return along;
    return along + between * (law.g[0] + Real(y) * law.g[1] + Real(z) * law.g[2]);
  };
  // Half of the momentum after the collision, less what the diagonal pairs take of it.
  const auto half_of = [&](const V& j, Real g, const V& taken) {
    if constexpr (!forced) return multiply_add(half, j, -taken);
    return multiply_add(half, j, Real(0.5) * g - taken);
  };

  const V xx = Ux * Nx, yy = Uy * Ny, zz = Uz * Nz;
  const V eight = all(Real(8));
  const V base = multiply_add(all(Real(-1) / Real(3)), (xx + yy) + zz, (law.omega / Real(72)) * density);
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
  const V o3 = multiply_add(k, a3, from_N(N3, 1, 1));
  const V o4 = multiply_add(k, a4, from_N(N4, 1, -1));
  const V o5 = multiply_add(k, a5, from_N(N5, -1, 1));
  const V o6 = multiply_add(k, a6, from_N(N6, -1, -1));
  const V o34 = o3 + o4, o56 = o5 + o6;
  const V o0 = half_of(jx, law.g[0], o34 + o56);
  const V o1 = half_of(jy, law.g[1], o34 - o56);
  const V o2 = half_of(jz, law.g[2], (o3 - o4) + (o5 - o6));

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
