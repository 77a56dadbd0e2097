/// Motion of a network, also under drag, by an embedded Runge-Kutta method whose step follows from a
/// tolerance: the accurate end that fixed steps are held against.
#pragma once

#include <cstdint>
#include <memory>

#include "base/parts.hpp"
#include "solid/elastic.hpp"

namespace veriflex::measures {

/// Prince and Dormand's method of order 8 with an estimate of order 9, by GSL.  [prince-dormand-1981]
class RungeKutta {
 public:
  /// Starts at displacement u and velocity v at time 0. `drag` is the force per velocity and node  [M T^-1].
  /// Each step's estimated error stays below `tolerance` times the largest displacement at the start, and of
  /// velocities the same times `frequency`, that of the motion  [T^-1]. The network must outlive the motion.
  RungeKutta(const solid::Material& material, const solid::Network& network, double node_mass, double drag,
             double tolerance, double frequency, const Positions& u, const Positions& v);
  ~RungeKutta();
  RungeKutta(RungeKutta&&) noexcept;

  /// A step as long as the tolerance allows. A trial that leaves a bond's domain is repeated with half of it.
  /// Throws NumericalFailure when no step, however small, does.
  void step();

  /// When the last step passed weights . u_z = 0, by shorter steps from its start  [T].
  double passage(const Eigen::VectorXd& weights) const;

  Positions displacement() const;
  Positions velocity() const;
  double time() const;
  std::int64_t steps() const;  // that were accepted
  std::int64_t drag_evaluations() const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace veriflex::measures
