#include "observe/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "base/mutant.hpp"
#include "base/reduce.hpp"
#include "observe/interrupted.hpp"
#include "scene/contact.hpp"

namespace veriflex::observe {

bool Due::at(std::int64_t step) const {
  if (!std::isfinite(interval)) return false;
  const double count = planted(Mutant::observer_rounds_down)
                           ? std::floor(static_cast<double>(step) / interval)
                           : std::round(static_cast<double>(step) / interval);
  return std::llround(count * interval) == step;
}

Run::Run(scene::Simulation& simulation, const MonitorSpec& spec, std::vector<Observer> observers,
         const std::string& name, Progress& progress)
    : simulation_(simulation),
      spec_(spec),
      observers_(std::move(observers)),
      name_(name),
      progress_(progress) {
  for (std::size_t i = 0; spec.bodies.any() && i < simulation.body_count(); ++i) {
    if (simulation.body(i).is_elastic()) body_checks_.emplace_back(simulation.body(i), spec.bodies);
  }
  guarded([&] {
    check_now();
    look_at_bodies();
    observe(false);
  });
}

template <class Work>
void Run::guarded(Work work) {
  try {
    work();
  } catch (const NumericalFailure& failure) {
    interrupt(failure);
  }
}

void Run::interrupt(const NumericalFailure& why) const {
  Observations left{.records = {}, .metrics = good_};
  if (!good_nodes_.empty()) left.records.push_back(last_good_nodes(good_nodes_, name_));
  if (name_.empty()) throw Interrupted(why, std::move(left));
  throw Interrupted(why.at(name_), std::move(left));
}

void Run::advance(std::int64_t steps, std::int64_t planned) {
  guarded([&] {
    const std::int64_t end = simulation_.steps() + steps, at_once = simulation_.steps_at_once();
    while (simulation_.steps() < end) {
      simulation_.advance(steps_to_next(std::min(at_once, end - simulation_.steps())),
                          [this] { look_at_bodies(); });
      if (simulation_.steps() % spec_.every == 0) check_now();
      observe(false);
      progress_.show(name_.empty() ? "steps" : name_, static_cast<std::size_t>(simulation_.steps()),
                     static_cast<std::size_t>(planned));
    }
  });
}

// Until a check or an observer is due, at most so many.
std::int64_t Run::steps_to_next(std::int64_t most) const {
  const auto is_due = [this](std::int64_t step) {
    return step % spec_.every == 0 ||
           std::any_of(observers_.begin(), observers_.end(), [=](const Observer& observer) {
             return !observer.at_bodies && observer.due.at(step);
           });
  };
  std::int64_t steps = 1;
  while (steps < most && !is_due(simulation_.steps() + steps)) ++steps;
  return steps;
}

void Run::finish() {
  guarded([&] {
    if (checked_ != simulation_.steps()) check_now();
    observe(true);
  });
}

Run::State Run::state() const {
  State state{checked_, good_, good_nodes_, {}, {}};
  for (const BodyCheck& body : body_checks_) state.load_work.push_back(body.load_work());
  for (const auto& [i, j] : warned_) state.warned.push_back({i, j});
  return state;
}

void Run::restore(const State& state) {
  assert(state.good_nodes.empty() || state.good_nodes.size() == simulation_.body_count());
  assert(state.load_work.size() == body_checks_.size());
  checked_ = state.checked;
  good_ = state.good;
  good_nodes_ = state.good_nodes;
  for (std::size_t i = 0; i < body_checks_.size(); ++i) body_checks_[i].restore(state.load_work[i]);
  warned_.clear();
  for (const auto& [i, j] : state.warned) warned_.insert({i, j});
}

void Run::observe(bool at_end) {
  const std::int64_t step = simulation_.steps();
  for (const Observer& observer : observers_) {
    const bool due = observer.due.at(step);
    if (at_end ? !due && ended_ != step : due && !observer.at_bodies) observer.look(simulation_);
  }
  if (at_end) ended_ = step;
}

// Of each step, be the fluid behind or not.
void Run::look_at_bodies() {
  for (const Observer& observer : observers_) {
    if (observer.at_bodies && observer.due.at(simulation_.steps())) observer.look(simulation_);
  }
}

void Run::check_now() {
  const std::int64_t step = simulation_.steps();
  if (simulation_.has_fluid()) {
    const fluid::Extremes seen = check(simulation_.fluid(), spec_);
    max_mach_ = worse(max_mach_, seen.max_speed / std::sqrt(fluid::sound_speed_squared));
    good_ = last_good(step, seen);
  } else {
    good_ = {last_good_step(step)};
  }
  for (BodyCheck& body : body_checks_) body.look(step);
  good_nodes_.clear();
  for (std::size_t i = 0; i < simulation_.body_count(); ++i) {
    good_nodes_.push_back(simulation_.body(i).positions());
  }
  checked_ = step;
  warn_of_contacts();
}

void Run::warn_of_contacts() {
  constexpr double nearest = 1.0;  // [L]; kernels no longer tell the two surfaces apart
  for (std::size_t i = 0; i < simulation_.body_count(); ++i) {
    for (std::size_t j = i + 1; j < simulation_.body_count(); ++j) {
      const scene::MovingBody& a = simulation_.body(i);
      const scene::MovingBody& b = simulation_.body(j);
      if (!a.is_coupled() || !b.is_coupled() || warned_.contains({i, j})) continue;
      const fluid::Spec& fluid = simulation_.fluid().spec();
      const auto met =
          scene::nearest_within(nearest, a.markers(), b.markers(), fluid.grid, fluid::closed(fluid));
      if (!met) continue;
      warned_.insert({i, j});
      progress_.warn(fmt::format(
          "step {}: {} and {} are {:.3g} spacings apart (nodes {} and {}): nothing keeps bodies from passing "
          "through each other, and nearer than 1 the coupling no longer tells them apart",
          simulation_.steps(), a.name(), b.name(), met->distance,
          a.coupled()[static_cast<std::size_t>(met->first)],
          b.coupled()[static_cast<std::size_t>(met->second)]));
    }
  }
}

Record last_good_nodes(const std::vector<Positions>& nodes, const std::string& whose) {
  const bool several = nodes.size() > 1;
  Record record{"last_good_nodes", "Where the nodes were at the last good check, " + whose, {}};
  if (several) record.columns.push_back({"body", "", "1", "number of the body, from 0", {}});
  record.columns.insert(record.columns.end(), {{"node", "", "1", "number of the node", {}},
                                               {"x", "", "L", "in the box, not wrapped", {}},
                                               {"y", "", "L", "in the box, not wrapped", {}},
                                               {"z", "", "L", "in the box, not wrapped", {}}});
  for (std::size_t body = 0; body < nodes.size(); ++body) {
    for (Eigen::Index i = 0; i < nodes[body].rows(); ++i) {
      std::vector<double> row{static_cast<double>(i), nodes[body](i, 0), nodes[body](i, 1),
                              nodes[body](i, 2)};
      if (several) row.insert(row.begin(), static_cast<double>(body));
      record.append(row);
    }
  }
  return record;
}

}  // namespace veriflex::observe
