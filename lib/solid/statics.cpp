#include "solid/statics.hpp"

#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "solid/bonds.hpp"

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
  Eigen::VectorXi number;  // of coordinate 3 node + axis; -1 where held
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
    Positions all = Positions::Zero(3, number.size() / 3);
    for (Eigen::Index i = 0; i < number.size(); ++i) {
      if (number[i] >= 0) all.data()[i] = scale * free[number[i]];
    }
    return all;
  }
};

template <bond::BondLaw Law>
Sparse free_hessian(const Law& law, const Network& network, const Positions& u, const Freedom& freedom) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& t : hessian(law, network, u)) {
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
double force_scale(const Law& law, const Network& network, const Positions& u) {
  double scale = 0.0;
  for (const Bond& bond : network.bonds) {
    const double r = deformed(bond, u).norm();
    scale = std::max({scale, std::abs(law.tension(r)), 1e-3 * law.stiffness(r) * r});
  }
  return scale;
}

double longest_bond(const Network& network, const Positions& u) {
  double longest = 0.0;
  for (const Bond& bond : network.bonds) longest = std::max(longest, deformed(bond, u).norm());
  return longest;
}

// Whether no bond, anywhere on the straight way from u to u + step, comes nearer to a limit of the law than a
// twentieth of its present distance. The way counts, not its end: a node must not jump through its neighbour.
template <bond::BondLaw Law>
bool keeps_clear(const Law& law, const Network& network, const Positions& u, const Positions& step) {
  const auto [lo, hi] = law.domain();
  for (const Bond& bond : network.bonds) {
    const Vec3 from = deformed(bond, u);
    const Vec3 change = step.col(bond.second) - step.col(bond.first);
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

template <bond::BondLaw Law>
Equilibrium solve(const Law& law, const Network& network, Positions u, const Held& held,
                  const Positions& load) {
  if (!all_admitted(law, network, u)) {
    throw NumericalFailure(
        fmt::format("the start of a static solution has a bond outside the domain of {}", Law::name));
  }
  const Freedom freedom(held);
  const auto out_of_balance = [&](const Positions& at) {
    return freedom.gather(gradient(law, network, at) - load);
  };
  const auto potential = [&](const Positions& at) {
    return energy(law, network, at) - load.cwiseProduct(at).sum();
  };
  const auto size = [](const Eigen::VectorXd& v) {
    return v.size() == 0 ? 0.0 : v.lpNorm<Eigen::Infinity>();
  };

  Cholesky factor;
  double previous = std::numeric_limits<double>::infinity();
  Eigen::VectorXd g = out_of_balance(u);
  for (int iteration = 0; iteration <= most_iterations; ++iteration) {
    const Sparse h = free_hessian(law, network, u, freedom);
    const double stiffest = infinity_norm(h);
    if (freedom.count > 0) {
      if (iteration == 0) factor.analyzePattern(h);
      factor.factorize(h);
      // A pivot is never larger than the eigenvalues allow: the smallest shows a zero or negative mode. Its
      // being small by itself is no proof (long chains have small pivots), so the count decides.
      const bool suspicious =
          factor.info() != Eigen::Success || !(factor.vectorD().minCoeff() > 100.0 * zero_mode * stiffest);
      if (suspicious && (!(stiffest > 0.0) || eigenvalues_below(h, zero_mode * stiffest) > 0)) {
        fail_as_singular(h, iteration);
      }
    }
    const double scale_of_force = std::max(force_scale(law, network, u), load.cwiseAbs().maxCoeff());
    // Bond lengths are rounded to epsilon times themselves and the displacements: forces cannot be balanced
    // better.
    const double rounding = 2.0 * epsilon * (u.cwiseAbs().maxCoeff() + longest_bond(network, u)) * stiffest;
    const bool no_longer_helps = size(g) <= rounding && size(g) >= 0.5 * previous;
    previous = size(g);
    if (size(g) <= wanted_residual * scale_of_force || no_longer_helps) {
      Positions reaction = gradient(law, network, u) - load;
      for (Eigen::Index i = 0; i < held.size(); ++i) {
        if (!held.data()[i]) reaction.data()[i] = 0.0;
      }
      return {u, reaction, iteration, size(g) / scale_of_force};
    }
    const Eigen::VectorXd step = factor.solve(-g);
    const double slope = step.dot(g);
    double scale = 1.0;
    for (;; scale *= 0.5) {
      if (scale < 1e-12) {
        throw NumericalFailure(
            fmt::format("static solution stuck at Newton step {} (out-of-balance force {} of "
                        "the largest tension)",
                        iteration, size(g) / scale_of_force));
      }
      const Positions move = freedom.scatter(step, scale);
      if (!keeps_clear(law, network, u, move)) continue;
      const Positions next = u + move;
      const Eigen::VectorXd g_next = out_of_balance(next);
      // Near the solution the energy no longer resolves the step, the force does.
      if (size(g_next) < 0.9 * size(g) || size(g) <= rounding ||
          potential(next) < potential(u) + 1e-4 * scale * slope) {
        u = next;
        g = g_next;
        break;
      }
    }
  }
  throw NumericalFailure(fmt::format("no static equilibrium after {} Newton steps", most_iterations));
}

}  // namespace

Equilibrium equilibrium(const bond::AnyLaw& law, const Network& network, const Positions& u, const Held& held,
                        const Positions& load) {
  return std::visit([&](const auto& l) { return solve(l, network, u, held, load); }, law);
}

}  // namespace veriflex::solid
