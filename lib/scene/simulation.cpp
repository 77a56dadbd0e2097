#include "scene/simulation.hpp"

#include <chrono>
#include <ctime>

#include "base/error.hpp"

namespace veriflex::scene {

namespace {

class Stopwatch {
 public:
  /// Adds the time since the last lap.
  void lap(Simulation::Spent& to) {
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

}  // namespace

Simulation::Simulation(Scene scene) {
  if (scene.fluid) {
    fluid_ = fluid::make_fluid(*scene.fluid);
    if (scene.initial_flow) fluid_->start(scene.initial_flow);
  }
  for (Body& body : scene.bodies) {
    bodies_.push_back(std::make_unique<MovingBody>(std::move(body), scene.fluid ? &*scene.fluid : nullptr));
    if (bodies_.back()->is_coupled()) coupled_.push_back(bodies_.back().get());
  }
  if (coupled_.size() > 1) reaction_ = std::make_unique<coupling::SummedForces>();
}

void Simulation::advance() {
  Stopwatch watch;
  for (MovingBody* body : coupled_) body->interpolate(*fluid_);
  watch.lap(seconds_.coupling);

  for (const auto& body : bodies_) body->move();
  watch.lap(seconds_.solid);

  fluid::NodeForces reaction{};
  for (MovingBody* body : coupled_) body->spread();
  if (coupled_.size() == 1) reaction = coupled_.front()->reaction();
  if (reaction_) {
    reaction_->clear();
    for (const MovingBody* body : coupled_) {
      const fluid::NodeForces of_body = body->reaction();
      reaction_->add(of_body.nodes, *of_body.force);
    }
    reaction_->sum();
    reaction = {reaction_->nodes(), &reaction_->force()};
  }
  watch.lap(seconds_.coupling);

  if (fluid_) fluid_->collide_and_stream(reaction);
  watch.lap(seconds_.fluid);
  ++steps_;
}

State Simulation::state() const {
  State state{steps_, fluid_ ? std::optional(fluid_->state()) : std::nullopt, {}};
  for (const auto& body : bodies_) state.bodies.push_back(body->state());
  return state;
}

void Simulation::restore(const State& state) {
  steps_ = state.steps;
  if (fluid_) fluid_->restore(*state.fluid);
  for (std::size_t i = 0; i < bodies_.size(); ++i) bodies_[i]->restore(state.bodies[i]);
}

Vec3 Simulation::momentum() const {
  Vec3 sum = fluid_ ? fluid_->totals().momentum : Vec3(Vec3::Zero());
  for (const auto& body : bodies_) sum += body->momentum();
  return sum;
}

}  // namespace veriflex::scene
