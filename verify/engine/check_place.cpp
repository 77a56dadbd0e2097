#include "engine/check_place.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/error.hpp"
#include "coupling/transfer.hpp"

namespace veriflex::engine {

namespace {

/// The supports of X, of markers in nodes with fluid.
void require_fluid(const fluid::Spec& fluid, coupling::Delta delta, const Positions& X,
                   const std::string& what, const std::string& when, const Place& where) {
  coupling::Transfer transfer(fluid.grid, closed(fluid), delta, fluid.obstacle);
  try {
    transfer.locate(X);
  } catch (const NumericalFailure& failure) {
    throw InputError(where, fmt::format("{} leaves the fluid{}", what, when), failure.what(),
                     "Use a larger box, or move the body or the obstacle");
  }
}

}  // namespace

void check_images(const fluid::Spec& fluid, coupling::Delta delta, const Vec3& extent, const Vec3& stroke,
                  const std::string& what, const Place& where) {
  const int width = coupling::visit(delta, [](auto kernel) { return decltype(kernel)::width; });
  const std::array<bool, 3> walled = closed(fluid);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    if (walled[a]) continue;
    // A plane scene: a box and a body that are one node deep go on through their images.
    if (fluid.grid.size[a] == 1 && extent[axis] == 0.0 && stroke[axis] == 0.0) continue;
    const double needed = extent[axis] + 2.0 * stroke[axis] + width;
    if (needed <= static_cast<double>(fluid.grid.size[a])) continue;
    throw InputError(
        where, fmt::format("{} overlaps its own image along {}", what, "xyz"[a]),
        fmt::format(
            "an extent of {:.6g}, a stroke of {:.6g} to either side and supports of {} nodes need {:.6g} "
            "nodes; the periodic box has {}",
            extent[axis], stroke[axis], width, needed, fluid.grid.size[a]),
        fmt::format("Use {:.6g} nodes or more along {}", std::ceil(needed), "xyz"[a]));
  }
}

void check_supports(const fluid::Spec& fluid, coupling::Delta delta, const Positions& X, const Vec3& stroke,
                    const std::string& what, const Place& where) {
  if (X.rows() == 0) {
    throw InputError(where, fmt::format("{} has no coupled node", what), "it would not meet the fluid",
                     "Couple some");
  }
  require_fluid(fluid, delta, X, what, "", where);
  const std::array<bool, 3> walled = closed(fluid);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (!walled[static_cast<std::size_t>(axis)] || stroke[axis] == 0.0) continue;
    fluid::Spec box = fluid;
    box.obstacle.clear();
    for (const double side : {-1.0, 1.0}) {
      Positions moved = X;
      moved.col(axis).array() += side * stroke[axis];
      require_fluid(box, delta, moved, what, fmt::format(" on its way along {}", "xyz"[axis]), where);
    }
  }
}

std::int64_t whole_steps(double steps, double min, const std::string& what, const Place& where) {
  if (steps >= min && steps <= max_steps) return static_cast<std::int64_t>(std::ceil(steps));
  throw InputError(where, fmt::format("{} {:.4g} steps", what, steps),
                   fmt::format("from {:.0f} to {:.0f} can be made", min, max_steps),
                   "Correct what it follows from");
}

}  // namespace veriflex::engine
