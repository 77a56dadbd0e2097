#include "analytic/elastic_layer.hpp"

namespace veriflex::analytic {

using Complex = std::complex<double>;

namespace {

const Complex i(0.0, 1.0);

/// What the formulas of the header call k, Z and Y.
struct Coefficients {
  Complex k, solid, fluid;
};

Coefficients coefficients_of(const ElasticLayer& l) {
  const double mu = l.fluid_density * l.viscosity;
  const Complex lambda = std::sqrt(i * l.omega / l.viscosity);
  Complex modulus = l.shear_modulus;
  double density = l.density;
  if (l.filling == Filling::Moving) {
    modulus += i * l.omega * mu;
    density += l.fluid_density;
  }
  const Complex k = l.omega * std::sqrt(density / modulus);
  Complex fluid = mu * lambda / std::tanh(lambda * (l.height - l.thickness));
  if (l.filling == Filling::Between) fluid += mu * lambda * std::tanh(lambda * l.thickness);
  return {k, modulus * k / (i * l.omega), fluid};
}

}  // namespace

Complex layer_velocity(const ElasticLayer& l, double y) {
  const auto [k, Z, Y] = coefficients_of(l);
  const Complex c = std::cos(k * l.thickness), s = std::sin(k * l.thickness);
  return std::cos(k * y) + (Z * s - Y * c) / (Z * c + Y * s) * std::sin(k * y);
}

Complex interface_velocity(const ElasticLayer& l) {
  const auto [k, Z, Y] = coefficients_of(l);
  return Z / (Z * std::cos(k * l.thickness) + Y * std::sin(k * l.thickness));
}

}  // namespace veriflex::analytic
