/// What a scene consists of: a fluid, bodies, and how each body meets the fluid. What is not named is absent.
#pragma once

#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "fluid/fluid.hpp"
#include "scene/coupling_spec.hpp"
#include "solid/leapfrog.hpp"

namespace veriflex::scene {

/// A rigid translation that is given: X(t) = X + velocity t + amplitude sin(omega t).
struct Motion {
  Vec3 velocity = Vec3::Zero();   // [L T^-1]
  Vec3 amplitude = Vec3::Zero();  // [L]
  double omega = 0.0;             // [T^-1]

  Vec3 displacement_at(double time) const { return velocity * time + amplitude * std::sin(omega * time); }
  Vec3 velocity_at(double time) const { return velocity + amplitude * omega * std::cos(omega * time); }
};

/// Of all nodes when the scene starts. An empty matrix: undeformed, at rest.
struct Start {
  Positions displacement;  // [L]
  Positions velocity;      // [L T^-1]
};

/// A body. It moves by its own forces, or as `motion` says.
struct Body {
  solid::Material material;        // means nothing where the motion is given
  solid::Network network;          // already turned into the axes of the box
  solid::Conditions conditions{};  // in the axes of the box
  solid::Substeps substeps{};      // of leap-frog
  solid::Scheme scheme = solid::Scheme::LeapFrog;
  Vec3 place = Vec3::Zero();               // where the origin of `network` stands in the box  [L]
  int axis = 2;                            // of the box, along which the body's own z axis points
  std::optional<CouplingSpec> coupling{};  // absent: the body does not meet the fluid
  std::optional<Motion> motion{};
  Start start{};
  std::string name = "body";
};

struct Scene {
  std::optional<fluid::Spec> fluid{};
  /// The deviations that the fluid starts from, by node; empty: at rest.
  std::function<fluid::Populations(std::int64_t node)> initial_flow{};
  /// A force on every node at each step, beside that of the fluid's Spec and of first order  [M L^-2 T^-2];
  /// empty: none.
  std::function<Vec3(std::int64_t step)> uniform_force{};
  std::vector<Body> bodies{};
};

}  // namespace veriflex::scene
