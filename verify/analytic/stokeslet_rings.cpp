#include "analytic/stokeslet_rings.hpp"

#include <cmath>
#include <numbers>

namespace veriflex::analytic {

namespace {

using Complex = std::complex<double>;

/// Velocity along z per force along z at a place with z^2 = across^2/2, the mean over all directions of a
/// vector of length `across` in the plane across the axis.
Complex oscillating_point_force(double across, double along, Complex k, double viscosity) {
  const double r = std::hypot(across, along);
  const Complex R = k * r;
  const Complex decay = 2.0 * std::exp(-R);
  const Complex a = decay * (1.0 + (1.0 + 1.0 / R) / R) - 2.0 / (R * R);
  const Complex b = -decay * (1.0 + 3.0 * (1.0 + 1.0 / R) / R) + 6.0 / (R * R);
  return (a + 0.5 * b * across * across / (r * r)) / (8.0 * std::numbers::pi * viscosity * r);
}

}  // namespace

Complex ring_on_ring(double distance, double radius, double width, double omega, double viscosity) {
  constexpr int angles = 96;
  constexpr int slices = 8;
  const Complex k = std::sqrt(Complex(0.0, omega / viscosity));
  Complex sum = 0.0;
  for (int i = 0; i < slices; ++i) {
    for (int j = 0; j < slices; ++j) {
      const double along = distance + width * static_cast<double>(i - j) / slices;
      for (int n = 0; n < angles; ++n) {
        const double half_angle = std::numbers::pi * (n + 0.5) / angles;
        sum += oscillating_point_force(2.0 * radius * std::sin(half_angle), along, k, viscosity);
      }
    }
  }
  return sum / static_cast<double>(angles * slices * slices);
}

}  // namespace veriflex::analytic
