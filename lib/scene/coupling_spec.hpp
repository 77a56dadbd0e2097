/// How a body exchanges momentum with the fluid around it.
#pragma once

#include <cstdint>
#include <vector>

#include "base/vec.hpp"
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
  bool live = false;                   // F_int follows the solid through its sub-steps; held otherwise
  int iterations = 1;  // more: F_int is corrected by the slip that it would leave, fluid at rest meanwhile
  Vec3 origin = Vec3::Zero();  // where the body's origin stands in the box  [L]
  bool force = false;          // runs even where the exchange is known to be unstable
  int axis = 2;                // of the box, along which the body's own z axis points
};

}  // namespace veriflex::scene
