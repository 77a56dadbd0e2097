#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/reduce.hpp"
#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/for_all.hpp"
#include "measures/solid/linear_limit.hpp"
#include "measures/solid/noise.hpp"
#include "solid/leapfrog.hpp"
#include "solid/modes.hpp"

namespace veriflex::measures {

namespace {

using observe::Observations;
using observe::Record;

struct MotionStudy {
  solid::Material material;
  scene::SolidSpec solid;
  double noise;                     // displacement at the start, each coordinate uniform in +- noise  [L]
  double speed;                     // velocity at the start, likewise  [L T^-1]
  double duration;                  // [T]
  std::vector<std::int64_t> steps;  // over the duration, rising
};

// What leap-frog should keep, as the largest departure during a run.
struct Drift {
  double energy;            // over the energy above rest
  double momentum;          // over the sum of the nodes' |p|
  double angular_momentum;  // over the sum of the nodes' |x||p|
  double reversal;          // after the same run backwards: distance from the start over the noise
};

// Sum of x(t) x p(t - dt/2): leap-frog keeps it exactly, as the torques of the internal forces at x(t)
// vanish.
Vec3 angular_momentum(const solid::Network& network, const solid::Leapfrog& motion) {
  Vec3 sum = Vec3::Zero();
  for (Eigen::Index i = 0; i < network.node_count(); ++i) {
    const Vec3 x = network.rest.row(i) + motion.displacement().row(i);
    sum += x.cross(Vec3(motion.half_velocity().row(i)));
  }
  return sum;
}

Drift drift(const MotionStudy& study, const solid::Network& network, std::int64_t steps) {
  const Eigen::Index nodes = network.node_count();
  const Positions u = noise(nodes, study.noise, 1);
  const Positions v = noise(nodes, study.speed, 2);
  const double dt = study.duration / static_cast<double>(steps);
  const double at_rest = solid::Leapfrog(study.material, network, {}, dt, {}, Positions::Zero(nodes, 3),
                                         Positions::Zero(nodes, 3))
                             .potential_energy();
  solid::Leapfrog motion(study.material, network, {}, dt, {}, u, v);
  const auto energy = [&] { return motion.kinetic_energy() + motion.potential_energy() - at_rest; };
  const double energy_0 = energy();
  const Vec3 momentum_0 = motion.momentum();
  const Vec3 angular_0 = angular_momentum(network, motion);
  const Positions v_0 = motion.half_velocity();
  const double momentum_scale = v_0.rowwise().norm().sum();
  const double angular_scale = (network.rest.rowwise().norm().array() * v_0.rowwise().norm().array()).sum();
  Drift largest{};
  for (std::int64_t step = 0; step < steps; ++step) {
    motion.step();
    largest.energy = worse(largest.energy, std::abs(energy() / energy_0 - 1.0));
    largest.momentum = worse(largest.momentum, (motion.momentum() - momentum_0).norm() / momentum_scale);
    largest.angular_momentum = worse(largest.angular_momentum,
                                     (angular_momentum(network, motion) - angular_0).norm() / angular_scale);
  }
  motion.reverse();
  for (std::int64_t step = 0; step < steps; ++step) motion.step();
  largest.reversal = largest_magnitude(motion.displacement() - u) / study.noise;
  return largest;
}

void run(const MotionStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  const solid::Network network = scene::build(study.solid);
  const Eigen::Index nodes = network.node_count();
  const double limit = 2.0 / solid::largest_frequency(study.material, network, Positions::Zero(nodes, 3),
                                                      solid::FixedDofs::Constant(nodes, 3, false), 1.0);
  cost.finish("linear limit");
  refuse_unstable_step(study.duration / static_cast<double>(study.steps.front()), limit);
  const std::size_t count = study.steps.size();
  std::vector<Drift> found(count);
  seen.records.push_back(
      {"conservation",
       "What leap-frog keeps, over the time step",
       {{"dt_over_limit", "", "1", "time step over the linear limit 2/omega_max at rest", {}},
        {"energy", "", "1", "largest departure over the energy above rest", {}},
        {"momentum", "", "1", "largest departure over the sum of the nodes' |p|", {}},
        {"angular_momentum", "", "1", "largest departure over the sum of the nodes' |x||p|", {}},
        {"reversal", "", "1", "distance from the start after the run and its reverse, over the noise", {}},
        {"steps", "", "1", "over the duration", {}}}});
  Record& record = seen.records.back();
  for_all(
      count, "runs", progress, [&](std::size_t i) { found[i] = drift(study, network, study.steps[i]); },
      [&](std::size_t i) {
        const Drift& d = found[i];
        const auto steps = static_cast<double>(study.steps[i]);
        record.append(
            {study.duration / steps / limit, d.energy, d.momentum, d.angular_momentum, d.reversal, steps});
      });
  cost.finish("runs");
  Drift worst{};
  for (const Drift& d : found) {
    worst.momentum = worse(worst.momentum, d.momentum);
    worst.angular_momentum = worse(worst.angular_momentum, d.angular_momentum);
    worst.reversal = worse(worst.reversal, d.reversal);
  }
  const double finer =
      static_cast<double>(study.steps[count - 1]) / static_cast<double>(study.steps[count - 2]);
  seen.metrics = {
      {"momentum_error", worst.momentum, "1", "worst of the steps"},
      {"angular_momentum_error", worst.angular_momentum, "1", "worst of the steps"},
      {"reversal_error", worst.reversal, "1", "worst of the steps, over the noise"},
      {"energy_error", found.back().energy, "1", "finest step"},
      {"order_energy", std::log(found[count - 2].energy / found[count - 1].energy) / std::log(finer), "1",
       "order in the step of the energy's departure, last two"},
      {"dt_over_limit", record.find("dt_over_limit")->values.front(), "1",
       "coarsest time step over the linear limit 2/omega_max at rest"}};
}

}  // namespace

engine::Study read_integrator(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const double rest_length = engine::read_derivation(top, law).rest_length;
  const scene::SolidSpec solid = engine::read_solid_at_rest(top, law, rest_length);
  const io::Table t = top.table("integrator");
  const MotionStudy study{.material = {law, solid.angle_stiffness},
                          .solid = solid,
                          .noise = t.number("noise"),
                          .speed = t.number("speed"),
                          .duration = t.number("duration"),
                          .steps = t.integers("steps")};
  for (const auto& [key, value] :
       {std::pair("noise", study.noise), {"speed", study.speed}, {"duration", study.duration}}) {
    if (!(value > 0.0))
      t.fail(key, fmt::format("'{}' is {}", key, value), "the body must move for a time",
             "Give a positive number");
  }
  bool rising = study.steps.size() >= 2 && study.steps.front() >= 1 && study.steps.back() <= 10'000'000;
  for (std::size_t i = 1; i < study.steps.size(); ++i) rising &= study.steps[i] > study.steps[i - 1];
  if (!rising) {
    t.fail("steps", "not two or more rising numbers of steps", "an order needs two",
           "Give for example [400, 800]");
  }
  return {.plan = engine::read_plan(top, {.law = law,
                                          .solid = solid,
                                          .method = "leap-frog, free, from noise",
                                          .by = {parts::Kind::LeapFrog}}),
          .measures = {"momentum_error", "angular_momentum_error", "reversal_error", "energy_error",
                       "order_energy", "dt_over_limit", "conservation.steps", "conservation.energy"},
          .run = [study](Observations& seen, Progress& progress, engine::Cost& cost) {
            run(study, seen, progress, cost);
          }};
}

}  // namespace veriflex::measures
