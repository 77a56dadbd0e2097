/// What a driver makes of a case: a plan that can be shown, and a run that measures.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/progress.hpp"
#include "engine/cost.hpp"
#include "io/document.hpp"
#include "observe/record.hpp"
#include "scene/offers.hpp"
#include "scene/plan.hpp"

namespace veriflex::engine {

class Checkpoints;

/// Whose numbers a study hands on, where it computes none itself.
struct OtherCode {
  std::string name;      // with its version
  std::string obtained;  // how it was run and read
  std::string of_case;   // id of the case that asks this program the same; empty: none is named
};

/// The runs of a study that makes many of one case.
struct Runs {
  std::vector<std::vector<std::string>> settings;  // what each changes in the case, as --set takes it
  bool side_by_side = true;  // with a thread each; else one after another with all threads
  int times = 1;             // that each is made
};

struct Study {
  scene::Plan plan;
  /// What a run measures: metrics, whose values mean nothing yet, and records without rows. The one place
  /// that says so; the run sets the values and appends the rows.
  observe::Observations declares{};
  /// Of drivers that give dimension and meaning as they measure: metric names, and `record.column`.
  std::vector<std::string> measures{};
  /// Runs the study on the caller's begin(), as it goes, so that whatever ends a run leaves what was seen
  /// until then. The result depends on nothing but the case: not on threads, time or machine load. Throws
  /// NumericalFailure; an observe::Interrupted brings the last good state along.
  std::function<void(observe::Observations&, Progress&, Cost&)> run;
  /// The same run, which leaves checkpoints behind and goes on from one; empty where the driver has none or
  /// the case asks for none.
  std::function<void(observe::Observations&, Progress&, Cost&, Checkpoints&)> run_with_checkpoints{};
  /// Set where it makes many runs of a case, so that its checks ask for numbers of several rows
  /// (engine::Asked). Those of a search are such as it would make were what it looks for in the middle.
  std::optional<Runs> runs{};
  /// What one run will do, scene after scene; nothing where that cannot be known.
  std::function<std::vector<scene::ExpectedWork>()> expects{};
  /// What the case could do without at a price in accuracy; empty: nothing is known of that. Takes a while.
  std::function<std::vector<scene::Offer>()> offers{};
  /// Set where the numbers are not this program's.
  std::optional<OtherCode> other_code{};
  /// What this program was built without and a run needs, and what to do about that; empty: nothing.
  std::string lacks{};
};

/// Everything a check may ask for: metrics, and `record.column` for curves. Dimension and meaning are empty
/// where the driver does not declare them.
std::vector<observe::Metric> measured(const Study& study);
std::vector<std::string> names_of(const std::vector<observe::Metric>& metrics);

/// What a run begins with: nothing measured, all that is declared.
observe::Observations begin(const Study& study);

/// Holds what a complete run has seen against what was declared. Throws std::logic_error for a metric that
/// was declared and not measured, or the other way round.
void hold_to_declaration(const Study& study, const observe::Observations& seen);

/// Holds what a complete run has built, since parts::restart(), against the plan. Throws std::logic_error. A
/// study of many runs builds nothing itself: its rows are held to their plans.
void hold_to_plan(const Study& study);

/// A kind of study, by the name that `driver = "..."` gives in a case.
struct Driver {
  std::string name;
  std::string what;                     // one line for `veriflex list`
  Study (*read)(const io::Table& top);  // reads the driver's own tables of the case
};

}  // namespace veriflex::engine
