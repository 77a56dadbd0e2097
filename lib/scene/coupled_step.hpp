/// One step of body and fluid as a linear map about the undeformed body in a fluid at rest, as Simulation and
/// the bodies' integrators make it.
///
/// The state is (f, v, W): the elastic force f = - K u over the free coordinates, the velocity v that their
/// scheme carries and the fluid's velocity W at the coupled nodes. f takes the displacement's place: in u a
/// rigid motion grows with time at constant velocity, which is no instability, and in f it is nothing. The
/// exchange leaves
/// - A F in W, with F the force on the coupled nodes and A = interpolate o spread at their places. Bodies
/// whose supports share nodes of the fluid are one step: what one of them spreads, the others find.
#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <span>
#include <vector>

#include "scene/scene.hpp"
#include "solid/dof_map.hpp"

namespace veriflex::scene {

/// What the fluid at the coupled nodes does with the momentum that it was given: keeps it in place, or has
/// lost it a step later.
enum class FluidMemory { Keeps, Forgets };

/// The bodies of a scene that meet its fluid, by their numbers, each with those whose supports share nodes of
/// the fluid with its own, directly or by way of others.
std::vector<std::vector<std::size_t>> bodies_that_share_nodes(const Scene& scene);

class CoupledStep {
 public:
  using Vector = Eigen::VectorXd;
  using Sparse = Eigen::SparseMatrix<double>;

  /// Of bodies with a coupling; those whose motion is given have coupled nodes and no coordinates. Throws
  /// NumericalFailure when one has no energy where it stands, or a marker no place.
  CoupledStep(const fluid::Spec& fluid, std::span<const Body> bodies, FluidMemory memory);
  CoupledStep(const fluid::Spec& fluid, const Body& body, FluidMemory memory)
      : CoupledStep(fluid, std::span(&body, 1), memory) {}

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
  /// V^(1/2) A V^(1/2), whose largest eigenvalue is the part of a slip that a step takes away where it takes
  /// most.
  Sparse answering() const;
  /// Whether all bodies have the same mass, drag, sub-steps and coupling, so that these are the step's.
  bool is_uniform() const { return is_uniform_; }
  double marker_volume() const { return parts_[0].marker_volume; }
  int forcing_iterations() const { return parts_[0].forcing_iterations; }
  int substeps() const { return parts_[0].substeps; }
  /// Whether F follows the solid between the sub-steps.
  bool is_subcycled() const { return parts_[0].subcycled && substeps() > 1; }
  bool is_implicit() const { return parts_[0].implicit; }
  bool is_damped() const { return parts_[0].drag > 0.0; }
  double node_mass() const { return parts_[0].node_mass; }
  /// Of all bodies.
  void set_node_mass(double mass);
  FluidMemory memory() const { return memory_; }
  bool couples_free_coordinates() const;

 private:
  /// One body: its coordinates among the free ones, its coupled nodes among all, and how it moves.
  struct Part {
    Eigen::Index first, count;
    Eigen::Index first_marker, markers;
    double node_mass, drag, marker_volume;
    int substeps, forcing_iterations;
    bool subcycled, implicit;
    /// Of a body by the implicit midpoint rule: 2 m + gamma + V P^T P + K/2, of which the velocity in the
    /// middle of a step is the solution.
    std::shared_ptr<const solid::Cholesky> middle{};
  };
  void prepare(Part& part) const;
  void move_implicitly(const Part& part, Vector& f, Vector& v, const Vector& wanted, Vector& mean) const;
  Vector own(const Part& part, const Vector& markers) const;
  void move(const Part& part, Vector& f, Vector& v, const Vector& wanted, Vector& mean) const;
  Vector wanted_velocity(const Vector& v, const Vector& W) const;

  FluidMemory memory_;
  Sparse stiffness_, exchange_;
  std::vector<Part> parts_;
  std::vector<int> place_;  // of each coupled coordinate among the free ones; -1 where prescribed
  bool is_uniform_ = true;
};

}  // namespace veriflex::scene
