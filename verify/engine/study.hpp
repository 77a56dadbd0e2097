/// What a driver makes of a case: a plan that can be shown, and a run that measures.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/progress.hpp"
#include "engine/cost.hpp"
#include "io/document.hpp"
#include "observe/record.hpp"
#include "scene/plan.hpp"

namespace veriflex::engine {

struct Study {
  scene::Plan plan;
  /// Everything a check may ask for: metric names, and `record.column` for curves.
  std::vector<std::string> measures;
  /// Runs the study and adds what it measures to the caller's observations as it goes, so that whatever ends
  /// a run leaves what was seen until then. The result depends on nothing but the case: not on threads, time
  /// or machine load. Throws NumericalFailure; an observe::Interrupted brings the last good state along.
  std::function<void(observe::Observations&, Progress&, Cost&)> run;
  /// Whether it makes many runs of a case: its checks ask for numbers of several rows (engine::Asked).
  bool of_many_runs = false;
};

/// A kind of study, by the name that `driver = "..."` gives in a case.
struct Driver {
  std::string name;
  std::string what;                     // one line for `veriflex list`
  Study (*read)(const io::Table& top);  // reads the driver's own tables of the case
};

}  // namespace veriflex::engine
