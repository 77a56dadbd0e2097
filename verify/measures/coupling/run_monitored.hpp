/// Runs of a fluid with bodies in it that is checked on the way.
#pragma once

#include <functional>
#include <string>

#include "observe/check.hpp"
#include "observe/record.hpp"

namespace veriflex::measures {

/// A run, which makes the fluid's steps and calls `check_when_due` after each.
using Steps = std::function<void(const std::function<void()>& check_when_due)>;

/// Checks the fluid before the run, at every monitor.every-th step and at the end. What breaks off, called
/// `name`, throws observe::Interrupted with the metrics of the last good check.
void run_monitored(const fluid::Fluid& fluid, const observe::MonitorSpec& monitor, const std::string& name,
                   const Steps& steps);

}  // namespace veriflex::measures
