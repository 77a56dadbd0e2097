/// Energy of all bonds of a network, its gradient and its Hessian, compiled for one bond law.
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "bond/bond_law.hpp"
#include "solid/network.hpp"

namespace veriflex::solid {

/// The bond's vector after the displacement u.
inline Vec3 deformed(const Bond& bond, const Positions& u) {
  return bond.vector + (u.col(bond.second) - u.col(bond.first));
}

/// Whether every bond has a length that the law admits (false for NaN).
template <bond::BondLaw Law>
bool all_admitted(const Law& law, const Network& network, const Positions& u) {
  const Interval domain = law.domain();
  for (const Bond& bond : network.bonds) {
    if (!domain.contains(deformed(bond, u).norm())) return false;
  }
  return true;
}

/// Sum of U over the bonds, each once  [M L^2 T^-2].
template <bond::BondLaw Law>
double energy(const Law& law, const Network& network, const Positions& u) {
  double total = 0.0;
  for (const Bond& bond : network.bonds) total += law.energy(deformed(bond, u).norm());
  return total;
}

/// Gradient of the energy, one column per node: minus the force on it  [M L T^-2].
template <bond::BondLaw Law>
Positions gradient(const Law& law, const Network& network, const Positions& u) {
  Positions g = Positions::Zero(3, u.cols());
  for (const Bond& bond : network.bonds) {
    const Vec3 d = deformed(bond, u);
    const double r = d.norm();
    const Vec3 pull = law.tension(r) / r * d;
    g.col(bond.second) += pull;
    g.col(bond.first) -= pull;
  }
  return g;
}

/// Second derivatives of the energy as triplets over degrees of freedom 3 node + axis; entries of one pair
/// may repeat and add up  [M T^-2].
template <bond::BondLaw Law>
std::vector<Eigen::Triplet<double>> hessian(const Law& law, const Network& network, const Positions& u) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(36 * network.bonds.size());
  for (const Bond& bond : network.bonds) {
    const Vec3 d = deformed(bond, u);
    const int i = bond.first;
    const int j = bond.second;
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
