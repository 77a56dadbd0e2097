#include "analytic/stream_growth.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/error.hpp"
#include "base/reduce.hpp"

namespace veriflex::analytic {

namespace {

std::array<std::int64_t, 3> waves_of(const Grid& box, std::int64_t number) {
  std::array<std::int64_t, 3> waves = box.node(number);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (2 * waves[axis] > box.size[axis]) waves[axis] -= box.size[axis];
  }
  return waves;
}

// A wave and its opposite are complex conjugates: one of them will do.
bool is_the_opposite_of_an_earlier(const Grid& box, std::int64_t number) {
  std::array<std::int64_t, 3> opposite = box.node(number);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (opposite[axis] != 0) opposite[axis] = box.size[axis] - opposite[axis];
  }
  return box.index(opposite[0], opposite[1], opposite[2]) < number;
}

// Not a number when its eigenvalues are not found.
double factor_of(const Grid& box, const std::array<std::int64_t, 3>& waves, double relaxation_time,
                 const Vec3& stream) {
  Vec3 k;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    k[axis] = 2.0 * std::numbers::pi * static_cast<double>(waves[a]) / static_cast<double>(box.size[a]);
  }
  using Matrix = Eigen::Matrix<Complex, fluid::Q, fluid::Q>;
  const Eigen::ComplexEigenSolver<Matrix> solved(one_step(k, relaxation_time, stream), false);
  return solved.info() == Eigen::Success ? largest(solved.eigenvalues().cwiseAbs())
                                         : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

GrowingWave fastest_wave(const Grid& box, double relaxation_time, const Vec3& stream) {
  std::vector<double> factors(static_cast<std::size_t>(box.count()), 0.0);
#pragma omp parallel for schedule(dynamic, 16)
  for (std::int64_t number = 0; number < box.count(); ++number) {
    if (is_the_opposite_of_an_earlier(box, number)) continue;
    factors[static_cast<std::size_t>(number)] =
        factor_of(box, waves_of(box, number), relaxation_time, stream);
  }
  for (std::int64_t number = 0; number < box.count(); ++number) {
    if (!std::isnan(factors[static_cast<std::size_t>(number)])) continue;
    const auto [x, y, z] = waves_of(box, number);
    throw NumericalFailure(fmt::format("the eigenvalues of wave ({}, {}, {}) were not found", x, y, z),
                           FailureMode::NotConverged);
  }
  const auto fastest = std::max_element(factors.begin(), factors.end());
  return {*fastest, waves_of(box, fastest - factors.begin())};
}

}  // namespace veriflex::analytic
