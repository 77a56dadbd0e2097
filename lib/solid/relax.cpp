#include "solid/relax.hpp"

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "base/reduce.hpp"
#include "base/stop.hpp"
#include "solid/dof_map.hpp"
#include "solid/force_scale.hpp"
#include "solid/inadmissible.hpp"
#include "solid/modes.hpp"
#include "solid/newton.hpp"

namespace veriflex::solid {

namespace {

template <bond::BondLaw Law, class AngleTerm>
Equilibrium by_damped_dynamics(double wanted_residual, const Material& material, const Law& law,
                               const AngleTerm& angle, const Network& network, const Positions& start,
                               const FixedDofs& held, const Positions& load) {
  constexpr double mass = 1.0, share_of_limit = 0.9;
  const double step = share_of_limit * 2.0 / largest_frequency(material, network, start, held, mass);
  const DofMap dofs(held);
  Workspace work;
  Positions u = start, gradient_of_potential;
  Eigen::VectorXd g, v = Eigen::VectorXd::Zero(dofs.count);
  const NetworkParts network_parts = parts_of(network);
  parts::Built motion(parts::Kind::LeapFrog, 0.0);
  const parts::Built constraints(parts::Kind::Constraints, parts::array_bytes(dofs.number));
  double before = 0.0;  // kinetic energy, twice and over the mass
  const int most = 20000 + 400 * dofs.count;
  for (int evaluations = 1; evaluations <= most; ++evaluations) {
    stop_if_asked("step", evaluations);
    const bool defined =
        deform(law, network, u, work) && gradient(law, angle, network, work, gradient_of_potential);
    if (!defined) {
      throw NumericalFailure(fmt::format("damped dynamics, step {}: {}", evaluations,
                                         what_is_inadmissible(material, network, u)),
                             FailureMode::Bond);
    }
    gradient_of_potential -= load;
    g = dofs.gather(gradient_of_potential);
    if (evaluations == 1)
      motion.takes(parts::array_bytes(u, gradient_of_potential, g, v, work.d, work.g) + work.stars.bytes());
    const double residual = largest_magnitude(g) / worse(force_scale(law, work), largest_magnitude(load));
    if (residual <= (planted(Mutant::damped_dynamics_stops_early) ? 1e6 : 1.0) * wanted_residual)
      return {u, held.select(gradient_of_potential.array(), 0.0), evaluations, residual};
    v -= step / mass * g;
    const double now = v.squaredNorm();
    if (now < before) v = -0.5 * step / mass * g;  // let go again, from rest
    before = now < before ? 0.0 : now;
    u += dofs.scatter(v, step);
  }
  throw NumericalFailure(
      fmt::format("damped dynamics: no static equilibrium after {} evaluations of the forces", most),
      FailureMode::NotConverged);
}

}  // namespace

Equilibrium relax(const Statics& how, const Material& material, const Network& network, const Positions& u,
                  const FixedDofs& held, const Positions& load) {
  if (how.method == Relaxation::DampedDynamics) {
    return visit(material, [&](const auto& law, const auto& angle) {
      return by_damped_dynamics(how.residual, material, law, angle, network, u, held, load);
    });
  }
  const LinearSolver solver =
      how.method == Relaxation::ConjugateGradients ? LinearSolver::Iterate : LinearSolver::Factor;
  return newton(solver, material, network, u, held, load, {}, how.residual);
}

}  // namespace veriflex::solid
