/// A fluid under watch from the first step of a run to its last.
#pragma once

#include "observe/watch.hpp"

namespace veriflex::observe {

/// Looks before the first step, after every watch.every-th and after the last, whatever watch.every, and
/// remembers the last look that found all well.
class Lookout {
 public:
  /// Looks at once. Throws NumericalFailure as check().
  Lookout(fluid::Fluid& fluid, const Watch& watch);

  /// One step of the fluid, and a look when that is due. Throws Interrupted, with what the last good look
  /// saw, when this one finds the fluid unsound or the run is asked to stop.
  void step(const fluid::NodeForces& forces = {});

  /// After the last step, unless that has been looked at. Throws as step().
  void at_end();

 private:
  template <class Work>
  void guarded(Work work);
  void look();

  fluid::Fluid& fluid_;
  Watch watch_;
  std::int64_t step_;  // of the last look
  fluid::Extremes seen_;
};

}  // namespace veriflex::observe
