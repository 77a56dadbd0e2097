// Young's modulus of a bond law, and a chain of such bonds let go in a fluid.
#include <cstdio>

#include "bond/derive.hpp"
#include "scene/simulation.hpp"

using namespace veriflex;

int main() {
  const bond::AnyLaw law = bond::Harmonic{.bond_stiffness = 0.26, .rest_length = 1.0};
  const bond::Derivation derived = bond::derive(law);
  std::printf("E = %g\n", derived.young_modulus);

  scene::Body chain{.material = {.law = law, .angle_stiffness = 0.0},
                    .network = solid::cubic_lattice({.nodes = {1, 1, 5}, .spacing = derived.rest_length}),
                    .conditions = {.node_mass = 2.0},
                    .place = {8.0, 8.0, 6.0},
                    .coupling = scene::CouplingSpec{}};
  chain.start.displacement = Positions::Zero(5, 3);
  chain.start.displacement(4, 2) = 0.1;
  scene::Simulation simulation(
      {.fluid = fluid::Spec{.grid = {{16, 16, 16}}, .relaxation_time = 1.0}, .bodies = {chain}});
  for (int step = 0; step < 100; ++step) simulation.advance();
  std::printf("end node at z = %.6f after %lld steps, momentum %.1e\n", simulation.body().positions()(4, 2),
              static_cast<long long>(simulation.steps()), simulation.momentum().norm());
  return 0;
}
