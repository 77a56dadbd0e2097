#include "fluid/initial.hpp"

#include "base/mutant.hpp"

namespace veriflex::fluid {

Populations near_equilibrium(double rho, const Vec3& u, const Mat3& gradient, double relaxation_time) {
  Populations h = equilibrium(rho, u);
  const double divergence = gradient.trace();
  for (std::size_t q = 0; q < Q; ++q) {
    const Vec3 v(c[q][0], c[q][1], c[q][2]);
    const double along = v.dot(gradient * v) - sound_speed_squared * divergence;
    h[q] -= (planted(Mutant::initial_stress_reversed) ? -3.0 : 3.0) * relaxation_time * rho *
            w(static_cast<int>(q)) * along;
  }
  return h;
}

}  // namespace veriflex::fluid
