/// Checks of a body that moves by its own forces alone: energy that comes from nowhere, a column that gives
/// way sideways, and states that its bond law allows and no solid of its kind has.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/moving_body.hpp"

namespace veriflex::observe {

struct BodyLimits {
  /// Largest departure of a body's energy from that of its start, over what the start put in (deformation and
  /// motion) and the largest work of its dead load so far. Leap-frog near omega dt = 2 departs by a few times
  /// that and stays; beyond, without limit. 0: not looked at.  [1]
  double energy_growth = 0.0;
  /// Whether a bond longer than twice its undeformed length, or a cell of the lattice turned inside out, ends
  /// the run: a harmonic bond has no limit of its own.
  bool physical = false;
  /// How far the centre of a cross-section of a body may stand from the line between those of its first and
  /// last one, over its undeformed length, while that line is shorter than undeformed. 0: not looked at.  [1]
  double buckled = 0.0;

  bool any() const { return energy_growth > 0.0 || physical || buckled > 0.0; }
};

class BodyCheck {
 public:
  /// Of that body as it starts, which must outlive the check.
  BodyCheck(const scene::MovingBody& body, const BodyLimits& limits);

  /// Throws NumericalFailure (modes Energy, Buckled, Unphysical) with step and place.
  void look(std::int64_t step);

  /// Largest work of the dead load so far, all that later looks depend on beside the body  [M L^2 T^-2].
  double load_work() const { return load_work_; }
  void restore(double load_work) { load_work_ = load_work; }

 private:
  /// Three bonds that begin at one node and span a volume  [L^3].
  struct CellCorner {
    std::size_t bonds[3];
    double volume;
  };

  void look_at_energy(std::int64_t step);
  void look_for_buckling(std::int64_t step) const;
  void look_at_shape(std::int64_t step) const;
  double energy() const;

  const scene::MovingBody& body_;
  BodyLimits limits_;
  double start_ = 0.0;      // energy of the start  [M L^2 T^-2]
  double put_in_ = 0.0;     // of it, what is not there undeformed and at rest
  double load_work_ = 0.0;  // largest so far
  std::vector<CellCorner> corners_;
  std::vector<Eigen::Index> section_of_;  // by node, along the body's own axis
};

}  // namespace veriflex::observe
