/// Strokes that are checked before they start and leave what they saw when they break off.
#pragma once

#include "engine/check_coupling.hpp"
#include "measures/filament/filament_run.hpp"
#include "observe/record.hpp"

namespace veriflex::measures {

/// Checks the coupling of each of these bodies to the fluid, see engine::check_coupling(). Their largest
/// growth is set as `coupling_growth`, also of a scene that is then refused.
void check_strokes(const std::vector<Stroke>& strokes, observe::Observations& seen, Progress& progress);
observe::Metric growth_of_coupling();  // that metric, to be declared

/// run_stroke() under that name. Throws observe::Interrupted with what was seen when the stroke breaks off,
/// its course in time as record `history`.
StrokeResult run_guarded(const Stroke& stroke, const std::string& name, const std::string& history,
                         Progress& progress);

/// The stroke in time, as far as its numbers are finite.
observe::Record history_of(const StrokeResult& seen, const std::string& record, const std::string& law);

/// Wall and processor time of a stroke's fluid, coupling and solid.
std::vector<engine::Phase> parts_of(const scene::Simulation::Seconds& seconds);

}  // namespace veriflex::measures
