#include "analytic/channel.hpp"

#include <cmath>
#include <numbers>

#include "base/mutant.hpp"

namespace veriflex::analytic {

using std::numbers::pi;

double plane_poiseuille(double y, double height) { return 0.5 * y * (height - y); }

double half_way_slip(double relaxation_time) {
  const double s = relaxation_time - 0.5;
  return (16.0 * s * s - (planted(Mutant::slip_reference_off) ? 2.0 : 3.0)) / (8.0 * s);
}

double square_duct(double y, double z, double width) {
  double sum = 0.0;
  const double to_wall = std::min(z, width - z) / width;
  for (int n = 1;; n += planted(Mutant::duct_series_thinned) ? 4 : 2) {
    // cosh(n pi (z - width/2)/width)/cosh(n pi/2) without overflow.
    const double decay =
        (std::exp(-n * pi * to_wall) + std::exp(-n * pi * (1.0 - to_wall))) / (1.0 + std::exp(-n * pi));
    const double term = decay / (static_cast<double>(n) * n * n);
    sum += term * std::sin(n * pi * y / width);
    if (term < 1e-17) break;
  }
  return plane_poiseuille(y, width) - 4.0 * width * width / (pi * pi * pi) * sum;
}

std::complex<double> oscillating_poiseuille(double y, double height, double omega, double viscosity) {
  const std::complex<double> i_omega(0.0, planted(Mutant::womersley_real) ? -omega : omega);
  const std::complex<double> k = std::sqrt(i_omega / viscosity);
  return (1.0 - std::cosh(k * (y - 0.5 * height)) / std::cosh(0.5 * k * height)) / i_omega;
}

double cylinder_array_drag(double c) {
  return 4.0 * pi / (-0.5 * std::log(c) - 0.738 + c - 0.887 * c * c + 2.038 * c * c * c);
}

double sphere_array_drag(double c) {
  const double root = std::cbrt(c);
  return 1.0 / (1.0 - 1.7601 * root + c - 1.5593 * c * c + 3.9799 * c * c * root * root -
                3.0734 * c * c * c * root);
}

}  // namespace veriflex::analytic
