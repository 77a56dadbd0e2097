/// Strokes that are looked at before they start and leave what they saw when they break off.
#pragma once

#include "drivers/filament_run.hpp"
#include "observe/record.hpp"

namespace veriflex::drivers {

/// The largest growth of the exchange of any of these bodies with the fluid, see engine::check_coupling().
double check_strokes(const std::vector<Stroke>& strokes, Progress& progress);

/// That growth as metric `coupling_growth`.
observe::Metric metric_of(double growth);

/// run_stroke() under that name. Throws observe::Interrupted with what was seen when the stroke breaks off.
StrokeResult run_guarded(const Stroke& stroke, const std::string& name, double growth, Progress& progress);

/// The stroke in time, as far as its numbers are finite.
observe::Record history_of(const StrokeResult& seen, const std::string& record, const std::string& law);

/// Wall and processor time of a stroke's fluid, coupling and solid.
std::vector<engine::Phase> parts_of(const scene::Simulation::Seconds& seconds);

}  // namespace veriflex::drivers
