#include "analytic/decaying_flow.hpp"

#include <cmath>

namespace veriflex::analytic {

double DecayingFlow::decay_rate() const {
  return (pattern == Pattern::TaylorGreen ? 2.0 : 1.0) * viscosity * wavenumber * wavenumber;
}

FlowState DecayingFlow::at(const Vec3& x, double time) const {
  const double K = wavenumber;
  const double U = amplitude * std::exp(-decay_rate() * time);
  const Vec3 phase = K * (x - stream * time);
  const double cos_a = std::cos(phase[a]), sin_a = std::sin(phase[a]);
  FlowState flow{0.0, stream, Mat3::Zero()};
  if (pattern == Pattern::Shear) {
    flow.velocity[b] += U * cos_a;
    flow.gradient(a, b) = -K * U * sin_a;
    return flow;
  }
  const double cos_b = std::cos(phase[b]), sin_b = std::sin(phase[b]);
  flow.pressure = -0.25 * U * U * (std::cos(2.0 * phase[a]) + std::cos(2.0 * phase[b]));
  flow.velocity[a] -= U * cos_a * sin_b;
  flow.velocity[b] += U * sin_a * cos_b;
  flow.gradient(a, a) = K * U * sin_a * sin_b;
  flow.gradient(b, a) = -K * U * cos_a * cos_b;
  flow.gradient(a, b) = K * U * cos_a * cos_b;
  flow.gradient(b, b) = -K * U * sin_a * sin_b;
  return flow;
}

// grad phi with laplace phi = div u. There, dp/dt = nu K^2 A^2 [cos(2a) + cos(2b)] and u.grad p =
// -A^3 K/4 [sin(3a) sin(b) - sin(a) sin(3b)].
Vec3 DecayingFlow::swelling(const Vec3& x, double sound_speed_squared) const {
  Vec3 u = Vec3::Zero();
  if (pattern == Pattern::Shear) return u;
  const double A = amplitude;
  const double decay = -0.5 * viscosity * wavenumber * A * A / sound_speed_squared;
  const double carried = -0.025 * A * A * A / sound_speed_squared;
  const double p = wavenumber * x[a], q = wavenumber * x[b];
  u[a] = decay * std::sin(2.0 * p) +
         carried * (3.0 * std::cos(3.0 * p) * std::sin(q) - std::cos(p) * std::sin(3.0 * q));
  u[b] = decay * std::sin(2.0 * q) +
         carried * (std::sin(3.0 * p) * std::cos(q) - 3.0 * std::sin(p) * std::cos(3.0 * q));
  return u;
}

}  // namespace veriflex::analytic
