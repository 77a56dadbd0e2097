#include "measures/filament/filament_compare.hpp"

#include <algorithm>
#include <cmath>

#include "base/reduce.hpp"

namespace veriflex::measures {

Deviation deviation(const StrokeResult& a, const StrokeResult& b, std::size_t phase, double z0) {
  const Eigen::Index nodes = std::min(a.lines[phase].rows(), b.lines[phase].rows());
  Positions d = a.lines[phase].bottomRows(nodes) - b.lines[phase].bottomRows(nodes);
  Deviation result{};
  const auto rms = [&](const auto& values) {
    return std::sqrt(values.squaredNorm() / static_cast<double>(d.rows())) / z0;
  };
  result.z_max = largest_magnitude(d.col(2)) / z0;
  result.z_rms = rms(d.col(2));
  result.lab_max = largest(d.rowwise().norm()) / z0;
  result.lab_rms = rms(d);
  d.col(1).array() -= a.centre[phase][1] - b.centre[phase][1];
  result.moved_max = largest(d.rowwise().norm()) / z0;
  result.moved_rms = rms(d);
  return result;
}

std::array<std::size_t, 4> figure_phases(const StrokeResult& seen) {
  const std::size_t last = seen.lines.size() - phases_per_period;
  return {last + 1, last + 3, last + 5, last + 7};
}

Deviation worst(const StrokeResult& a, const StrokeResult& b, double z0) {
  Deviation most{};
  for (const std::size_t phase : figure_phases(a)) {
    const Deviation d = deviation(a, b, phase, z0);
    most.z_max = worse(most.z_max, d.z_max);
    most.z_rms = worse(most.z_rms, d.z_rms);
    most.lab_max = worse(most.lab_max, d.lab_max);
    most.lab_rms = worse(most.lab_rms, d.lab_rms);
    most.moved_max = worse(most.moved_max, d.moved_max);
    most.moved_rms = worse(most.moved_rms, d.moved_rms);
  }
  return most;
}

double change_over_last_period(const StrokeResult& seen, double z0) {
  double most = 0.0;
  for (const std::size_t phase : figure_phases(seen)) {
    Positions d = seen.lines[phase] - seen.lines[phase - phases_per_period];
    d.col(1).array() -= seen.centre[phase][1] - seen.centre[phase - phases_per_period][1];
    most = worse(most, largest(d.rowwise().norm()) / z0);
  }
  return most;
}

double swum(const StrokeResult& seen) {
  const std::size_t last = seen.centre.size() - 1;
  const double from = seen.centre.size() > phases_per_period ? seen.centre[last - phases_per_period][1] : 0.0;
  return seen.centre[last][1] - from;
}

}  // namespace veriflex::measures
