/// Sums and extremes over a box, however a fluid carries its density and momentum.
#pragma once

#include <cmath>
#include <vector>

#include "base/reduce.hpp"
#include "fluid/fluid.hpp"
#include "fluid/threads.hpp"

namespace veriflex::fluid {

/// Of one node.
struct Moments {
  double density_deviation;  // rho - 1
  Vec3 momentum;             // sum f c  [M L^-1 T^-2]
};

/// `at(node)` gives the Moments of a node that is not `inside(node)`; called by several threads. The last
/// bits of the sums do not depend on their number.
template <class At, class Inside>
Totals totals_of(const Grid& grid, std::int64_t steps, const At& at, const Inside& inside) {
  std::vector<Totals> planes(static_cast<std::size_t>(grid.size[2]), Totals{0.0, Vec3::Zero(), Vec3::Zero()});
#pragma omp parallel for schedule(static) if (grid.count() >= worth_threads)
  for (std::int64_t z = 0; z < grid.size[2]; ++z) {
    Totals& sum = planes[static_cast<std::size_t>(z)];
    for (std::int64_t node = grid.index(0, 0, z); node < grid.index(0, 0, z + 1); ++node) {
      if (inside(node)) continue;
      const Moments here = at(node);
      const auto [x, y, ignored] = grid.node(node);
      sum.mass_deviation += here.density_deviation;
      sum.momentum += here.momentum;
      sum.staggered_momentum += (x + y + z + steps) % 2 == 0 ? here.momentum : Vec3(-here.momentum);
    }
  }
  Totals total{0.0, Vec3::Zero(), Vec3::Zero()};
  for (const Totals& sum : planes) {
    total.mass_deviation += sum.mass_deviation;
    total.momentum += sum.momentum;
    total.staggered_momentum += sum.staggered_momentum;
  }
  return total;
}

/// The first of two that are equally bad stays.
inline void keep_worse(Extremes& worst, const Extremes& other) {
  const auto replaces = [](double now, double by, double kept) {
    return !std::isnan(now) && (std::isnan(by) || kept != now);
  };
  const double density = lesser(worst.min_density, other.min_density);
  if (replaces(worst.min_density, other.min_density, density)) {
    worst.min_density = density;
    worst.min_density_node = other.min_density_node;
  }
  const double speed = worse(worst.max_speed, other.max_speed);
  if (replaces(worst.max_speed, other.max_speed, speed)) {
    worst.max_speed = speed;
    worst.max_speed_node = other.max_speed_node;
  }
}

/// As above.
template <class At, class Inside>
Extremes extremes_of(const Grid& grid, const At& at, const Inside& inside) {
  std::vector<Extremes> planes(static_cast<std::size_t>(grid.size[2]));
#pragma omp parallel for schedule(static) if (grid.count() >= worth_threads)
  for (std::int64_t z = 0; z < grid.size[2]; ++z) {
    const std::int64_t from = grid.index(0, 0, z);
    Extremes worst{INFINITY, from, 0.0, from};
    for (std::int64_t node = from; node < grid.index(0, 0, z + 1); ++node) {
      if (inside(node)) continue;
      const Moments here = at(node);
      const double rho = 1.0 + here.density_deviation;
      keep_worse(worst, {std::isfinite(rho) ? rho : NAN, node, here.momentum.norm() / rho, node});
    }
    planes[static_cast<std::size_t>(z)] = worst;
  }
  Extremes worst = planes.front();
  for (const Extremes& plane : planes) keep_worse(worst, plane);
  return worst;
}

}  // namespace veriflex::fluid
