#include "analytic/immersed.hpp"

#include <cmath>
#include <numbers>

namespace veriflex::analytic {

using Complex = std::complex<double>;
using std::numbers::pi;

namespace {

/// sqrt(i omega/nu), over the thickness of the Stokes layer  [L^-1].
Complex wavenumber(double omega, double viscosity) { return std::sqrt(Complex(0.0, omega / viscosity)); }

constexpr double negligible = 45.0;  // exp(-45) is below round-off

}  // namespace

Complex bessel_k(int n, Complex z) {
  constexpr double step = 0.02;
  Complex sum =
      0.5;  // of exp(-z (cosh t - 1)) cosh(n t): K0 of a large argument does not vanish before its use
  for (int i = 1;; ++i) {
    const double t = step * i;
    const double grown = std::cosh(t) - 1.0;
    if (z.real() * grown > negligible + n * t) break;
    sum += std::exp(-z * grown) * std::cosh(n * t);
  }
  return step * sum * std::exp(-z);
}

Complex oscillating_plate(double y, double height, double omega, double viscosity) {
  const Complex k = wavenumber(omega, viscosity);
  return (std::exp(-k * y) + std::exp(-k * (height - y))) / (1.0 + std::exp(-k * height));
}

Complex oscillating_plate_force(double height, double omega, double viscosity) {
  const Complex k = wavenumber(omega, viscosity);
  return 2.0 * viscosity * k * std::tanh(0.5 * k * height);
}

Complex marker_plate_force(std::span<const double> weights, int iterations, double omega, double viscosity) {
  const auto nodes = static_cast<int>(weights.size());
  double squares = 0.0;
  for (const double w : weights) squares += w * w;
  Complex response = 0.0;
  for (int n = 0; n < nodes; ++n) {
    const double k = 2.0 * pi * (n <= nodes / 2 ? n : n - nodes) / nodes;
    Complex amplitude = 0.0;
    for (int j = 0; j < nodes; ++j)
      amplitude += weights[static_cast<std::size_t>(j)] * std::polar(1.0, k * j);
    response += std::norm(amplitude) / Complex(viscosity * k * k, omega) / static_cast<double>(nodes);
  }
  const double alpha = (1.0 - std::pow(1.0 - squares, iterations)) / squares;
  return 1.0 / (1.0 / alpha + response - 0.5 * squares);
}

Complex oscillating_cylinder_force(double radius, double omega, double viscosity) {
  const Complex z = radius * wavenumber(omega, viscosity);
  return Complex(0.0, omega) * pi * radius * radius * (1.0 + 4.0 * bessel_k(1, z) / (z * bessel_k(0, z)));
}

Complex backflow_of_images(double side, double omega, double viscosity) {
  const Complex k = wavenumber(omega, viscosity);
  const auto reach = static_cast<int>(std::ceil(negligible / (k.real() * side)));
  Complex sum = 0.0;
  for (int i = -reach; i <= reach; ++i) {
    for (int j = -reach; j <= reach; ++j) {
      const double distance = side * std::hypot(i, j);
      if (distance > 0.0 && k.real() * distance < negligible) sum += bessel_k(0, k * distance);
    }
  }
  return 1.0 / (2.0 * Complex(0.0, omega) * side * side) + sum / (4.0 * pi * viscosity);
}

Complex compression_of_box(double side, double radius, double omega, double sound_speed_squared) {
  const auto shortest = static_cast<int>(0.5 * side);
  double sum = 0.0;
  for (int i = 1; i <= shortest; ++i) {  // a quarter of the modes, the others by symmetry
    for (int j = 0; j <= shortest; ++j) {
      const double k = 2.0 * pi / side * std::hypot(i, j);
      const double share = std::cyl_bessel_j(0.0, k * radius);
      sum += 4.0 * share * share / (sound_speed_squared * k * k - omega * omega);
    }
  }
  return Complex(0.0, omega) * sum / (2.0 * side * side);
}

}  // namespace veriflex::analytic
