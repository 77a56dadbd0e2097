/// An elastic layer on an oscillating plate, and a viscous fluid between it and a wall at rest, as complex
/// amplitudes of Re[... exp(i omega t)].
///
///   solid  rho_s u_tt = G u_yy, 0 < y < h, u_t(0) = V        fluid  rho_f v_t = mu v_yy, h < y < H, v(H) = 0
///
/// with velocity and shear stress continuous at y = h. Nothing in it is fitted.
#pragma once

#include <complex>

namespace veriflex::analytic {

/// What is inside of the layer beside the solid.
enum class Filling {
  None,    // nothing: a solid with a fluid above it
  Moving,  // fluid that moves with the solid: all nodes of an immersed body are coupled
  Between  // fluid that meets the solid at its surfaces only, y = h and its mirror image -h: those of a body
           // whose boundary nodes are coupled, and which is driven in its middle y = 0
};

struct ElasticLayer {
  double thickness;      // h  [L]
  double height;         // H, of the wall  [L]
  double shear_modulus;  // G  [M L^-1 T^-2]
  double density;        // rho_s  [M L^-3]
  double fluid_density;  // rho_f  [M L^-3]
  double viscosity;      // nu = mu/rho_f  [L^2 T^-1]
  double omega;          // [T^-1]
  Filling filling;
};

/// Velocity of the solid at y, 0 to h, over that of the plate: cos(k y) + B sin(k y), with k = omega
/// sqrt(rho_s/G), Z = G k/(i omega), lambda^2 = i omega/nu and Y = mu lambda coth(lambda (H - h)), the stress
/// per velocity of the fluid: B = (Z sin(k h) - Y cos(k h))/(Z cos(k h) + Y sin(k h)). Moving: with
/// G + i omega mu and rho_s + rho_f. Between: Y has mu lambda tanh(lambda h) more.
std::complex<double> layer_velocity(const ElasticLayer& layer, double y);

/// The same at y = h: Z/(Z cos(k h) + Y sin(k h)).
std::complex<double> interface_velocity(const ElasticLayer& layer);

}  // namespace veriflex::analytic
