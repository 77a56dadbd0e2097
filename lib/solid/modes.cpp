#include "solid/modes.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/memory.hpp"
#include "base/mutant.hpp"
#include "base/reduce.hpp"
#include "solid/dof_map.hpp"
#include "solid/inadmissible.hpp"
#include "solid/symmetric_eigenvalue.hpp"

namespace veriflex::solid {

namespace {

using Sparse = Eigen::SparseMatrix<double>;

constexpr double tolerance = 1e-11;
// Below this many coordinates a dense solver is faster and cannot fail to converge.
constexpr Eigen::Index dense_size = 200;

double frequency(double eigenvalue, double node_mass) {
  return std::copysign(
      std::sqrt(std::abs(eigenvalue) / (planted(Mutant::frequency_without_mass) ? 1.0 : node_mass)),
      eigenvalue);
}

/// Assembly holds every entry twice, once per contribution and once kept.
void refuse_beyond_memory(const Material& material, const Network& network) {
  const double angles = material.has_angles() ? static_cast<double>(network.angles.size()) : 0.0;
  const double entries = 36.0 * static_cast<double>(network.bonds.size()) + 144.0 * angles;
  const double bytes = 2.0 * entries * sizeof(Eigen::Triplet<double>);
  const double available = available_memory_bytes();
  if (bytes <= available) return;
  throw NumericalFailure(
      fmt::format("the Hessian of a body of {} nodes takes {:.3g} GB, {:.3g} GB of memory are available",
                  network.node_count(), 1e-9 * bytes, 1e-9 * available));
}

}  // namespace

Sparse free_hessian(const Material& material, const Network& network, const Positions& u,
                    const FixedDofs& held) {
  refuse_beyond_memory(material, network);
  return visit(material, [&](const auto& law, const auto& angle) {
    const NetworkParts network_parts = parts_of(network);
    Workspace work;
    Positions unused;
    if (!deform(law, network, u, work) || !gradient(law, angle, network, work, unused)) {
      throw NumericalFailure("no Hessian: " + what_is_inadmissible(material, network, u), FailureMode::Bond);
    }
    const Sparse h = DofMap(held).restrict(hessian(law, angle, network, work));
    if (!std::isfinite(infinity_norm(h)))
      throw NumericalFailure("the Hessian leaves double precision", FailureMode::NotFinite);
    return h;
  });
}

double largest_frequency(const Material& material, const Network& network, const Positions& u,
                         const FixedDofs& held, double node_mass) {
  const Sparse h = free_hessian(material, network, u, held);
  if (h.rows() == 0) return 0.0;
  if (h.rows() <= dense_size) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> all(Eigen::MatrixXd(h), Eigen::EigenvaluesOnly);
    return frequency(
        planted(Mutant::smallest_frequency) ? smallest(all.eigenvalues()) : largest(all.eigenvalues()),
        node_mass);
  }
  if (infinity_norm(h) == 0.0) return 0.0;
  const auto product = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
    return h.selfadjointView<Eigen::Lower>() * x;
  };
  return frequency(largest_eigenvalue(product, h.rows(), tolerance, "largest frequency"), node_mass);
}

Eigen::VectorXd lowest_frequencies(const Material& material, const Network& network, const Positions& u,
                                   const FixedDofs& held, double node_mass, int count) {
  const Sparse h = free_hessian(material, network, u, held);
  const int wanted = std::min(count, static_cast<int>(h.rows()));
  Eigen::VectorXd eigenvalues;
  if (h.rows() <= dense_size) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> all(Eigen::MatrixXd(h), Eigen::EigenvaluesOnly);
    eigenvalues = all.eigenvalues().head(wanted);
  } else {
    // A shift just below zero: never singular for a stable state, and near the modes that are wanted.
    const double shift = -1e-9 * h.norm();
    Sparse shifted = h;
    shifted.diagonal().array() -= shift;
    const Cholesky factor(shifted);
    if (factor.info() != Eigen::Success)
      throw NumericalFailure("lowest frequencies: the Hessian is singular");
    const auto solve = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd { return factor.solve(x); };
    eigenvalues =
        largest_eigenvalues(solve, h.rows(), wanted, tolerance, "lowest frequencies").cwiseInverse().array() +
        shift;
    std::sort(eigenvalues.begin(), eigenvalues.end());
  }
  return eigenvalues.unaryExpr([&](double e) { return frequency(e, node_mass); });
}

Positions linear_response(const Material& material, const Network& network, const FixedDofs& held,
                          const Positions& load) {
  const DofMap dofs(held);
  const Sparse h = free_hessian(material, network, Positions::Zero(network.node_count(), 3), held);
  Cholesky factor;
  factor.analyzePattern(h);
  factorize_stable(factor, h, 0);
  const parts::Built part(parts::Kind::Statics, bytes_of(h) + bytes_of(factor));
  const Eigen::VectorXd force = dofs.gather(load);
  Eigen::VectorXd u = factor.solve(force);
  u += factor.solve(force - h * u);  // one step of refinement: slender bodies are ill conditioned
  return dofs.scatter(u, 1.0);
}

}  // namespace veriflex::solid
