/// Steps of a whole scene as a linear operator about rest: the simulation itself, a small state put in and
/// read out.
///
/// The state is (u, v, h): displacements and half-step velocities of the free coordinates, body by body, and
/// the populations of the fluid's nodes, which are stored as deviations from rest. Lengths of states are
/// energies: u K u + m v v + sum h^2/(3 w), with K the stiffness and a little more, so that nothing is
/// without length. In them fluid and body alone are nearly normal, which is what a Krylov space needs:
/// collisions shorten a state, streaming and leap-frog keep it.
///
/// Rest is the undeformed scene without loads, drives, body force, initial flow, motion of walls or of
/// prescribed bodies; what is driven is held. The fluid is one of populations at any tau. A state is scaled
/// to 1e-8, so that what is not linear is less than 1e-6 of a step even with a FENE-LJ bond, and what is
/// rounded some 1e-8.
#pragma once

#include <Eigen/SparseCholesky>
#include <map>
#include <memory>

#include "scene/simulation.hpp"

namespace veriflex::scene {

class SimulatedStep {
 public:
  using Vector = Eigen::VectorXd;
  using Sparse = Eigen::SparseMatrix<double>;

  /// Throws BadParameter ("fluid", "fluid.storage") for a scene without fluid or with float populations, and
  /// NumericalFailure when a body does not rest where it stands.
  explicit SimulatedStep(const Scene& scene);

  Eigen::Index size() const { return weight_.size(); }

  /// The state some steps later, without_neutral(). Throws NumericalFailure when the state grew out of all
  /// range.
  Vector after(const Vector& state, int steps) const;

  /// What is left of a state without what neither grows nor decays for reasons that are known: displacements
  /// that strain nothing, mass, and where they are conserved the momenta of D3Q15. These are four along each
  /// axis: the sums of rho u_a, (-1)^(b+c) rho u_a, (-1)^(a+t) rho u_a and (-1)^(a+b+c+t) rho u_a, for what
  /// carries momentum along a moves by one node along it, and by one along both b and c or along neither.
  Vector without_neutral(const Vector& state) const;
  /// The transposed of that operator, of whatever is paired with states.
  Vector without_neutral_transposed(const Vector& pairing) const;

  /// A state without pattern in bodies and fluid, of length 1, without_neutral().
  Vector noise() const;

  /// B x, x B x being the square of the length.
  Vector weighted(const Vector& state) const;
  double length(const Vector& state) const { return std::sqrt(state.dot(weighted(state))); }
  /// A step and B as matrices. The step keeps what is neutral; entries that are nothing but rounding are left
  /// out.
  Sparse matrix() const;
  Sparse weights() const;
  /// Which part of the square of the length the bodies have.
  double share_of_bodies(const Vector& state) const;

  /// How many invariants were found and taken out, of at most thirteen.
  Eigen::Index invariants() const { return conserved_.cols(); }
  /// Steps of the simulation that were made.
  std::int64_t steps_made() const { return steps_made_; }

 private:
  /// The coordinates of a body that are free, and its stiffness over them.
  struct FreeBody {
    std::size_t number;  // in the scene
    Eigen::Index first;  // place of u in a state; v follows
    std::vector<Eigen::Index> coordinates;
    double node_mass;
    Sparse stiffness;
    double shift;  // of K in the length  [M T^-2]
    Eigen::SimplicialLDLT<Sparse> strained;

    Eigen::Index count() const { return static_cast<Eigen::Index>(coordinates.size()); }
  };

  void add_body(const Body& body, std::size_t number);
  void find_invariants();
  Vector strained(const FreeBody& body, const Vector& u) const;
  State perturbed(const Vector& state, double scale) const;
  Vector read() const;
  Vector run(const Vector& state, int steps) const;
  const Vector& rest_after(int steps) const;

  std::unique_ptr<Simulation> simulation_;
  State rest_;
  std::vector<std::unique_ptr<FreeBody>> bodies_;
  std::vector<std::int64_t> fluid_nodes_;
  Eigen::Index first_population_ = 0;
  Vector weight_;                          // of each number in a state; of u the shift alone
  Eigen::MatrixXd conserved_, unchanged_;  // left and right eigenvectors, a column each
  Eigen::MatrixXd pairing_;                // inverse of conserved^T unchanged
  mutable std::map<int, Vector> rest_later_;
  mutable std::int64_t steps_made_ = 0;
};

/// That scene at rest, in the sense above.
Scene at_rest(Scene scene);

}  // namespace veriflex::scene
