#include <fmt/format.h>

#include <cmath>

#include "base/reduce.hpp"
#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/solid/linear_limit.hpp"
#include "measures/solid/noise.hpp"
#include "solid/leapfrog.hpp"
#include "solid/modes.hpp"

namespace veriflex::measures {

namespace {

using observe::Observations;

struct MotionStudy {
  solid::Material material;
  scene::SolidSpec solid;
  double noise;        // displacement at the start, each coordinate uniform in +- noise  [L]
  double speed;        // velocity at the start, likewise  [L T^-1]
  double duration;     // [T]
  std::int64_t steps;  // over the duration

  double time_step() const { return duration / static_cast<double>(steps); }
};

Observations integrator_observations() {
  return {
      .records = {},
      .metrics = {{"momentum_error", {}, "1", "largest departure over the sum of the nodes' |p|"},
                  {"angular_momentum_error", {}, "1", "largest departure over the sum of the nodes' |x||p|"},
                  {"reversal_error",
                   {},
                   "1",
                   "distance from the start after the run and its reverse, over the noise"},
                  {"energy_error", {}, "1", "largest departure over the energy above rest"},
                  {"dt_over_limit", {}, "1", "time step over the linear limit 2/omega_max at rest"}}};
}

// Sum of x(t) x p(t - dt/2): leap-frog keeps it exactly, as the torques of the internal forces at x(t)
// vanish.
Vec3 angular_momentum(const solid::Network& network, const solid::Leapfrog& motion) {
  Vec3 sum = Vec3::Zero();
  for (Eigen::Index i = 0; i < network.node_count(); ++i) {
    const Vec3 x = network.rest.row(i) + motion.displacement().row(i);
    sum += x.cross(Vec3(motion.carried_velocity().row(i)));
  }
  return sum;
}

void run_integrator(const MotionStudy& study, Observations& seen, engine::Cost& cost) {
  const solid::Network network = scene::build(study.solid);
  const Eigen::Index nodes = network.node_count();
  const Positions rest = Positions::Zero(nodes, 3);
  const double dt = study.time_step();
  const double limit = 2.0 / solid::largest_frequency(study.material, network, rest,
                                                      solid::FixedDofs::Constant(nodes, 3, false), 1.0);
  seen.set("dt_over_limit", dt / limit);
  cost.finish("linear limit");
  refuse_unstable_step(dt, limit);
  const Positions u = noise(nodes, study.noise, 1);
  const Positions v = noise(nodes, study.speed, 2);
  const double at_rest = solid::Leapfrog(study.material, network, {}, dt, {}, rest, rest).potential_energy();
  solid::Leapfrog motion(study.material, network, {}, dt, {}, u, v);
  const auto energy = [&] { return motion.kinetic_energy() + motion.potential_energy() - at_rest; };
  const double energy_0 = energy();
  const Vec3 momentum_0 = motion.momentum();
  const Vec3 angular_0 = angular_momentum(network, motion);
  const Positions v_0 = motion.carried_velocity();
  const double momentum_scale = v_0.rowwise().norm().sum();
  const double angular_scale = (network.rest.rowwise().norm().array() * v_0.rowwise().norm().array()).sum();
  double energy_error = 0.0, momentum_error = 0.0, angular_error = 0.0;
  for (std::int64_t step = 0; step < study.steps; ++step) {
    motion.step();
    energy_error = worse(energy_error, std::abs(energy() / energy_0 - 1.0));
    momentum_error = worse(momentum_error, (motion.momentum() - momentum_0).norm() / momentum_scale);
    angular_error =
        worse(angular_error, (angular_momentum(network, motion) - angular_0).norm() / angular_scale);
  }
  motion.reverse();
  for (std::int64_t step = 0; step < study.steps; ++step) motion.step();
  seen.set("energy_error", energy_error);
  seen.set("momentum_error", momentum_error);
  seen.set("angular_momentum_error", angular_error);
  seen.set("reversal_error", largest_magnitude(motion.displacement() - u) / study.noise);
  cost.finish("motion");
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
                          .steps = t.integer("steps", 1, 10'000'000)};
  for (const auto& [key, value] :
       {std::pair("noise", study.noise), {"speed", study.speed}, {"duration", study.duration}}) {
    if (!(value > 0.0))
      t.fail(key, fmt::format("'{}' is {}", key, value), "the body must move for a time",
             "Give a positive number");
  }
  return {.plan = engine::read_plan(top, {.law = law,
                                          .solid = solid,
                                          .method = "leap-frog, free, from noise",
                                          .by = {parts::Kind::LeapFrog}}),
          .declares = integrator_observations(),
          .run = [study](Observations& seen, Progress&, engine::Cost& cost) {
            run_integrator(study, seen, cost);
          }};
}

}  // namespace veriflex::measures
