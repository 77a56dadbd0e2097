/// Motion of a network by a multirate infinitesimal method of SUNDIALS (ARKODE's MRIStep): a slow force, here
/// a drag, is taken at the few stages of a step, and between two of them the bonds move the nodes in
/// sub-steps of an explicit Runge-Kutta method, under what the method makes of the slow force. The peer of
/// leap-frog with sub-steps. Built where CMake finds SUNDIALS, which then sets VERIFLEX_SUNDIALS.
#pragma once

#include <cstdint>
#include <memory>

#include "base/parts.hpp"
#include "solid/elastic.hpp"

namespace veriflex::measures {

/// Of order 3 the method of Knoth and Wolke (MIS_KW3, stages at 0, 1/3 and 3/4 of a step, and in the
/// sub-steps theirs of three stages), of order 4 MRI-GARK-ERK45a (at 0, 1/5, ... 4/5, and the classical one
/// of four).
/// [reynolds-2023, schlegel-2009, sandu-2019]
class Multirate {
 public:
  /// Starts at displacement u and velocity v at time 0. `drag` is the force per velocity and node  [M T^-1].
  /// The way between two stages is divided into sub-steps of dt/substeps, the last of which may be shorter.
  /// The network must outlive the motion.
  Multirate(const solid::Material& material, const solid::Network& network, double node_mass, double drag,
            int order, double dt, int substeps, const Positions& u, const Positions& v);
  ~Multirate();
  Multirate(Multirate&&) noexcept;

  /// Throws NumericalFailure when a bond leaves its law's domain at a stage; nothing can be done afterwards.
  void step();

  /// When the last step passed weights . u_z = 0, by the quintic through both ends that has their velocities
  /// and accelerations  [T].
  double passage(const Eigen::VectorXd& weights) const;

  Positions displacement() const;
  Positions velocity() const;
  double time() const;
  std::int64_t steps() const;
  std::int64_t drag_evaluations() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace veriflex::measures
