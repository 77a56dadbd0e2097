/// A rigid body in prescribed translation that exchanges momentum with the fluid: direct forcing.
/// [wu-qi-2014, Eqs. 8-12; uhlmann-2005; wang-2008]
///
///   F = V (u_f - u_s),  u_f interpolated from sum f c / rho before the collision, and - F is spread
///
/// As in `MovingBody`, but nothing moves the body: F is what holds it on its way. Further rounds correct F by
/// the slip that it would leave, fluid at rest meanwhile. A steady drag needs a steady slip: F is nothing
/// but V times the slip that the last step left.
#pragma once

#include "coupling/transfer.hpp"
#include "fluid/fluid.hpp"

namespace veriflex::scene {

struct Forcing {
  coupling::Delta delta = coupling::Delta::Cosine;
  double marker_volume = 1.0;  // V: of the fluid that a marker stands for  [L^3]
  int forcing_iterations = 1;
};

class PrescribedBody {
 public:
  /// In the box of that fluid.
  PrescribedBody(const fluid::Spec& fluid, const Forcing& forcing);

  /// Puts the markers at X, one row each. Throws NumericalFailure as Transfer::locate does.
  void place(const Positions& X);

  /// F from the fluid's present populations, with the body where it was placed and in motion with that
  /// velocity.
  void exchange(const fluid::Fluid& fluid, const Vec3& velocity);

  /// exchange(), and one step of the fluid under - F.
  void advance(fluid::Fluid& fluid, const Vec3& velocity);

  /// F of the last step: of the fluid on the body, one row per marker  [M L T^-2].
  const Positions& force() const { return force_; }
  Vec3 total_force() const { return force_.colwise().sum().transpose(); }

  /// Slip u_f - u_s of the bare sum f c that the last step found, one row per marker  [L T^-1].
  const Positions& slip() const { return slip_; }

  /// The same of the fluid's velocity, sum f c with half of the step's force. Half of what a step corrects
  /// stays, however many rounds are made.
  Positions slip_of_fluid() const;

  const coupling::Transfer& transfer() const { return transfer_; }

  /// - F of the last advance() at the lattice's nodes, until the next place().
  fluid::NodeForces spread() const { return {transfer_.nodes(), &spread_}; }

 private:
  Forcing forcing_;
  coupling::Transfer transfer_;
  Positions at_nodes_, slip_, force_, spread_;
  parts::Built exchange_{parts::Kind::Coupling, 0.0};
};

}  // namespace veriflex::scene
