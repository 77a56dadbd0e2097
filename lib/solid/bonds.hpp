/// Energy of all bonds of a network, its gradient and its Hessian, compiled for one bond law.
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "bond/bond_law.hpp"
#include "solid/network.hpp"

namespace veriflex::solid {

/// Whether every bond has a length that the law admits (false for NaN).
template <bond::BondLaw Law>
bool all_admitted(const Law& law, const Network& network, const Positions& x) {
  const Interval domain = law.domain();
  for (const auto& [i, j] : network.bonds) {
    if (!domain.contains((x.col(j) - x.col(i)).norm())) return false;
  }
  return true;
}

/// Sum of U over the bonds, each once  [M L^2 T^-2].
template <bond::BondLaw Law>
double energy(const Law& law, const Network& network, const Positions& x) {
  double total = 0.0;
  for (const auto& [i, j] : network.bonds) total += law.energy((x.col(j) - x.col(i)).norm());
  return total;
}

/// Gradient of the energy, one column per node: minus the force on it  [M L T^-2].
template <bond::BondLaw Law>
Positions gradient(const Law& law, const Network& network, const Positions& x) {
  Positions g = Positions::Zero(3, x.cols());
  for (const auto& [i, j] : network.bonds) {
    const Vec3 d = x.col(j) - x.col(i);
    const double r = d.norm();
    const Vec3 pull = law.tension(r) / r * d;
    g.col(j) += pull;
    g.col(i) -= pull;
  }
  return g;
}

/// Second derivatives of the energy as triplets over degrees of freedom 3 node + axis; entries of one pair may repeat and
/// add up  [M T^-2].
template <bond::BondLaw Law>
std::vector<Eigen::Triplet<double>> hessian(const Law& law, const Network& network, const Positions& x) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(36 * network.bonds.size());
  for (const auto& [i, j] : network.bonds) {
    const Vec3 d = x.col(j) - x.col(i);
    const double r = d.norm();
    const double along = law.stiffness(r);
    const double across = law.tension(r) / r;
    const Eigen::Matrix3d block =
        (along - across) / (r * r) * d * d.transpose() + across * Eigen::Matrix3d::Identity();
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) {
        entries.emplace_back(3 * i + a, 3 * i + b, block(a, b));
        entries.emplace_back(3 * j + a, 3 * j + b, block(a, b));
        entries.emplace_back(3 * i + a, 3 * j + b, -block(a, b));
        entries.emplace_back(3 * j + a, 3 * i + b, -block(a, b));
      }
    }
  }
  return entries;
}

}  // namespace veriflex::solid
