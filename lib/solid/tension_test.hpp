/// A block pulled along its axis: both end sections held axially, or one held and the other loaded.
#pragma once

#include "bond/laws.hpp"
#include "solid/network.hpp"
#include "solid/relax.hpp"

namespace veriflex::solid {

struct Pulled {
  double strain;    // mean change of length over the length                        [1]
  double stress;    // force on the loaded section over n m r0^2, positive in tension [M L^-1 T^-2]
  int iterations;   // see relax()
  double residual;  // see Equilibrium
};

/// A block whose ends move apart (or together) to a given strain. With `lateral_held` the coordinates across
/// the axis stay, otherwise only the rigid motions are removed. Throws NumericalFailure, see relax().
Pulled pull_to_strain(const bond::AnyLaw& law, const Block& block, bool lateral_held, double strain,
                      const Statics& how = {});

/// A block under a dead load on its last section, which is free to move. As above.
Pulled pull_with_stress(const bond::AnyLaw& law, const Block& block, bool lateral_held, double stress,
                        const Statics& how = {});

}  // namespace veriflex::solid
