/// Runs of a fluid with bodies in it, under watch.
#pragma once

#include <functional>
#include <string>

#include "observe/record.hpp"
#include "observe/watch.hpp"

namespace veriflex::drivers {

/// A run, which makes the fluid's steps and calls `look_when_due` after each.
using Steps = std::function<void(const std::function<void()>& look_when_due)>;

/// Looks at the fluid before the run, at every watch.every-th step and at the end. What breaks off, called
/// `name`, throws observe::Interrupted with the metrics of the last good look.
void under_watch(const fluid::Fluid& fluid, const observe::Watch& watch, const std::string& name,
                 const Steps& steps);

}  // namespace veriflex::drivers
