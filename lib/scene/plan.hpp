/// What a scene consists of, and what a run of it will build and leave out.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "bond/laws.hpp"
#include "fluid/fluid.hpp"
#include "scene/scene.hpp"
#include "solid/network.hpp"

namespace veriflex::scene {

struct SolidSpec {
  std::variant<solid::Block, solid::Rod> shape;
  double angle_stiffness;  // k_a; 0 builds no angles  [M L^2 T^-2]
};

/// What a study of one body makes use of. A module that is not named is absent: not built, no memory.
struct Outline {
  std::optional<bond::AnyLaw> law{};
  std::optional<SolidSpec> solid{};
  std::string method{};  // how the solid is solved, in words
  bool moves = false;    // whether it has velocities
  std::optional<fluid::Spec> fluid{};
  std::optional<CouplingSpec> coupling{};  // of a body and the fluid
  std::string exchange{};  // that coupling in words, where the study varies it or lays its own markers
  bool is_free = false;    // no coordinate of it is held or driven
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

/// Throws BadParameter ("solid.nodes", "fluid.nodes") when a module would not fit into the memory that is
/// available now.
Plan plan(const Outline& scene);

/// The same of a scene whose bodies are built. Throws BadParameter ("fluid.nodes").
Plan plan_scene(const Scene& scene);

solid::Network build(const SolidSpec& spec);

}  // namespace veriflex::scene
