/// Exact solutions of the incompressible Navier-Stokes equations that keep their pattern while they decay.
///
/// In the plane of axes a and b, with wave number K, amplitude A, density 1 and F = exp(-decay_rate t):
///   Taylor and Green:  u_a = -A F cos(K a) sin(K b), u_b = A F sin(K a) cos(K b),       decay rate 2 nu K^2
///                      p = -(A F)^2/4 [cos(2 K a) + cos(2 K b)]                    [taylor-1923]
///   shear wave:        u_b = A F cos(K a), p = 0,                                        decay rate nu K^2
/// A uniform stream carries either along.
#pragma once

#include "base/vec.hpp"

namespace veriflex::analytic {

enum class Pattern { TaylorGreen, Shear };

struct FlowState {
  double pressure;  // above the mean  [M L^-1 T^-2]
  Vec3 velocity;    // [L T^-1]
  Mat3 gradient;    // (a, b) is du_b/dx_a  [T^-1]
};

struct DecayingFlow {
  Pattern pattern;
  int a, b;           // axes of the plane
  double wavenumber;  // K  [L^-1]
  double amplitude;   // A  [L T^-1]
  double viscosity;   // nu  [L^2 T^-1]
  Vec3 stream = Vec3::Zero();

  double decay_rate() const;  // of the velocity  [T^-1]
  FlowState at(const Vec3& x, double time) const;

  /// What a weakly compressible fluid with this speed of sound c has beside the solution at time 0: as its
  /// pressure changes, it swells, div u = -(dp/dt + u.grad p)/c^2. A flow that starts without this velocity,
  /// of relative order (A/c)^2, rings with sound.
  Vec3 swelling(const Vec3& x, double sound_speed_squared) const;
};

}  // namespace veriflex::analytic
