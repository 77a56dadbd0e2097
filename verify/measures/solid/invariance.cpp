#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>

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

struct InvarianceStudy {
  solid::Material material;
  scene::SolidSpec solid;
  double noise;        // of the displacement, each coordinate uniform in +- noise  [L]
  double translation;  // [L]
  std::int64_t steps;  // of the runs that are compared bit by bit
  double time_step;    // [T]
};

Observations invariance_observations() {
  return {
      .records = {},
      .metrics = {
          {"rotation_error",
           {},
           "1",
           "forces of the turned body against the turned forces, over the largest"},
          {"permutation_error",
           {},
           "1",
           "forces with other numbers for nodes, bonds and angles, over the largest"},
          {"moved_rest_error", {}, "1", "forces of the body built elsewhere, over the largest"},
          {"moved_state_error", {}, "M L T^-2", "forces of the body carried elsewhere by its displacement"},
          {"moved_state_over_rounding",
           {},
           "1",
           "the same over 2^-52 translation (4 k + 8 |T|/r0 + 64 k_a/r0^2), T the tension at the spacing"},
          {"scaling_error", {}, "1", "end of a run in units scaled by powers of two, over the noise"},
          {"thread_error",
           {},
           "1",
           "ends of runs one after the other against all at once on all threads, over the noise"},
          {"run_length", {}, "1", "how far a run takes the nodes, over the noise"}}};
}

Positions gradient(const solid::Material& material, const solid::Network& network, const Positions& u) {
  return solid::visit(material, [&](const auto& law, const auto& angle) {
    solid::Workspace work;
    Positions by_node;
    if (!solid::deform(law, network, u, work) || !solid::gradient(law, angle, network, work, by_node))
      throw NumericalFailure("the noise takes a bond out of its law's domain, or folds an angle");
    return by_node;
  });
}

double distance(const Positions& a, const Positions& b) { return largest_magnitude(a - b); }

double rotation_error(const InvarianceStudy& study, const solid::Network& network, const Positions& u,
                      const Positions& expected) {
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
  solid::Network turned = network;
  turned.rest = network.rest * turn.transpose();
  turned.vectors = network.vectors * turn.transpose();
  return distance(gradient(study.material, turned, u * turn.transpose()), expected * turn.transpose());
}

// The same body with its nodes numbered, and its bonds and angles listed, in another order.
double permutation_error(const InvarianceStudy& study, const solid::Network& network, const Positions& u,
                         const Positions& expected) {
  std::mt19937_64 random(3);
  const auto shuffled = [&](std::size_t count) {
    std::vector<std::int32_t> order(count);
    std::iota(order.begin(), order.end(), 0);
    for (std::size_t i = count; i > 1; --i) std::swap(order[i - 1], order[random() % i]);
    return order;  // new place of each
  };
  const std::vector<std::int32_t> node = shuffled(static_cast<std::size_t>(network.node_count()));
  const std::vector<std::int32_t> bond = shuffled(network.bonds.size());
  solid::Network other = network;
  Positions u_other = u;
  for (std::size_t i = 0; i < node.size(); ++i) {
    other.rest.row(node[i]) = network.rest.row(static_cast<Eigen::Index>(i));
    u_other.row(node[i]) = u.row(static_cast<Eigen::Index>(i));
  }
  for (std::size_t b = 0; b < bond.size(); ++b) {
    const auto [first, second] = network.bonds[b];
    other.bonds[static_cast<std::size_t>(bond[b])] = {node[static_cast<std::size_t>(first)],
                                                      node[static_cast<std::size_t>(second)]};
    other.vectors.row(bond[b]) = network.vectors.row(static_cast<Eigen::Index>(b));
  }
  const std::vector<std::int32_t> angle = shuffled(network.angles.size());
  for (std::size_t a = 0; a < angle.size(); ++a) {
    solid::Angle moved = network.angles[a];
    moved.bond_a = bond[static_cast<std::size_t>(moved.bond_a)];
    moved.bond_b = bond[static_cast<std::size_t>(moved.bond_b)];
    other.angles[static_cast<std::size_t>(angle[a])] = moved;
  }
  const Positions found = gradient(study.material, other, u_other);
  double error = 0.0;
  for (std::size_t i = 0; i < node.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    error = worse(error, largest_magnitude(found.row(node[i]) - expected.row(at)));
  }
  return error;
}

// Displacement after the run of a noisy body of this material, seen in units of `length` and `time`.
Positions end_of_run(const InvarianceStudy& study, const solid::Material& material, double length,
                     double time, std::uint64_t seed) {
  solid::Network network = scene::build(study.solid);
  network.rest *= length;
  network.vectors *= length;
  network.spacing *= length;
  const Positions u = noise(network.node_count(), study.noise, seed) * length;
  solid::Leapfrog motion(material, network, {}, study.time_step * time, {}, u,
                         Positions::Zero(network.node_count(), 3));
  for (std::int64_t step = 0; step < study.steps; ++step) motion.step();
  return motion.displacement() / length;
}

void run_invariance(const InvarianceStudy& study, Observations& seen, Progress& progress,
                    engine::Cost& cost) {
  const solid::Network network = scene::build(study.solid);
  refuse_unstable_step(
      study.time_step,
      2.0 / solid::largest_frequency(study.material, network, Positions::Zero(network.node_count(), 3),
                                     solid::FixedDofs::Constant(network.node_count(), 3, false), 1.0));
  const Positions u = noise(network.node_count(), study.noise, 1);
  const Positions expected = gradient(study.material, network, u);
  const double scale = largest_magnitude(expected);

  solid::Network elsewhere = network;
  elsewhere.rest.array() += study.translation;
  const double moved_rest = distance(gradient(study.material, elsewhere, u), expected);
  const Positions far = u.array() + study.translation;
  const double moved_state = distance(gradient(study.material, network, far), expected);
  // Each coordinate is rounded by up to 2^-53 of itself, and forces change by the Hessian times that; twice
  // its largest eigenvalue in the bulk is a bound for what one node can feel.
  const double k = bond::stiffness(study.material.law, network.spacing);
  const double across = std::abs(bond::tension(study.material.law, network.spacing)) / network.spacing;
  const double stiffest =
      4.0 * k + 8.0 * across + 64.0 * study.material.angle_stiffness / (network.spacing * network.spacing);
  const double rounding = 0x1p-52 * study.translation * stiffest;
  cost.finish("forces");

  // Energies in units of 2^-30, lengths of 2^5, with the same mass: times in units of 2^20.
  const double energy = 0x1p-30;
  const double length = 0x1p5;
  const solid::Material scaled{bond::rescaled(study.material.law, energy, length),
                               study.material.angle_stiffness * energy};
  constexpr std::uint64_t seeds = 4;
  std::vector<Positions> alone;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed)
    alone.push_back(end_of_run(study, study.material, 1.0, 1.0, seed));
  std::vector<Positions> together(seeds);
  for_all(seeds, "runs", progress,
          [&](std::size_t i) { together[i] = end_of_run(study, study.material, 1.0, 1.0, i + 1); });
  double among_threads = 0.0;
  for (std::size_t i = 0; i < seeds; ++i)
    among_threads = worse(among_threads, distance(alone[i], together[i]));
  const double scaling = distance(end_of_run(study, scaled, length, 0x1p20, 1), alone[0]);
  cost.finish("runs");

  seen.set("rotation_error", rotation_error(study, network, u, expected) / scale);
  seen.set("permutation_error", permutation_error(study, network, u, expected) / scale);
  seen.set("moved_rest_error", moved_rest / scale);
  seen.set("moved_state_error", moved_state);
  seen.set("moved_state_over_rounding", moved_state / rounding);
  seen.set("scaling_error", scaling / study.noise);
  seen.set("thread_error", among_threads / study.noise);
  seen.set("run_length", distance(alone[0], u) / study.noise);
}

}  // namespace

engine::Study read_invariance(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const double rest_length = engine::read_derivation(top, law).rest_length;
  const scene::SolidSpec solid = engine::read_solid(top, law, rest_length);
  const io::Table t = top.table("invariance");
  const InvarianceStudy study{.material = {law, solid.angle_stiffness},
                              .solid = solid,
                              .noise = t.number("noise"),
                              .translation = t.number("translation"),
                              .steps = t.integer("steps", 1, 1'000'000),
                              .time_step = t.number("time_step")};
  for (const auto& [key, value] : {std::pair("noise", study.noise),
                                   {"translation", study.translation},
                                   {"time_step", study.time_step}}) {
    if (!(value > 0.0))
      t.fail(key, fmt::format("'{}' is {}", key, value), "nothing would be changed",
             "Give a positive number");
  }
  return {.plan = engine::read_plan(top, {.law = law,
                                          .solid = solid,
                                          .method = "forces of one noisy state; leap-frog, free",
                                          .by = {parts::Kind::LeapFrog}}),
          .declares = invariance_observations(),
          .run = std::bind_front(run_invariance, study)};
}

}  // namespace veriflex::measures
