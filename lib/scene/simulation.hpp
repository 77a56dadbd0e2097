/// A body in a fluid: one step as the method section writes it.                    [wu-qi-2014, Eqs. 8-12]
///
/// Within a step: velocities are interpolated at the present markers from the present populations; F_int =
/// rho_f V (u_f - u_s), with the velocity that the solid carries, half a sub-step old; the solid moves under
/// its internal forces and F_int; - F_int, its mean over the sub-steps, is spread where u_f was interpolated;
/// the fluid collides and streams. An averaged on-step solid velocity instead of the carried one makes the
/// exchange unstable.
#pragma once

#include <memory>

#include "coupling/transfer.hpp"
#include "fluid/fluid.hpp"
#include "scene/coupling_spec.hpp"
#include "solid/leapfrog.hpp"

namespace veriflex::scene {

/// Rows of the body's coordinates turned such that its z axis points along `axis`; a rotation, no reflection.
Positions turned(const Positions& body, int axis);

/// The nodes that exchange momentum, in ascending order. Throws BadParameter when a listed node is not in the
/// network or listed twice.
std::vector<std::int32_t> coupled_nodes(const solid::Network& network, const CouplingSpec& coupling);

/// Where these nodes of the undeformed body stand in the box, one row each  [L].
Positions markers_at_rest(const solid::Network& network, const CouplingSpec& coupling);

struct Body {
  solid::Material material;
  solid::Network network;        // already turned
  solid::Conditions conditions;  // in the axes of the box
  solid::Substeps substeps;
};

class Simulation {
 public:
  /// The body at rest, undeformed, in a fluid at rest. Throws BadParameter and NumericalFailure.
  Simulation(const fluid::Spec& fluid, Body body, const CouplingSpec& coupling);

  /// The leap-frog refers to the network beside it.
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// One step. Throws NumericalFailure with the step when a bond, an angle or a marker leaves its range.
  void advance();

  const fluid::Fluid& fluid() const { return *fluid_; }
  const solid::Leapfrog& solid() const { return motion_; }
  const solid::Network& network() const { return body_.network; }
  const std::vector<std::int32_t>& coupled() const { return coupled_; }
  /// Positions of all nodes in the box, not wrapped  [L].
  Positions positions() const;
  /// F_int of the last step, its mean over the sub-steps, one row per coupled node  [M L T^-2].
  const Positions& exchanged() const { return exchanged_; }
  /// Slip u_f - u_s that the last step found, one row per coupled node  [L T^-1].
  const Positions& slip() const { return slip_; }
  /// Distinct lattice nodes under the supports in the last step.
  std::size_t touched_nodes() const { return transfer_.nodes().size(); }
  /// rho u of the fluid and m v of the body together; conserved when nothing holds or drives the body  [M L
  /// T^-1].
  Vec3 momentum() const;

  struct Spent {
    double wall = 0.0;
    double cpu = 0.0;  // of all threads
  };
  struct Seconds {
    Spent fluid, coupling, solid;
  };
  const Seconds& seconds() const { return seconds_; }

 private:
  CouplingSpec coupling_;
  Body body_;
  std::vector<std::int32_t> coupled_;
  coupling::Transfer transfer_;
  std::unique_ptr<fluid::Fluid> fluid_;
  solid::Leapfrog motion_;
  Positions markers_, at_nodes_, wanted_, slip_, exchanged_, spread_;
  Seconds seconds_;
};

}  // namespace veriflex::scene
