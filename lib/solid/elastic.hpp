/// Energy of a network, its gradient and its Hessian, compiled for one bond law and for angles or none.
///
/// The energy is a function of the bonds' vectors alone, so its gradient is first taken by these and then
/// handed to both ends of each bond with opposite signs: no reaction can be missing, and a rigid motion costs
/// nothing.
#pragma once

#include <Eigen/SparseCore>
#include <algorithm>
#include <vector>

#include "base/mutant.hpp"
#include "base/work.hpp"
#include "bond/laws.hpp"
#include "solid/angle.hpp"
#include "solid/network.hpp"

namespace veriflex::solid {

/// No angle term: its loops are not compiled.
struct NoAngle {};

struct HarmonicAngle {
  double stiffness;  // k_a  [M L^2 T^-2]
};

/// What the network is made of.
struct Material {
  bond::AnyLaw law;
  double angle_stiffness;     // k_a; 0 for a network without angles  [M L^2 T^-2]
  bool keeps_angles = false;  // their loop is there although k_a = 0, to show that it changes nothing

  bool has_angles() const { return angle_stiffness != 0.0 || keeps_angles; }
};

/// Calls use(law, angle) with the types that the material stands for.
template <class Use>
auto visit(const Material& material, Use use) {
  return std::visit(
      [&](const auto& law) {
        return material.has_angles()
                   ? use(law, HarmonicAngle{(planted(Mutant::angle_stiffness_doubled) ? 2.0 : 1.0) *
                                            material.angle_stiffness})
                   : use(law, NoAngle{});
      },
      material.law);
}

/// Arrays that the force evaluations of one network need, kept between them.
struct Workspace {
  Positions d;       // deformed vector of each bond  [L]
  Positions g;       // gradient of the energy by it  [M L T^-2]
  AngleStars stars;  // the network's angles, arranged at the first evaluation that needs them
};

/// Deformed bond vectors into work.d; returns whether every bond is inside the law's domain (false for NaN).
template <bond::BondLaw Law>
[[nodiscard]] bool deform(const Law& law, const Network& network, const Positions& u, Workspace& work) {
  work.d.resize(static_cast<Eigen::Index>(network.bonds.size()), 3);
  return deform_bonds(law.domain(), network.bonds.data(), network.bonds.size(), network.vectors.data(),
                      u.data(), static_cast<std::size_t>(u.rows()), work.d.data());
}

/// Sum over the bonds and angles of work.d, each once  [M L^2 T^-2].
template <bond::BondLaw Law, class AngleTerm>
double energy(const Law& law, const AngleTerm& angle, const Network& network, const Workspace& work) {
  double total = 0.0;
  for (Eigen::Index b = 0; b < work.d.rows(); ++b) total += law.energy(work.d.row(b).norm());
  if constexpr (!std::is_same_v<AngleTerm, NoAngle>) {
    double squares = 0.0;
    for (const Angle& t : network.angles) {
      const double deviation = angle_state(t.sign_a * work.d.row(t.bond_a).transpose(),
                                           t.sign_b * work.d.row(t.bond_b).transpose(), t.straight)
                                   .deviation;
      squares += deviation * deviation;
    }
    total += 0.5 * angle.stiffness * squares;
  }
  return total;
}

/// Gradient of the energy at work.d, one row per node: minus the force on it  [M L T^-2]. Returns whether
/// every angle has one (see is_defined()).
template <bond::BondLaw Law, class AngleTerm>
[[nodiscard]] bool gradient(const Law& law, const AngleTerm& angle, const Network& network, Workspace& work,
                            Positions& by_node) {
  const auto bonds = static_cast<std::size_t>(work.d.rows());
  work::add_bonds(bonds);
  work.g.resize(work.d.rows(), 3);
  bond_gradients(law, work.d.data(), bonds, work.g.data());
  bool defined = true;
  if constexpr (!std::is_same_v<AngleTerm, NoAngle>) {
    work::add_angles(network.angles.size());
    if (work.stars.angle_count != network.angles.size()) work.stars = arrange(network.angles, bonds);
    defined = add_angle_gradients(work.stars, work.d.data(), bonds,
                                  (planted(Mutant::angle_force_off) ? 1.001 : 1.0) * angle.stiffness,
                                  work.g.data());
  }
  by_node.setZero(network.node_count(), 3);
  hand_to_nodes(network.bonds.data(), bonds, work.g.data(), static_cast<std::size_t>(by_node.rows()),
                by_node.data());
  return defined;
}

/// Second derivatives of the energy at work.d as triplets over coordinates axis * nodes + node; entries of
/// one pair may repeat and add up  [M T^-2].
template <bond::BondLaw Law, class AngleTerm>
std::vector<Eigen::Triplet<double>> hessian(const Law& law, const AngleTerm& angle, const Network& network,
                                            const Workspace& work) {
  const auto nodes = static_cast<int>(network.node_count());
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(36 * network.bonds.size() + 144 * network.angles.size());
  // The block of (bond p, bond q), spread over the ends of both.
  const auto add = [&](std::int32_t p, std::int32_t q, const Mat3& block) {
    const Bond& bond_p = network.bonds[static_cast<std::size_t>(p)];
    const Bond& bond_q = network.bonds[static_cast<std::size_t>(q)];
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        entries.emplace_back(i * nodes + bond_p.second, j * nodes + bond_q.second, block(i, j));
        entries.emplace_back(i * nodes + bond_p.first, j * nodes + bond_q.first, block(i, j));
        entries.emplace_back(i * nodes + bond_p.second, j * nodes + bond_q.first, -block(i, j));
        entries.emplace_back(i * nodes + bond_p.first, j * nodes + bond_q.second, -block(i, j));
      }
    }
  };
  for (Eigen::Index b = 0; b < work.d.rows(); ++b) {
    const Vec3 d = work.d.row(b);
    const double r = d.norm();
    const double across = (planted(Mutant::hessian_without_tension) ? 0.0 : 1.0) * law.tension(r) / r;
    add(static_cast<std::int32_t>(b), static_cast<std::int32_t>(b),
        (law.stiffness(r) - across) / (r * r) * d * d.transpose() + across * Mat3::Identity());
  }
  if constexpr (!std::is_same_v<AngleTerm, NoAngle>) {
    for (const Angle& t : network.angles) {
      const Vec3 a = t.sign_a * work.d.row(t.bond_a).transpose();
      const Vec3 b = t.sign_b * work.d.row(t.bond_b).transpose();
      const AngleHessian h = angle_hessian(angle_state(a, b, t.straight), a, b);
      const double mixed =
          (planted(Mutant::angle_hessian_unmixed) ? 0.0 : 1.0) * angle.stiffness * t.sign_a * t.sign_b;
      add(t.bond_a, t.bond_a, angle.stiffness * h.aa);
      add(t.bond_b, t.bond_b, angle.stiffness * h.bb);
      add(t.bond_a, t.bond_b, mixed * h.ab);
      add(t.bond_b, t.bond_a, mixed * h.ab.transpose());
    }
  }
  return entries;
}

}  // namespace veriflex::solid
