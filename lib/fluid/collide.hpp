/// One BGK collision of as many nodes as V has lanes.                             [wu-qi-2014, Eqs. 1-7, 12;
/// guo-2002]
///
/// Populations are deviations h = f - w, so that a fluid nearly at rest keeps the digits of small
/// differences. They are relaxed as even and odd parts of opposite pairs. The density and momentum that a
/// collision conserves are put back by the rest population and the axis pairs instead of relying on weights
/// that add up to one: in float such sums are off by 1e-8, and that error would grow with every step.
#pragma once

#include <type_traits>

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
template <class Force, class Real, class V>
inline void collide(const Collision<Real>& law, V (&h)[Q]) {
  constexpr bool forced = !std::is_same_v<Force, NoForce>;
  constexpr bool second_order = std::is_same_v<Force, GuoForce>;
  constexpr Real axis = Real(1) / Real(9);
  constexpr Real diagonal = Real(1) / Real(72);
  const Real omega = law.omega;
  const Real keep = Real(0.5) * (Real(1) - omega);

  const V s0 = h[1] + h[2], s1 = h[3] + h[4], s2 = h[5] + h[6];
  const V s3 = h[7] + h[8], s4 = h[9] + h[10], s5 = h[11] + h[12], s6 = h[13] + h[14];
  const V a3 = h[7] - h[8], a4 = h[9] - h[10], a5 = h[11] - h[12], a6 = h[13] - h[14];
  const V density = h[0] + (((s0 + s1) + s2) + ((s3 + s4) + (s5 + s6)));  // rho - 1
  const V jx = (h[1] - h[2]) + ((a3 + a4) + (a5 + a6));
  const V jy = (h[3] - h[4]) + ((a3 + a4) - (a5 + a6));
  const V jz = (h[5] - h[6]) + ((a3 - a4) + (a5 - a6));

  // J = rho u; M, N: what the odd and the even parts relax to, with the force in it.
  V Jx = jx, Jy = jy, Jz = jz;
  if constexpr (second_order) {
    Jx += Real(0.5) * law.g[0];
    Jy += Real(0.5) * law.g[1];
    Jz += Real(0.5) * law.g[2];
  }
  const V inverse = Real(1) / (Real(1) + density);
  const V ux = Jx * inverse, uy = Jy * inverse, uz = Jz * inverse;
  V Nx = omega * Jx, Ny = omega * Jy, Nz = omega * Jz;
  V Mx = Nx, My = Ny, Mz = Nz;
  V after_x = jx, after_y = jy, after_z = jz;  // momentum after the collision
  if constexpr (forced) {
    const Real part = second_order ? Real(1) - Real(0.5) * omega : Real(1);
    Mx += part * law.g[0];
    My += part * law.g[1];
    Mz += part * law.g[2];
    if constexpr (second_order) {
      Nx += Real(2) * part * law.g[0];
      Ny += Real(2) * part * law.g[1];
      Nz += Real(2) * part * law.g[2];
    }
    after_x += law.g[0];
    after_y += law.g[1];
    after_z += law.g[2];
  }

  const V xx = ux * Nx, yy = uy * Ny, zz = uz * Nz;
  const V base = omega * density - Real(1.5) * ((xx + yy) + zz);
  const V e0 = keep * s0 + axis * (base + Real(4.5) * xx);
  const V e1 = keep * s1 + axis * (base + Real(4.5) * yy);
  const V e2 = keep * s2 + axis * (base + Real(4.5) * zz);
  const V up = ux + uy, um = ux - uy, np = Nx + Ny, nm = Nx - Ny;
  const V e3 = keep * s3 + diagonal * (base + Real(4.5) * ((up + uz) * (np + Nz)));
  const V e4 = keep * s4 + diagonal * (base + Real(4.5) * ((up - uz) * (np - Nz)));
  const V e5 = keep * s5 + diagonal * (base + Real(4.5) * ((um + uz) * (nm + Nz)));
  const V e6 = keep * s6 + diagonal * (base + Real(4.5) * ((um - uz) * (nm - Nz)));
  const V mp = Mx + My, mm = Mx - My;
  const V o3 = keep * a3 + Real(3) * diagonal * (mp + Mz);
  const V o4 = keep * a4 + Real(3) * diagonal * (mp - Mz);
  const V o5 = keep * a5 + Real(3) * diagonal * (mm + Mz);
  const V o6 = keep * a6 + Real(3) * diagonal * (mm - Mz);
  const V o0 = Real(0.5) * after_x - ((o3 + o4) + (o5 + o6));
  const V o1 = Real(0.5) * after_y - ((o3 + o4) - (o5 + o6));
  const V o2 = Real(0.5) * after_z - ((o3 - o4) + (o5 - o6));

  h[0] = density - Real(2) * (((e0 + e1) + e2) + ((e3 + e4) + (e5 + e6)));
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
