/// The look at where a body's markers stand in the box before a run.
#pragma once

#include <cstdint>

#include "base/vec.hpp"
#include "fluid/fluid.hpp"
#include "io/document.hpp"
#include "scene/coupling_spec.hpp"

namespace veriflex::engine {

/// Refuses, with an InputError at `where`, a body that would meet its own image along a periodic axis: its
/// extent, the stroke that it makes to either side and the supports, taken together. `what` names the body.
/// One that is a node deep in a box a node deep is its own images, and moves in the plane: none is refused.
void check_images(const fluid::Spec& fluid, coupling::Delta delta, const Vec3& extent, const Vec3& stroke,
                  const std::string& what, const Place& where);

/// The same of markers at X whose supports reach beyond a wall, the stroke included, or into the obstacle.
void check_supports(const fluid::Spec& fluid, coupling::Delta delta, const Positions& X, const Vec3& stroke,
                    const std::string& what, const Place& where);

/// The most steps that a run makes.
inline constexpr double max_steps = 1e9;

/// Refuses more than these, and fewer than `min`, with an InputError at `where`.
std::int64_t whole_steps(double steps, double min, const std::string& what, const Place& where);

}  // namespace veriflex::engine
