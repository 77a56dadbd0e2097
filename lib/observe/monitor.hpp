/// A fluid that is checked from the first step of a run to its last.
#pragma once

#include "observe/check.hpp"

namespace veriflex::observe {

/// Checks the fluid before the first step, after every spec.every-th and after the last, whatever spec.every,
/// and remembers the last check that passed.
class Monitor {
 public:
  /// Checks at once. Throws NumericalFailure as observe::check().
  Monitor(fluid::Fluid& fluid, const MonitorSpec& spec);

  /// One step of the fluid, and a check when that is due. Throws Interrupted, with what the last good check
  /// saw, when this one fails or the run is asked to stop.
  void step(const fluid::NodeForces& forces = {});

  /// After the last step, unless that has been checked. Throws as step().
  void at_end();

 private:
  template <class Work>
  void guarded(Work work);
  void check_now();

  fluid::Fluid& fluid_;
  MonitorSpec spec_;
  std::int64_t step_;  // of the last check
  fluid::Extremes seen_;
};

}  // namespace veriflex::observe
