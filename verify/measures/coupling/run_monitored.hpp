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
/// `name`, throws observe::Interrupted with the last good check: its metrics, and the records that `state`
/// gave of it.
void run_monitored(const fluid::Fluid& fluid, const observe::MonitorSpec& monitor, const std::string& name,
                   const Steps& steps, const std::function<std::vector<observe::Record>()>& state = {});

/// Record `last_good_nodes` of nodes at X.
observe::Record last_good_nodes(const Positions& X, const std::string& whose);

}  // namespace veriflex::measures
