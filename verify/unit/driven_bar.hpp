/// A short bar in a small periodic box, for laws that hold between the runs of two related scenes: driven at
/// one end, loaded, deformed and moving at the start, in a fluid that is disordered at the start, so that
/// nothing about it is symmetric and every part of a coupled step takes part.
#pragma once

#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "base/reduce.hpp"
#include "bond/derive.hpp"
#include "plain_fluid.hpp"
#include "scene/simulation.hpp"
#include "thread_count.hpp"

namespace veriflex::unit {

struct Setting {
  double relaxation_time;  // 1: a fluid of moments, else of populations
  bool fene;
  bool subcycled;
};

inline std::vector<Setting> settings() {
  std::vector<Setting> all;
  for (const double tau : {1.0, 0.7}) {
    for (const bool fene : {false, true}) {
      for (const bool subcycled : {false, true}) all.push_back({tau, fene, subcycled});
    }
  }
  return all;
}

inline std::string words_of(const Setting& setting) {
  return "tau " + std::to_string(setting.relaxation_time) + (setting.fene ? ", FENE-LJ" : ", harmonic") +
         (setting.subcycled ? ", subcycled" : ", frozen");
}

/// The paper's two laws and angles; `share` of all their stiffness.
inline solid::Material material_of(const Setting& setting, double share = 1.0) {
  if (!setting.fene) return {bond::Harmonic{0.26 * share, 1.0}, 0.025 * share};
  bond::FeneLj law{2.87e-4 * share, 1.0407, 0.0, 1.5 * 1.0407, bond::FeneLj::lj_minimum * 1.0407};
  law.fene_k = 30.0 * law.epsilon / (law.sigma * law.sigma);
  return {law, 0.025 * share};
}

/// Each coordinate uniform in +- amplitude.
inline Positions noise(Eigen::Index nodes, double amplitude, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-amplitude, amplitude);
  return Positions::NullaryExpr(nodes, 3, [&] { return number(random); });
}

/// 2 x 2 x 4 nodes, of which the first section is driven along x, at rest and undeformed.
inline scene::Body bar(const Setting& setting, const Vec3& place) {
  const double spacing = bond::derive(material_of(setting).law).rest_length;
  scene::Body body{.material = material_of(setting),
                   .network = solid::cubic_lattice({{2, 2, 4}, spacing}),
                   .substeps = {.count = 2},
                   .place = place,
                   .coupling = scene::CouplingSpec{.subcycled = setting.subcycled}};
  solid::add_angles(body.network);
  const Eigen::Index nodes = body.network.node_count();
  body.conditions.node_mass = 1.5;
  body.conditions.load = Positions::Zero(nodes, 3);
  body.conditions.drive = solid::Drive{{0, 1, 2, 3}, 0, 0.3, 2.0 * std::numbers::pi / 40.0, 5.0};
  body.start = {Positions::Zero(nodes, 3), Positions::Zero(nodes, 3)};
  return body;
}

/// The same loaded, deformed and kicked.
inline scene::Body kicked_bar(const Setting& setting, const Vec3& place) {
  scene::Body body = bar(setting, place);
  const Eigen::Index nodes = body.network.node_count();
  body.conditions.load = noise(nodes, 1e-3, 1);
  body.start = {noise(nodes, 0.02, 2), noise(nodes, 0.005, 3)};
  return body;
}

inline const Vec3 somewhere(5.3, 4.6, 5.2);

inline scene::Scene in_fluid(const Setting& setting, scene::Body body) {
  return {.fluid = fluid::Spec{.grid = {{12, 10, 14}}, .relaxation_time = setting.relaxation_time},
          .bodies = {std::move(body)}};
}

inline scene::Scene disordered(const Setting& setting, const Vec3& place = somewhere) {
  scene::Scene scene = in_fluid(setting, kicked_bar(setting, place));
  scene.initial_flow = fluid::disorder(0.02);
  return scene;
}

inline scene::State run(const scene::Scene& scene, int steps = 100) {
  const Threads one(1);
  scene::Simulation simulation(scene);
  for (int step = 0; step < steps; ++step) simulation.advance();
  return simulation.state();
}

inline const Positions& displacement(const scene::State& state, std::size_t body = 0) {
  return state.bodies[body].elastic->displacement;
}

inline double distance(const Positions& a, const Positions& b) { return largest_magnitude(a - b); }

/// Of the populations, node by node as far as `a` goes.
inline double distance(const fluid::State& a, const fluid::State& b) {
  double largest = 0.0;
  for (std::size_t node = 0; node < a.populations.size(); ++node) {
    for (std::size_t q = 0; q < fluid::Q; ++q)
      largest = worse(largest, std::abs(a.populations[node][q] - b.populations[node][q]));
  }
  return largest;
}

/// Of the first body's displacements and of the populations.
inline double distance(const scene::State& a, const scene::State& b) {
  return worse(distance(displacement(a), displacement(b)), distance(*a.fluid, *b.fluid));
}

/// What the place of a marker is rounded to in these boxes, below 16. A run carries numbers of at most 0.3,
/// makes of such a rounding what the gradient of a velocity makes of it, and forgets: after 100 steps it has
/// a fourteenth of what the start was off. All that differs by the order of sums is smaller still.
constexpr double rounding_of_place = 0x1p-50;

}  // namespace veriflex::unit
