#include "scene/simulation.hpp"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <ctime>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "fluid/links.hpp"

namespace veriflex::scene {

class Simulation::Stopwatch {
 public:
  /// Adds the time since the last lap.
  void lap(Spent& to) {
    const auto wall = std::chrono::steady_clock::now();
    const std::clock_t cpu = std::clock();
    to.wall += std::chrono::duration<double>(wall - wall_).count();
    to.cpu += static_cast<double>(cpu - cpu_) / CLOCKS_PER_SEC;
    wall_ = wall;
    cpu_ = cpu;
  }

 private:
  std::chrono::steady_clock::time_point wall_ = std::chrono::steady_clock::now();
  std::clock_t cpu_ = std::clock();
};

Simulation::Simulation(Scene scene) {
  if (scene.fluid) {
    fluid_ = fluid::make_fluid(*scene.fluid);
    if (scene.initial_flow) fluid_->start(scene.initial_flow);
  }
  for (Body& body : scene.bodies) {
    bodies_.push_back(std::make_unique<MovingBody>(std::move(body), scene.fluid ? &*scene.fluid : nullptr));
    if (bodies_.back()->is_coupled()) coupled_.push_back(bodies_.back().get());
  }
  if (scene.fluid && scene.uniform_force)
    uniform_ = std::make_unique<UniformForce>(*scene.fluid, scene.uniform_force);
  if (coupled_.size() + (uniform_ ? 1 : 0) > 1) sum_ = std::make_unique<coupling::SummedForces>();
}

UniformForce::UniformForce(const fluid::Spec& fluid, std::function<Vec3(std::int64_t step)> force)
    : force_(std::move(force)), nodes_(fluid::outside_of_obstacle(fluid)) {
  on_nodes_.resize(static_cast<Eigen::Index>(nodes_.size()), 3);
  part_ = {parts::Kind::UniformForce, parts::array_bytes(nodes_, on_nodes_)};
}

fluid::NodeForces UniformForce::at(std::int64_t step) {
  on_nodes_.rowwise() = force_(step).transpose();
  return {nodes_, &on_nodes_};
}

// What acts on single nodes in this step: reactions of bodies, and the uniform force.
fluid::NodeForces Simulation::on_fluid() {
  if (!sum_) {
    if (uniform_) return uniform_->at(steps_ + (planted(Mutant::uniform_force_ahead) ? 1 : 0));
    return coupled_.empty() ? fluid::NodeForces{} : coupled_.front()->reaction();
  }
  sum_->clear();
  const auto add = [this](const fluid::NodeForces& part) { sum_->add(part.nodes, *part.force); };
  for (const MovingBody* body : coupled_) add(body->reaction());
  if (uniform_) add(uniform_->at(steps_));
  sum_->sum();
  return {sum_->nodes(), &sum_->force()};
}

std::int64_t Simulation::steps_at_once() const { return fluid_ && !uniform_ ? fluid_->steps_at_once() : 1; }

void Simulation::advance(std::int64_t steps, const std::function<void()>& after_each) {
  if (is_bare_fluid()) {
    Stopwatch watch;
    fluid_->advance(steps);
    watch.lap(seconds_.fluid);
    steps_ += steps;
    return;
  }
  const std::int64_t at_once = steps_at_once(), end = steps_ + steps;
  while (at_once > 1 && end - steps_ > 1 && steps_ahead(std::min(at_once, end - steps_), after_each))
    continue;
  while (steps_ < end) {
    step();
    if (after_each) after_each();
  }
}

void Simulation::step() {
  if (!fluid_) {  // nothing to tell the solid's time from, and each look at the clocks is a call of the
                  // system
    for (const auto& body : bodies_) body->move();
    ++steps_;
    return;
  }
  Stopwatch watch;
  locate();
  const fluid::NodeForces forces = exchange(watch);
  fluid_->collide_and_stream(forces);
  watch.lap(seconds_.fluid);
  ++steps_;
}

// Some steps, at most so many, of which the nodes that bodies meet make each with them and all others follow
// at once. False, and nothing done, where that gains nothing.
bool Simulation::steps_ahead(std::int64_t most, const std::function<void()>& after_each) {
  Stopwatch watch;
  locate();
  const std::unique_ptr<fluid::StepsAhead> ahead = fluid_->steps_ahead(touched_rows(), most);
  watch.lap(seconds_.coupling);
  if (!ahead) return false;
  const auto let_others_follow = [&, near = seconds_.near] {
    watch.lap(seconds_.coupling);
    ahead->let_others_follow();
    watch.lap(seconds_.fluid);
    seconds_.fluid.wall += seconds_.near.wall - near.wall;
    seconds_.fluid.cpu += seconds_.near.cpu - near.cpu;
  };
  try {
    for (std::int64_t made = 0; made < ahead->most(); ++made) {
      if (made > 0) {
        locate();
        if (!ahead->cover(touched_rows())) break;
      }
      const fluid::NodeForces forces = exchange(watch);
      ahead->collide_and_stream(forces);
      watch.lap(seconds_.near);
      ++steps_;
      if (!after_each) continue;
      after_each();
      watch = Stopwatch();  // its time is none of a step's
    }
  } catch (...) {  // the fluid is then as it is where the same step of all nodes fails
    let_others_follow();
    throw;
  }
  let_others_follow();
  return true;
}

void Simulation::locate() {
  for (MovingBody* body : coupled_) body->locate();
}

std::vector<std::int64_t> Simulation::touched_rows() const {
  std::vector<std::int64_t> rows;
  for (const MovingBody* body : coupled_) {
    const std::vector<std::int64_t> more = body->rows();
    rows.insert(rows.end(), more.begin(), more.end());
  }
  return rows;
}

// One step of the bodies, and what they leave to the fluid.
fluid::NodeForces Simulation::exchange(Stopwatch& watch) {
  for (MovingBody* body : coupled_) body->interpolate(*fluid_);
  watch.lap(seconds_.coupling);

  for (const auto& body : bodies_) body->move();
  watch.lap(seconds_.solid);

  for (MovingBody* body : coupled_) body->spread();
  const fluid::NodeForces forces = on_fluid();
  watch.lap(seconds_.coupling);
  return forces;
}

State Simulation::state() const {
  State state{steps_, fluid_ ? std::optional(fluid_->state()) : std::nullopt, {}};
  for (const auto& body : bodies_) state.bodies.push_back(body->state());
  return state;
}

void Simulation::restore(const State& state) {
  assert(state.bodies.size() == bodies_.size() && state.fluid.has_value() == (fluid_ != nullptr));
  steps_ = state.steps;
  if (fluid_) fluid_->restore(*state.fluid);
  for (std::size_t i = 0; i < bodies_.size() && !planted(Mutant::bodies_not_restored); ++i)
    bodies_[i]->restore(state.bodies[i]);
}

Vec3 Simulation::momentum() const {
  Vec3 sum = fluid_ ? fluid_->totals().momentum : Vec3(Vec3::Zero());
  for (const auto& body : bodies_) sum += body->momentum();
  return sum;
}

}  // namespace veriflex::scene
