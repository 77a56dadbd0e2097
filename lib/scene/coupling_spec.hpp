/// How a body exchanges momentum with the fluid around it.
#pragma once

#include <cstdint>
#include <vector>

#include "coupling/delta.hpp"

namespace veriflex::scene {

/// Which nodes of the body exchange momentum with the fluid.
enum class Coupled {
  Boundary,  // fewer than six bonds: the surface with its end caps
  Ring,      // fewer than four bonds across the axis: the surface without end caps
  All,
  Listed
};

struct CouplingSpec {
  coupling::Delta delta = coupling::Delta::Cosine;
  Coupled coupled = Coupled::Boundary;
  std::vector<std::int32_t> listed{};  // nodes of the network, for Coupled::Listed
  double marker_volume = 1.0;          // V  [L^3]
  bool subcycled = false;  // F_int follows the solid through its sub-steps; frozen over the step otherwise
  /// Multi-direct forcing: more than one corrects F_int by the slip that it would leave, fluid at rest
  /// meanwhile.
  int forcing_iterations = 1;
  bool allow_unstable = false;  // runs even where the coupling is known to be unstable
};

}  // namespace veriflex::scene
