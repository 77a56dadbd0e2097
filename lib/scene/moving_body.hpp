/// One body of a scene as it moves: free, held, driven and loaded, or in a motion that is given; in a fluid
/// or
/// without one.                                                                    [wu-qi-2014, Eqs. 8-12]
///
///   F_int = rho_f V (u_f - u_s)
///
/// A step has four parts, of which the first two and the last are not called for a body that meets no fluid.
/// u_s is the velocity that the scheme carries, of leap-frog half a sub-step old: an averaged on-step one
/// makes the coupling unstable. The implicit midpoint rule couples to the mean velocity of the step. For a
/// given motion u_s is that of the markers' time.
#pragma once

#include "coupling/transfer.hpp"
#include "scene/prescribed_body.hpp"
#include "scene/scene.hpp"

namespace veriflex::scene {

class MovingBody {
 public:
  /// In that fluid; null: without one. Throws BadParameter ("coupling.nodes", "motion"), and NumericalFailure
  /// when the energy does not exist at rest.
  MovingBody(Body body, const fluid::Spec* fluid);

  /// The integrator refers to the network beside it.
  MovingBody(const MovingBody&) = delete;
  MovingBody& operator=(const MovingBody&) = delete;

  /// Finds the nodes around the present markers. Throws NumericalFailure when a marker leaves the fluid.
  void locate();
  /// The rows of these nodes, y + ny z of each once.
  std::vector<std::int64_t> rows() const { return transfer().rows(); }
  /// u_f at the markers where they were located, from the present populations, and the slip.
  void interpolate(const fluid::Fluid& fluid);
  /// One step under internal forces and F_int, or of the given motion. Throws NumericalFailure when a bond or
  /// an angle leaves its range.
  void move();
  /// - F_int, its mean over the sub-steps, to the nodes where u_f was interpolated.
  void spread();
  fluid::NodeForces reaction() const { return {transfer().nodes(), &spread_}; }

  /// As it was given, but for how it is held and starts: see Integrator::conditions().
  const Body& spec() const { return body_; }
  const std::string& name() const { return body_.name; }
  const solid::Network& network() const { return body_.network; }
  bool is_coupled() const { return transfer_.has_value() || prescribed_.has_value(); }
  /// Whether it moves by its own forces; solid() exists only then.
  bool is_elastic() const { return motion_ != nullptr; }
  const solid::Integrator& solid() const { return *motion_; }

  const std::vector<std::int32_t>& coupled() const { return coupled_; }
  /// Of all nodes from where they were undeformed  [L].
  Positions displacement() const;
  /// Positions of all nodes in the box, not wrapped  [L].
  Positions positions() const;
  /// Of the coupled nodes alone  [L].
  Positions markers() const;
  /// m v of its nodes with the velocity that the scheme carries; 0 where the motion is given  [M L T^-1].
  Vec3 momentum() const;
  /// F_int of the last step, its mean over the sub-steps, one row per coupled node; no rows before the first
  /// step  [M L T^-2].
  const Positions& exchanged() const { return exchanged_; }
  /// Slip u_f - u_s that the last step found, one row per coupled node  [L T^-1].
  const Positions& slip() const { return prescribed_ ? prescribed_->slip() : slip_; }
  /// Distinct lattice nodes under the supports in the last step.
  std::size_t touched_nodes() const { return is_coupled() ? transfer().nodes().size() : 0; }

  /// What determines the motion from here on. `elastic` is absent where the motion is given.
  struct State {
    std::int64_t steps;
    std::optional<solid::Integrator::State> elastic;
  };
  State state() const;
  void restore(const State& state);

 private:
  const coupling::Transfer& transfer() const { return prescribed_ ? prescribed_->transfer() : *transfer_; }
  void put_markers();

  Body body_;
  std::vector<std::int32_t> coupled_;
  std::int64_t steps_ = 0;
  std::unique_ptr<solid::Integrator> motion_;
  std::optional<coupling::Transfer> transfer_;  // of a body that moves by its own forces, and
  std::optional<PrescribedBody> prescribed_;    // of one whose motion is given; neither without a coupling
  Positions markers_, at_nodes_, wanted_, slip_, exchanged_, spread_;
  std::optional<parts::Built> exchange_;  // of these
};

}  // namespace veriflex::scene
