#include "solid/statics.hpp"

#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"

namespace veriflex::solid {

namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Cholesky = Eigen::SimplicialLDLT<Sparse>;

constexpr double wanted_residual = 1e-12;
constexpr int most_iterations = 200;
constexpr double epsilon = std::numeric_limits<double>::epsilon();
// Eigenvalues of the Hessian below this part of its norm are zero: rounding leaves up to about 1e-15 of it.
constexpr double zero_mode = 1e-12;

// Numbers the free coordinates.
struct Freedom {
  Eigen::VectorXi number;  // of coordinate axis * nodes + node; -1 where held
  int count = 0;

  explicit Freedom(const Held& held) : number(held.size()) {
    for (Eigen::Index i = 0; i < held.size(); ++i) number[i] = held.data()[i] ? -1 : count++;
  }
  Eigen::VectorXd gather(const Positions& all) const {
    Eigen::VectorXd free(count);
    for (Eigen::Index i = 0; i < number.size(); ++i) {
      if (number[i] >= 0) free[number[i]] = all.data()[i];
    }
    return free;
  }
  Positions scatter(const Eigen::VectorXd& free, double scale) const {
    Positions all = Positions::Zero(number.size() / 3, 3);
    for (Eigen::Index i = 0; i < number.size(); ++i) {
      if (number[i] >= 0) all.data()[i] = scale * free[number[i]];
    }
    return all;
  }
};

Sparse free_part(const std::vector<Eigen::Triplet<double>>& hessian, const Freedom& freedom) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& t : hessian) {
    const int row = freedom.number[t.row()];
    const int col = freedom.number[t.col()];
    if (row >= 0 && col >= 0) entries.emplace_back(row, col, t.value());
  }
  Sparse h(freedom.count, freedom.count);
  h.setFromTriplets(entries.begin(), entries.end());
  return h;
}

double infinity_norm(const Sparse& h) {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(h.rows());
  for (Eigen::Index k = 0; k < h.outerSize(); ++k) {
    for (Sparse::InnerIterator it(h, k); it; ++it) sums[it.row()] += std::abs(it.value());
  }
  return sums.size() == 0 ? 0.0 : sums.maxCoeff();
}

// How many eigenvalues of h lie below `shift`, by Sylvester's law of inertia.
Eigen::Index eigenvalues_below(const Sparse& h, double shift) {
  Sparse shifted = h;
  for (Eigen::Index i = 0; i < h.rows(); ++i) shifted.coeffRef(i, i) -= shift;
  const Cholesky factor(shifted);
  if (factor.info() != Eigen::Success) throw NumericalFailure("singular: its zero modes cannot be counted");
  return (factor.vectorD().array() < 0.0).count();
}

[[noreturn]] void fail_as_singular(const Sparse& h, int iteration) {
  const double small = zero_mode * infinity_norm(h);
  // For a matrix of zeros (all bonds slack) every mode is a zero mode.
  const Eigen::Index negative = small > 0.0 ? eigenvalues_below(h, -small) : 0;
  const Eigen::Index zero = small > 0.0 ? eigenvalues_below(h, small) - negative : h.rows();
  const std::string where = fmt::format("at Newton step {} over {} free coordinates", iteration, h.rows());
  if (negative > 0)
    throw NumericalFailure(fmt::format("unstable: {} negative, {} zero modes ({})", negative, zero, where));
  throw NumericalFailure(fmt::format("mechanism: {} zero modes ({})", zero, where));
}

// The force that a residual is measured against: the largest tension, or what a strain of 1e-3 would give.
// (Below that strain the rounding of a bond's length alone exceeds 1e-12 of its tension.)
template <bond::BondLaw Law>
double force_scale(const Law& law, const Workspace& work) {
  double scale = 0.0;
  for (Eigen::Index b = 0; b < work.d.rows(); ++b) {
    const double r = work.d.row(b).norm();
    scale = std::max({scale, std::abs(law.tension(r)), 1e-3 * law.stiffness(r) * r});
  }
  return scale;
}

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
  Positions gradient;  // of the energy, all coordinates
  Eigen::VectorXd g;   // out-of-balance force on the free coordinates, negative
};

double size(const Eigen::VectorXd& v) { return v.size() == 0 ? 0.0 : v.lpNorm<Eigen::Infinity>(); }

template <bond::BondLaw Law, class AngleTerm>
Equilibrium solve(const Law& law, const AngleTerm& angle, const Network& network, const Positions& start,
                  const Held& held, const Positions& load) {
  const Freedom freedom(held);
  // Evaluates the state at u; false where the energy does not exist.
  const auto evaluate = [&](const Positions& u, State& state) {
    state.u = u;
    if (!deform(law, angle, network, u, state.work)) return false;
    gradient(law, angle, network, state.work, state.gradient);
    state.g = freedom.gather(state.gradient - load);
    return true;
  };
  const auto potential = [&](const State& state) {
    return energy(law, angle, network, state.work) - load.cwiseProduct(state.u).sum();
  };

  State now;
  State next;
  if (!evaluate(start, now)) {
    throw NumericalFailure(fmt::format(
        "the start of a static solution has a bond outside the domain of {} or a degenerate angle",
        Law::name));
  }
  Cholesky factor;
  double previous = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration <= most_iterations; ++iteration) {
    const Sparse h = free_part(hessian(law, angle, network, now.work), freedom);
    const double stiffest = infinity_norm(h);
    if (freedom.count > 0) {
      if (iteration == 0) factor.analyzePattern(h);
      factor.factorize(h);
      // A small pivot by itself is no proof of a zero mode (long chains have them), so the count decides.
      const bool suspicious =
          factor.info() != Eigen::Success || !(factor.vectorD().minCoeff() > 100.0 * zero_mode * stiffest);
      if (suspicious && (!(stiffest > 0.0) || eigenvalues_below(h, zero_mode * stiffest) > 0)) {
        fail_as_singular(h, iteration);
      }
    }
    const double force = std::max(force_scale(law, now.work), load.cwiseAbs().maxCoeff());
    // Bond vectors are rounded to epsilon times themselves and the displacements: forces cannot be balanced
    // better.
    const double longest = now.work.d.rowwise().norm().maxCoeff();
    const double rounding = 2.0 * epsilon * (now.u.cwiseAbs().maxCoeff() + longest) * stiffest;
    const bool no_longer_helps = size(now.g) <= rounding && size(now.g) >= 0.5 * previous;
    previous = size(now.g);
    if (size(now.g) <= wanted_residual * force || no_longer_helps) {
      Positions reaction = now.gradient - load;
      for (Eigen::Index i = 0; i < held.size(); ++i) {
        if (!held.data()[i]) reaction.data()[i] = 0.0;
      }
      return {now.u, reaction, iteration, size(now.g) / force};
    }
    const Eigen::VectorXd step = factor.solve(-now.g);
    const double slope = step.dot(now.g);
    for (double scale = 1.0;; scale *= 0.5) {
      if (scale < 1e-12) {
        throw NumericalFailure(
            fmt::format("static solution stuck at Newton step {} (out-of-balance force {} of the largest)",
                        iteration, size(now.g) / force));
      }
      const Positions move = freedom.scatter(step, scale);
      if (!keeps_clear(law, network, now.work, move) || !evaluate(now.u + move, next)) continue;
      // Near the solution the energy no longer resolves the step, the force does.
      if (size(next.g) < 0.9 * size(now.g) || size(now.g) <= rounding ||
          potential(next) < potential(now) + 1e-4 * scale * slope) {
        std::swap(now, next);
        break;
      }
    }
  }
  throw NumericalFailure(fmt::format("no static equilibrium after {} Newton steps", most_iterations));
}

}  // namespace

Equilibrium equilibrium(const Material& material, const Network& network, const Positions& u,
                        const Held& held, const Positions& load) {
  return visit(material,
               [&](const auto& law, const auto& angle) { return solve(law, angle, network, u, held, load); });
}

}  // namespace veriflex::solid
