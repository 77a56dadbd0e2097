#include "analytic/exact_solid.hpp"

#include <cmath>
#include <numbers>

#include "base/root.hpp"

namespace veriflex::analytic {

ElasticaTip elastica_tip(double load) {
  // The integrals lose digits to 1 - (1 - load/3 ...): small loads by the series of slope(s) = load (s -
  // s^2/2) + load^3 ((s^4/12 - s^5/20 + s^6/120)/2 - s/15) + ...
  if (load < 1e-3) {
    const double squared = load * load;
    return {load * (1.0 / 3.0 - 4.0 / 105.0 * squared), 1.0 - squared / 15.0,
            load * (0.5 - 11.0 / 240.0 * squared)};
  }
  const double root = std::sqrt(load);
  // All by u = pi/2 - slope, which stays precise at both ends: k = cos(u/2), tan(theta) = 1/sqrt(sin slope).
  const auto modulus = [](double u) { return std::cos(0.5 * u); };
  const auto theta = [](double u) { return std::atan2(1.0, std::sqrt(std::cos(u))); };
  const double u = bracketed_root(
      [&](double x) { return std::comp_ellint_1(modulus(x)) - std::ellint_1(modulus(x), theta(x)) - root; },
      1e-6, 0.5 * std::numbers::pi);
  const double second = std::comp_ellint_2(modulus(u)) - std::ellint_2(modulus(u), theta(u));
  return {1.0 - 2.0 * second / root, std::sqrt(2.0 * std::cos(u)) / root, 0.5 * std::numbers::pi - u};
}

double torsion_constant_of_square() {
  double sum = 0.0;
  // Up to where a term no longer counts in double precision.
  for (int n = 1999; n > 0; n -= 2) sum += std::tanh(0.5 * n * std::numbers::pi) / std::pow(n, 5);
  return 1.0 / 3.0 - 64.0 / std::pow(std::numbers::pi, 5) * sum;
}

}  // namespace veriflex::analytic
