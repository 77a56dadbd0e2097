/// A driven filament as the tables of a case say it, and changes to it.
#pragma once

#include "drivers/filament_run.hpp"
#include "io/document.hpp"
#include "scene/plan.hpp"

namespace veriflex::drivers {

/// [bond], [solid], [angle], [fluid], [coupling], [watch] and the part of [filament] that is the filament's
/// own. Throws InputError.
Stroke read_stroke(const io::Section& top);

/// The same filament with what a [[variant]] changes of it. A changed amplitude keeps the frequency. Throws
/// InputError.
Stroke varied(const Stroke& base, const io::Section& variant);

/// The plan, with a scene that cannot be planned reported at its place in the case.
scene::Plan plan_stroke(const io::Section& top, const Stroke& stroke);

}  // namespace veriflex::drivers
