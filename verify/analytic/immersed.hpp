/// Exact answers for bodies that oscillate in a viscous fluid of density 1, as complex amplitudes of
/// Re[... exp(i omega t)].
#pragma once

#include <complex>
#include <span>

namespace veriflex::analytic {

/// K_n(z), n = 0 or 1, for Re z > 0: the integral of exp(-z cosh t) cosh(n t) over t > 0 by the trapezoidal
/// rule, whose error falls exponentially. Relative error below 1e-12 for 0.01 < |z| < 100, |arg z| <= pi/4.
///                                                                        [abramowitz-stegun-1964, 9.6.24]
std::complex<double> bessel_k(int n, std::complex<double> z);

/// Velocity at distance y from a plate that oscillates along itself, over the plate's, with the next of its
/// images at y = height: cosh(k (y - height/2))/cosh(k height/2), k = sqrt(i omega/nu).     [stokes-1851]
std::complex<double> oscillating_plate(double y, double height, double omega, double viscosity);

/// Force on both sides of that plate that keeps it moving, per area and velocity: 2 nu k tanh(k height/2)
/// [M L^-2 T^-1].
std::complex<double> oscillating_plate_force(double height, double omega, double viscosity);

/// The same of a plate of markers, one per h^2 and each standing for a volume h^3, whose force is spread over
/// the nodes with these weights along the box across it: F (1/alpha + R - S/2) = 1 with S = sum w^2, alpha =
/// (1 - (1 - S)^iterations)/S what the forcing iterations make of a slip, and R the velocity at the markers
/// per force, a sum over the box's waves. The slip of the bare sum f c is F/alpha; half of F S stands between
/// it and the fluid's velocity. Continuum in time; waves decay as nu k^2.
std::complex<double> marker_plate_force(std::span<const double> weights, int iterations, double omega,
                                        double viscosity);

/// Force that keeps a cylinder oscillating across its axis in an unbounded fluid, per length and velocity:
/// i omega pi a^2 (1 + 4 K1(z)/(z K0(z))), z = a sqrt(i omega/nu); without what is inside of it. Contains the
/// added mass pi a^2.                                                            [stokes-1851]  [M L^-1 T^-1]
std::complex<double> oscillating_cylinder_force(double radius, double omega, double viscosity);

/// Uniform velocity that the images of an oscillating line force in a periodic square of that side add at its
/// place, per force and length, when no mean pressure gradient holds the fluid: 1/(2 i omega side^2) +
/// sum K0(k R)/(4 pi nu) over the images' distances R. From the sum over Fourier modes less their integral,
/// in which a square's symmetry makes (1 - k_x^2/k^2) one half.                    [hasimoto-1959]  [T M^-1
/// L]
std::complex<double> backflow_of_images(double side, double omega, double viscosity);

/// What a compressible fluid adds to it for a force on a circle of that radius: the sound waves of the box,
/// i omega/(2 side^2) sum J0(k radius)^2/(c^2 k^2 - omega^2), undamped, over the lattice's waves with
/// components up to pi.                                                                       [T M^-1 L]
std::complex<double> compression_of_box(double side, double radius, double omega, double sound_speed_squared);

}  // namespace veriflex::analytic
