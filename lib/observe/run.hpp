/// The run of a scene: its steps, what is observed of them, and the monitor over both.
#pragma once

#include <array>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "base/progress.hpp"
#include "observe/check.hpp"
#include "observe/record.hpp"
#include "scene/simulation.hpp"

namespace veriflex::observe {

/// Steps at which something is due: those nearest to the multiples of an interval of one step or more.
struct Due {
  double interval;  // [T]; infinite: never, not even at the start
  bool at(std::int64_t step) const;
};

/// Sees the scene at every step that is due, the start among them, and after the last.
struct Observer {
  Due due;
  std::function<void(const scene::Simulation&)> look;
  bool at_bodies = false;  // alone: the fluid may make many steps at once meanwhile
};

/// A run that looks after its scene: before the first step, after every monitor.every-th and after the last,
/// whatever monitor.every. Where that finds the fluid unsound, or a step fails, or the run is asked to stop,
/// it throws Interrupted with the last good state: the metrics of last_good() and a record `last_good_nodes`
/// of all bodies' nodes.
class Run {
 public:
  /// Looks at once. Messages begin with `name`, unless it is empty. Simulation and progress must outlive the
  /// run.
  Run(scene::Simulation& simulation, const MonitorSpec& spec, std::vector<Observer> observers,
      const std::string& name, Progress& progress);

  /// So many steps. Progress is shown as a part of `planned` steps of the run.
  void advance(std::int64_t steps, std::int64_t planned);

  /// After the last step: what was not checked yet is.
  void finish();

  /// Largest Mach number that its checks saw; 0 without a fluid.
  double max_mach() const { return max_mach_; }

  /// What a run knows beside its simulation, its records and what its series keep, between two steps; and
  /// back to one of the same scene.
  struct State {
    std::int64_t checked;  // step of the last check, and what it found
    std::vector<Metric> good;
    std::vector<Positions> good_nodes;               // of each body
    std::vector<double> load_work;                   // of each body whose energy is looked at  [M L^2 T^-2]
    std::vector<std::array<std::size_t, 2>> warned;  // bodies whose contact was reported
  };
  State state() const;
  void restore(const State& state);

  /// Ends the run for a reason of the caller's own, with the last good state.
  [[noreturn]] void interrupt(const NumericalFailure& why) const;

 private:
  template <class Work>
  void guarded(Work work);
  void check_now();
  void observe(bool at_end);
  void look_at_bodies();
  void warn_of_contacts();
  std::int64_t steps_to_next(std::int64_t most) const;

  scene::Simulation& simulation_;
  MonitorSpec spec_;
  std::vector<Observer> observers_;
  std::string name_;
  Progress& progress_;
  std::int64_t ended_ = -1;  // step after which all were called
  std::int64_t checked_ = -1;
  double max_mach_ = 0.0;
  std::vector<Metric> good_;
  std::vector<Positions> good_nodes_;                     // of each body
  std::vector<BodyCheck> body_checks_;                    // none without limits
  std::set<std::pair<std::size_t, std::size_t>> warned_;  // bodies whose contact was reported
};

/// Record `last_good_nodes` of bodies whose nodes are at these places, one after the other.
Record last_good_nodes(const std::vector<Positions>& nodes, const std::string& whose);

}  // namespace veriflex::observe
