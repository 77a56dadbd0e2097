/// Runs of a fluid with bodies in it that is checked on the way.
#pragma once

#include <functional>
#include <string>

#include "observe/check.hpp"
#include "observe/record.hpp"

namespace veriflex::measures {

/// Calls advance(0), advance(1), ... for so many steps, each of which makes one of the fluid. Checks the
/// fluid before the run, at every monitor.every-th step and at the end. What breaks off, called `name`,
/// throws observe::Interrupted with the metrics of the last good check.
void run_monitored(const fluid::Fluid& fluid, const observe::MonitorSpec& monitor, const std::string& name,
                   std::int64_t steps, const std::function<void(std::int64_t step)>& advance);

}  // namespace veriflex::measures
