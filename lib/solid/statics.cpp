#include "solid/statics.hpp"

#include <fmt/format.h>

#include <Eigen/IterativeLinearSolvers>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "base/reduce.hpp"
#include "base/stop.hpp"
#include "solid/dof_map.hpp"
#include "solid/force_scale.hpp"
#include "solid/inadmissible.hpp"
#include "solid/newton.hpp"
#include "solid/relax.hpp"

namespace veriflex::solid {

namespace {

constexpr int max_iterations = 200;
constexpr double kept_helps = 0.5;  // of the out-of-balance force that a step with an old factor may leave
constexpr double epsilon = std::numeric_limits<double>::epsilon();

// Whether no bond, anywhere on the straight way from its vector in `work` over `step`, comes nearer to a
// limit of the law than a twentieth of its present distance. The way counts, not its end: a node must not
// jump through its neighbour.
template <bond::BondLaw Law>
bool keeps_clear(const Law& law, const Network& network, const Workspace& work, const Positions& step) {
  const auto [lo, hi] = law.domain();
  for (Eigen::Index b = 0; b < work.d.rows(); ++b) {
    const Bond& bond = network.bonds[static_cast<std::size_t>(b)];
    const Vec3 from = work.d.row(b);
    const Vec3 change = step.row(bond.second) - step.row(bond.first);
    const double squared = change.squaredNorm();
    const double nearest = squared > 0.0 ? std::clamp(-from.dot(change) / squared, 0.0, 1.0) : 0.0;
    const double least = (from + nearest * change).norm();
    const double largest = std::max(from.norm(), (from + change).norm());
    const double r = from.norm();
    if (!(least - lo >= 0.05 * (r - lo))) return false;
    if (std::isfinite(hi) && !(hi - largest >= 0.05 * (hi - r))) return false;
  }
  return true;
}

// A displacement with all that the solver asks of it.
struct State {
  Positions u;
  Workspace work;
  Positions gradient;  // of the potential, all coordinates
  Eigen::VectorXd g;   // out-of-balance force on the free coordinates, negative
};

// Close enough for a step that another follows. A factor would have told that h is not positive definite.
Eigen::VectorXd conjugate_gradient_step(const Eigen::SparseMatrix<double>& h, const Eigen::VectorXd& g,
                                        int newton_step) {
  Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower> iteration(h);
  iteration.setTolerance(1e-3);
  iteration.setMaxIterations(20 * h.rows());
  const Eigen::VectorXd step = iteration.solve(-g);
  if (!(step.dot(g) < 0.0)) {
    throw NumericalFailure(fmt::format("unstable: Newton step {} would go uphill", newton_step),
                           FailureMode::Equilibrium);
  }
  return step;
}

template <bond::BondLaw Law, class AngleTerm>
Equilibrium solve(const Material& material, const Law& law, const AngleTerm& angle, const Network& network,
                  const Positions& start, const FixedDofs& held, const Positions& load,
                  const Inertia& inertia, LinearSolver solver, double wanted_residual, KeptFactor* kept) {
  const bool is_static = inertia.stiffness.size() == 0;
  const DofMap dofs(held);
  // Evaluates the state at u; false where the energy does not exist.
  const auto evaluate = [&](const Positions& u, State& state) {
    state.u = u;
    if (!deform(law, network, u, state.work)) return false;
    if (!gradient(law, angle, network, state.work, state.gradient)) return false;
    state.gradient -= load;
    if (!is_static) state.gradient += inertia.stiffness.asDiagonal() * (u - inertia.predicted);
    state.g = dofs.gather(state.gradient);
    return true;
  };
  const auto potential = [&](const State& state) {
    const double dead = energy(law, angle, network, state.work) - load.cwiseProduct(state.u).sum();
    return is_static
               ? dead
               : dead + 0.5 * inertia.stiffness.dot((state.u - inertia.predicted).rowwise().squaredNorm());
  };
  const auto hessian_of = [&](const State& state) {
    std::vector<Eigen::Triplet<double>> second = hessian(law, angle, network, state.work);
    if (!is_static) {
      for (int i = 0; i < static_cast<int>(held.size()); ++i)
        second.emplace_back(i, i, inertia.stiffness[i % inertia.stiffness.size()]);
    }
    return dofs.restrict(second);
  };
  // Bond vectors are rounded to epsilon times themselves and the displacements: forces cannot be balanced
  // better.
  const auto rounding_of = [](const State& state, double stiffest) {
    const double longest = largest(state.work.d.rowwise().norm());
    return 2.0 * epsilon * (largest_magnitude(state.u) + longest) * stiffest;
  };
  const auto solution = [&](const State& state, int iterations, double force) -> Equilibrium {
    Positions reaction = state.gradient;
    for (Eigen::Index i = 0; i < held.size(); ++i) {
      if (!held.data()[i]) reaction.data()[i] = 0.0;
    }
    return {state.u, reaction, iterations, largest_magnitude(state.g) / force};
  };

  State now;
  State next;
  if (!evaluate(start, now)) {
    throw NumericalFailure("start of a static solution: " + what_is_inadmissible(material, network, start),
                           FailureMode::Bond);
  }
  const NetworkParts network_parts = parts_of(network);
  const auto bytes_of_state = [](const State& state) {
    return parts::array_bytes(state.u, state.gradient, state.g, state.work.d, state.work.g) +
           state.work.stars.bytes();
  };
  parts::Built part(parts::Kind::Statics, 0.0);
  Cholesky own;
  Cholesky& factor = kept ? kept->factor : own;
  const auto factorize_at = [&](const State& state, const Eigen::SparseMatrix<double>& h, int iteration) {
    if (factor.rows() == 0) factor.analyzePattern(h);
    factorize_stable(factor, h, iteration);
    if (!kept) return;
    kept->at = state.u;
    kept->stiffest = infinity_norm(h);
    kept->is_made = true;
  };
  if (kept && !kept->is_made && kept->at.size() > 0 && evaluate(kept->at, next))
    factorize_at(next, hessian_of(next), 0);
  double previous = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration <= max_iterations; ++iteration) {
    stop_if_asked("Newton step", iteration);
    const double states = bytes_of_state(now) + bytes_of_state(next);
    part.takes(states + bytes_of(own));
    const double force = worse(force_scale(law, now.work), largest_magnitude(load));
    if (kept && kept->is_made && dofs.count > 0) {
      if (largest_magnitude(now.g) <= std::max(wanted_residual * force, rounding_of(now, kept->stiffest)))
        return solution(now, iteration, force);
      const Positions move = dofs.scatter(kept->factor.solve(-now.g), 1.0);
      if (keeps_clear(law, network, now.work, move) && evaluate(now.u + move, next) &&
          largest_magnitude(next.g) <= kept_helps * largest_magnitude(now.g)) {
        std::swap(now, next);
        continue;
      }
    }
    const Eigen::SparseMatrix<double> h = hessian_of(now);
    const double stiffest = infinity_norm(h);
    if (!std::isfinite(force) || !std::isfinite(stiffest)) {
      throw NumericalFailure(
          fmt::format("static solution at Newton step {}: forces or stiffnesses leave double precision",
                      iteration),
          FailureMode::NotFinite);
    }
    if (dofs.count > 0 && solver == LinearSolver::Factor) factorize_at(now, h, iteration);
    part.takes(states + bytes_of(own) + bytes_of(h));
    const double rounding = rounding_of(now, stiffest);
    const bool no_longer_helps =
        largest_magnitude(now.g) <= rounding && largest_magnitude(now.g) >= 0.5 * previous;
    previous = largest_magnitude(now.g);
    if (largest_magnitude(now.g) <=
            (planted(Mutant::newton_stops_early) ? 1e6 : 1.0) * wanted_residual * force ||
        no_longer_helps)
      return solution(now, iteration, force);
    const Eigen::VectorXd step =
        solver == LinearSolver::Factor ? factor.solve(-now.g) : conjugate_gradient_step(h, now.g, iteration);
    const double slope = step.dot(now.g);
    for (double scale = 1.0;; scale *= 0.5) {
      if (scale < 1e-12) {
        throw NumericalFailure(
            fmt::format("static solution stuck at Newton step {} (out-of-balance force {} of the largest)",
                        iteration, largest_magnitude(now.g) / force),
            FailureMode::NotConverged);
      }
      const Positions move = dofs.scatter(step, scale);
      if ((!planted(Mutant::newton_through_limits) && !keeps_clear(law, network, now.work, move)) ||
          !evaluate(now.u + move, next))
        continue;
      // Near the solution the energy no longer resolves the step, the force does.
      if (largest_magnitude(next.g) < 0.9 * largest_magnitude(now.g) ||
          largest_magnitude(now.g) <= rounding || potential(next) < potential(now) + 1e-4 * scale * slope) {
        std::swap(now, next);
        break;
      }
    }
  }
  throw NumericalFailure(fmt::format("no static equilibrium after {} Newton steps", max_iterations),
                         FailureMode::NotConverged);
}

}  // namespace

Equilibrium newton(LinearSolver solver, const Material& material, const Network& network, const Positions& u,
                   const FixedDofs& held, const Positions& load, const Inertia& inertia, double residual) {
  return visit(material, [&](const auto& law, const auto& angle) {
    return solve(material, law, angle, network, u, held, load, inertia, solver, residual, nullptr);
  });
}

Equilibrium newton_with(KeptFactor& kept, const Material& material, const Network& network,
                        const Positions& u, const FixedDofs& held, const Positions& load,
                        const Inertia& inertia, double residual) {
  return visit(material, [&](const auto& law, const auto& angle) {
    return solve(material, law, angle, network, u, held, load, inertia, LinearSolver::Factor, residual,
                 &kept);
  });
}

Equilibrium equilibrium(const Material& material, const Network& network, const Positions& u,
                        const FixedDofs& held, const Positions& load, const Inertia& inertia) {
  return newton(LinearSolver::Factor, material, network, u, held, load, inertia, Statics{}.residual);
}

void refuse_turned_bonds(const Network& network, const Positions& u) {
  for (std::size_t b = 0; b < network.bonds.size(); ++b) {
    const Bond& bond = network.bonds[b];
    const Vec3 at_rest = network.vectors.row(static_cast<Eigen::Index>(b));
    const Vec3 now = at_rest + Vec3(u.row(bond.second) - u.row(bond.first));
    if (now.dot(at_rest) > 0.0) continue;
    throw NumericalFailure(
        fmt::format("the bond of nodes {} and {} has turned round: the body has passed through itself",
                    network.id_of(bond.first), network.id_of(bond.second)),
        FailureMode::Bond);
  }
}

}  // namespace veriflex::solid
