/// What a scene consists of, and what a run of it will build and leave out.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bond/laws.hpp"
#include "solid/network.hpp"

namespace veriflex::scene {

/// How the coordinates across the axis are treated.
enum class Lateral {
  held,  // they stay where they are; exact for a bar of bonds along its axis, because C12 = 0
  free,  // only the rigid motions are removed
};

struct SolidSpec {
  solid::Block block;
  Lateral lateral;
};

/// A module that is not named is absent: not built, no memory.
struct Scene {
  bond::AnyLaw law;
  std::optional<SolidSpec> solid;
};

struct Built {
  std::string module;
  std::string what;
  double memory_bytes;  // estimate
};

struct LeftOut {
  std::string module;
  std::string why;
};

struct Plan {
  std::vector<Built> built;
  std::vector<LeftOut> left_out;
};

/// The plan of a static study of the scene.
/// Throws BadParameter ("nodes") when the solid would not fit into the memory that is free now.
Plan plan(const Scene& scene);

}  // namespace veriflex::scene
