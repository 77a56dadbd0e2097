/// How far the centre lines of two strokes are apart.
#pragma once

#include "measures/filament/filament_run.hpp"

namespace veriflex::measures {

struct Deviation {
  double z_max, z_rms;          // of |dz| over the axis nodes, over z0
  double lab_max, lab_rms;      // of |d|
  double moved_max, moved_rms;  // of |d| after taking out each body's own displacement along y
};

/// Between the same nodes, counted from the driven end, at one of the sampled phases.
Deviation deviation(const StrokeResult& a, const StrokeResult& b, std::size_t phase, double z0);

/// The figures' four phases: T/4, T/2, 3T/4, T of the last period, as indices of StrokeResult::lines.
std::array<std::size_t, 4> figure_phases(const StrokeResult& seen);

/// The largest of the figures' four phases, each quantity by itself.
Deviation worst(const StrokeResult& a, const StrokeResult& b, double z0);

/// Largest change of the centre line from one period to the next at the figures' phases, over z0, swimming
/// taken out. Of a stroke of two periods or more.
double change_over_last_period(const StrokeResult& seen, double z0);

/// Displacement of the centre of mass along y in the last period  [L].
double swum(const StrokeResult& seen);

}  // namespace veriflex::measures
