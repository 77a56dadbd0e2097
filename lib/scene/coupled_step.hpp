/// One step of body and fluid as a linear map about the undeformed body in a fluid at rest, as Simulation and
/// Leapfrog make it.
///
/// The state is (f, v, W): the elastic force f = - K u over the free coordinates, their half-step velocity v
/// and the fluid's velocity W at the coupled nodes. f takes the displacement's place: in u a rigid motion
/// grows with time at constant velocity, which is no instability, and in f it is nothing. The exchange leaves
/// - A F in W, with F the force on the coupled nodes and A = interpolate o spread at their places.
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "scene/scene.hpp"

namespace veriflex::scene {

/// What the fluid at the coupled nodes does with the momentum that it was given: keeps it in place, or has
/// lost it a step later.
enum class FluidMemory { Keeps, Forgets };

/// The coordinates of a body that are fixed or driven.
solid::FixedDofs prescribed_dofs(const Body& body);

class CoupledStep {
 public:
  using Vector = Eigen::VectorXd;
  using Sparse = Eigen::SparseMatrix<double>;

  /// Of a body with a coupling. Throws NumericalFailure when it has no energy where it stands, or a marker no
  /// place.
  CoupledStep(const fluid::Spec& fluid, const Body& body, FluidMemory memory);

  Eigen::Index size() const { return 2 * free_count() + marker_values(); }
  Eigen::Index free_count() const { return stiffness_.rows(); }
  Eigen::Index marker_values() const { return 3 * exchange_.rows(); }

  /// The state a step later.
  Vector next(const Vector& state) const;

  /// P: velocities at the markers of free coordinates' ones, 0 where they are prescribed, and its transpose.
  Vector at_markers(const Vector& free) const;
  Vector at_coordinates(const Vector& markers) const;
  /// A F, axis by axis.
  Vector exchanged(const Vector& force) const;

  const Sparse& stiffness() const { return stiffness_; }  // K  [M T^-2]
  const Sparse& exchange() const { return exchange_; }    // A of one axis  [L^-3]
  double marker_volume() const { return coupling_.marker_volume; }
  int forcing_iterations() const { return coupling_.forcing_iterations; }
  int substeps() const { return substeps_; }
  /// Whether F follows the solid between the sub-steps.
  bool is_subcycled() const { return coupling_.subcycled && substeps_ > 1; }
  bool is_damped() const { return drag_ > 0.0; }
  FluidMemory memory() const { return memory_; }
  bool couples_free_coordinates() const;

  double node_mass() const { return node_mass_; }
  void set_node_mass(double mass) { node_mass_ = mass; }

 private:
  CouplingSpec coupling_;
  FluidMemory memory_;
  Sparse stiffness_, exchange_;
  std::vector<int> place_;  // of each coupled coordinate among the free ones; -1 where prescribed
  int substeps_;
  double node_mass_, drag_;
};

}  // namespace veriflex::scene
