// What a force evaluation of the solid costs, for bodies inside and far outside the caches: the paper's
// filament (1071 nodes) and cubes of 10^3 and 10^6 nodes. Compare figures of one run only; nothing here
// passes or fails.

#include <benchmark/benchmark.h>

#include <random>
#include <string>
#include <vector>

#include "solid/elastic.hpp"

namespace {

using namespace veriflex;

constexpr double angle_stiffness = 0.025;

// Each law with the paper's modulus 0.26 at spacing 1.
std::vector<bond::AnyLaw> laws() {
  return {bond::Harmonic{0.26, 1.0},
          bond::FeneLj{.epsilon = 2.86970720062559e-4,
                       .sigma = 1.040694052478347,
                       .fene_k = 30.0 * 2.86970720062559e-4 / (1.040694052478347 * 1.040694052478347),
                       .r_max = 1.5 * 1.040694052478347,
                       .cutoff = bond::FeneLj::lj_minimum * 1.040694052478347},
          bond::ShiftedFene{0.26, 1.0, 0.5}};
}

struct Body {
  std::string name;
  solid::Network (*build)();
};

const std::vector<Body> bodies{
    {"filament",
     [] {
       return solid::rod_lattice({2.5, 51, 1.0});
     }},
    {"1e3",
     [] {
       return solid::cubic_lattice({{10, 10, 10}, 1.0});
     }},
    {"1e6",
     [] {
       return solid::cubic_lattice({{100, 100, 100}, 1.0});
     }},
};

Positions noise(const solid::Network& network) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-0.02, 0.02);
  Positions u(network.node_count(), 3);
  for (double& component : u.reshaped()) component = uniform(random);
  return u;
}

// Seconds per one of `count` things that each iteration goes through.
benchmark::Counter each_of(std::size_t count) {
  return {static_cast<double>(count),
          benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert};
}

// A whole evaluation: deformation of the bonds, their forces, those of the angles, the sum over the nodes.
void force(benchmark::State& state, const Body& body, const bond::AnyLaw& law, bool angles) {
  solid::Network network = body.build();
  if (angles) solid::add_angles(network);
  const Positions u = noise(network);
  Positions by_node;
  solid::Workspace work;
  solid::visit({law, angles ? angle_stiffness : 0.0}, [&](const auto& bond, const auto& angle) {
    const auto evaluate = [&] {
      return solid::deform(bond, network, u, work) && solid::gradient(bond, angle, network, work, by_node);
    };
    if (!evaluate()) state.SkipWithError("a bond or an angle is undefined");  // the first arranges the angles
    for (auto _ : state) benchmark::DoNotOptimize(evaluate());
  });
  state.counters["per_bond"] = each_of(network.bonds.size());
}

void angles_alone(benchmark::State& state, const Body& body) {
  solid::Network network = body.build();
  solid::add_angles(network);
  solid::Workspace work;
  if (!solid::deform(bond::Harmonic{0.26, 1.0}, network, noise(network), work))
    state.SkipWithError("undefined");
  const solid::AngleStars stars = solid::arrange(network.angles, network.bonds.size());
  Positions g = Positions::Zero(work.d.rows(), 3);
  for (auto _ : state) {
    const bool defined =
        solid::add_angle_gradients(stars, work.d.data(), network.bonds.size(), angle_stiffness, g.data());
    benchmark::DoNotOptimize(defined);
  }
  state.counters["per_angle"] = each_of(network.angles.size());
}

}  // namespace

int main(int argc, char** argv) {
  for (const Body& body : bodies) {
    for (const bond::AnyLaw& law : laws()) {
      for (const bool angles : {false, true}) {
        const std::string name = body.name + "/" + bond::name_of(law) + (angles ? "/bonds+angles" : "/bonds");
        benchmark::RegisterBenchmark(name.c_str(), force, body, law, angles)->Unit(benchmark::kMicrosecond);
      }
    }
    benchmark::RegisterBenchmark((body.name + "/angles").c_str(), angles_alone, body)
        ->Unit(benchmark::kMicrosecond);
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
