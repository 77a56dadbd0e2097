/// The loops over the bonds of a network, compiled for the machine's own vector instructions.
///
/// Arrays of vectors are three columns (x, y, z). This header and its source know no Eigen: types whose
/// layout depends on the instruction set must not cross.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "bond/laws.hpp"

namespace veriflex::solid {

/// A bond between two nodes.
struct Bond {
  std::int32_t first, second;
};

/// Deformed vector of each bond, d = rest + u(second) - u(first). Returns whether every length is inside
/// `domain` (false for NaN).
[[nodiscard]] bool deform_bonds(const Interval& domain, const Bond* bonds, std::size_t count,
                                const double* rest, const double* u, std::size_t nodes, double* d);

/// Gradient g of the bonds' energy by their vectors d: the tension along each.
template <bond::BondLaw Law>
void bond_gradients(const Law& law, const double* __restrict d, std::size_t count, double* __restrict g) {
  const double* const __restrict x = d;
  const double* const __restrict y = d + count;
  const double* const __restrict z = d + 2 * count;
  double* const __restrict gx = g;
  double* const __restrict gy = g + count;
  double* const __restrict gz = g + 2 * count;
  for (std::size_t b = 0; b < count; ++b) {
    const double r = std::sqrt(x[b] * x[b] + y[b] * y[b] + z[b] * z[b]);
    const double pull = law.tension(r) / r;
    gx[b] = pull * x[b];
    gy[b] = pull * y[b];
    gz[b] = pull * z[b];
  }
}

// Compiled once for each law of the list; a law that is not in it is compiled where it is used.
#define VERIFLEX_LAW(Law) \
  extern template void bond_gradients(const bond::Law&, const double*, std::size_t, double*);
#include "bond/each_law.inc"
#undef VERIFLEX_LAW

/// Adds each bond's gradient to its second node and takes it from its first, in the order of the bonds.
void hand_to_nodes(const Bond* bonds, std::size_t count, const double* g, std::size_t nodes, double* by_node);

}  // namespace veriflex::solid
