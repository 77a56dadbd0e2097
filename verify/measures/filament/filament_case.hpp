/// A driven filament as the tables of a case say it, and changes to it.
#pragma once

#include "io/document.hpp"
#include "measures/filament/filament_run.hpp"
#include "scene/plan.hpp"

namespace veriflex::measures {

/// Of the axis from the middle of the box. Neighbouring doubles there are 1e-7 apart  [L].
constexpr double farthest_offset = 1e9;

/// [bond], [solid], [angle], [fluid], [coupling], [monitor] and the part of [filament] that is the filament's
/// own. Throws InputError.
Stroke read_stroke(const io::Table& top);

/// The same filament with what a [[variant]] changes of it. A changed amplitude keeps the frequency. Throws
/// InputError, also where it then has no room in its box.
Stroke varied(const Stroke& base, const io::Table& variant);

/// Of so many runs of the stroke.
scene::ExpectedWork expected_work(const Stroke& stroke, std::int64_t runs);

/// The plan, with a scene that cannot be planned, or whose filament has no room in its box, reported at its
/// place in the case.
scene::Plan plan_stroke(const io::Table& top, const Stroke& stroke);

}  // namespace veriflex::measures
