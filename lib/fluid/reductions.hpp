/// Sums and extremes over a box, however a fluid carries its density and momentum.
#pragma once

#include <omp.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/mutant.hpp"
#include "base/reduce.hpp"
#include "fluid/fluid.hpp"
#include "fluid/threads.hpp"

namespace veriflex::fluid {

/// Of one node.
struct Moments {
  double density_deviation;  // rho - 1
  Vec3 momentum;             // sum f c  [M L^-1 T^-2]
};

/// Of the nodes of a row, in the order of x.
struct RowMoments {
  explicit RowMoments(std::int64_t nx) : density_deviation(static_cast<std::size_t>(nx)) {
    for (auto& along_axis : momentum) along_axis.resize(density_deviation.size());
  }
  Moments at(std::size_t x) const {
    return {density_deviation[x], Vec3(momentum[0][x], momentum[1][x], momentum[2][x])};
  }
  std::vector<double> density_deviation;        // rho - 1
  std::array<std::vector<double>, 3> momentum;  // sum f c  [M L^-1 T^-2]
};

/// What a thread reads rows by and into, made before there are threads: lack of memory within one would end
/// the program.
template <class Reader>
struct RowReader {
  Reader read;
  RowMoments row;
};

template <class Reader>
std::vector<RowReader<Reader>> one_per_thread(const Reader& reader, std::int64_t nx) {
  return {static_cast<std::size_t>(omp_get_max_threads()), {reader, RowMoments(nx)}};
}

/// `reader(y, z, row)` fills in the moments of a row; each thread has a copy of its own. Nodes that are
/// `inside(node)` are left out. The last bits of the sums do not depend on the number of threads.
template <class Reader, class Inside>
Totals totals_of(const Grid& grid, std::int64_t steps, const Reader& reader, const Inside& inside) {
  std::vector<RowReader<Reader>> of_threads = one_per_thread(reader, grid.size[0]);
  std::vector<Totals> planes(static_cast<std::size_t>(grid.size[2]), Totals{0.0, Vec3::Zero(), Vec3::Zero()});
#pragma omp parallel for schedule(static) if (grid.count() >= worth_threads)
  for (std::int64_t z = 0; z < grid.size[2]; ++z) {
    Totals& sum = planes[static_cast<std::size_t>(z)];
    auto& [read, row] = of_threads[static_cast<std::size_t>(omp_get_thread_num())];
    for (std::int64_t y = 0; y < grid.size[1]; ++y) {
      read(y, z, row);
      for (std::int64_t x = 0; x < grid.size[0]; ++x) {
        if (inside(grid.index(x, y, z))) continue;
        const Moments here = row.at(static_cast<std::size_t>(x));
        sum.mass_deviation += here.density_deviation;
        sum.momentum += here.momentum;
        sum.staggered_momentum += (x + y + z + (planted(Mutant::staggered_sum_still) ? 0 : steps)) % 2 == 0
                                      ? here.momentum
                                      : Vec3(-here.momentum);
      }
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

/// Whether a node of the row may be worse than `worst`: all of them at once, most rows need no second look.
inline bool may_be_worse(const RowMoments& row, const Extremes& worst) {
  // j^2 > max_speed^2 rho^2, with room for rounding; written such that what is no number passes.
  const double slower = worst.max_speed * worst.max_speed * (1.0 - 1e-12);
  const auto nx = static_cast<std::int64_t>(row.density_deviation.size());
  const double* const rho_1 = row.density_deviation.data();
  const double* const jx = row.momentum[0].data();
  const double* const jy = row.momentum[1].data();
  const double* const jz = row.momentum[2].data();
  std::int64_t better = 0;
#pragma omp simd reduction(+ : better)
  for (std::int64_t x = 0; x < nx; ++x) {
    const double rho = 1.0 + rho_1[x];
    const bool is_better = (rho >= worst.min_density) & (rho < 1e300) &
                           ((jx[x] * jx[x] + jy[x] * jy[x]) + jz[x] * jz[x] <= slower * (rho * rho));
    better += is_better ? 1 : 0;
  }
  return better < nx - (planted(Mutant::lone_fast_node_overlooked) ? 1 : 0);
}

/// As above.
template <class Reader, class Inside>
Extremes extremes_of(const Grid& grid, const Reader& reader, const Inside& inside) {
  std::vector<RowReader<Reader>> of_threads = one_per_thread(reader, grid.size[0]);
  std::vector<Extremes> planes(static_cast<std::size_t>(grid.size[2]));
#pragma omp parallel for schedule(static) if (grid.count() >= worth_threads)
  for (std::int64_t z = 0; z < grid.size[2]; ++z) {
    Extremes worst{INFINITY, grid.index(0, 0, z), 0.0, grid.index(0, 0, z)};
    auto& [read, row] = of_threads[static_cast<std::size_t>(omp_get_thread_num())];
    for (std::int64_t y = 0; y < grid.size[1]; ++y) {
      read(y, z, row);
      if (!may_be_worse(row, worst)) continue;
      for (std::int64_t x = 0; x < grid.size[0]; ++x) {
        const std::int64_t node = grid.index(x, y, z);
        if (inside(node)) continue;
        const Moments here = row.at(static_cast<std::size_t>(x));
        const double rho = 1.0 + here.density_deviation;
        keep_worse(worst, {std::isfinite(rho) ? rho : NAN, node, here.momentum.norm() / rho, node});
      }
    }
    planes[static_cast<std::size_t>(z)] = worst;
  }
  Extremes worst = planes.front();
  for (const Extremes& plane : planes) keep_worse(worst, plane);
  return worst;
}

}  // namespace veriflex::fluid
