#include "solid/bond_kernel.hpp"

#include <algorithm>

namespace veriflex::solid {

namespace {

constexpr std::size_t block_size =
    64;  // bonds whose lengths are tested at a time, while their vectors are in cache

}  // namespace

bool deform_bonds(const Interval& domain, const Bond* bonds, std::size_t count, const double* rest,
                  const double* u, std::size_t nodes, double* d) {
  // Conditions are kept as numbers: combined truth values would keep the loop from becoming vector
  // instructions.
  double inside[block_size];
  std::fill_n(inside, block_size, 1.0);
  for (std::size_t first = 0; first < count; first += block_size) {
    const std::size_t size = std::min(block_size, count - first);
    const Bond* const bond = bonds + first;
    double* const __restrict x = d + first;
    double* const __restrict y = x + count;
    double* const __restrict z = y + count;
    const double* const rest_x = rest + first;
    const double* const rest_y = rest_x + count;
    const double* const rest_z = rest_y + count;
    const double* const u_y = u + nodes;
    const double* const u_z = u_y + nodes;
    for (std::size_t i = 0; i < size; ++i) {
      const std::int32_t p = bond[i].first;
      const std::int32_t q = bond[i].second;
      x[i] = rest_x[i] + (u[q] - u[p]);
      y[i] = rest_y[i] + (u_y[q] - u_y[p]);
      z[i] = rest_z[i] + (u_z[q] - u_z[p]);
    }
    for (std::size_t i = 0; i < size; ++i) {
      const double r = std::sqrt(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
      const double above = r > domain.lo ? inside[i] : 0.0;
      inside[i] = r < domain.hi ? above : 0.0;
    }
  }
  return planted(Mutant::domain_not_asked) || *std::min_element(inside, inside + block_size) == 1.0;
}

void hand_to_nodes(const Bond* bonds, std::size_t count, const double* g, std::size_t nodes,
                   double* by_node) {
  double* const x = by_node;
  double* const y = x + nodes;
  double* const z = y + nodes;
  for (std::size_t b = 0; b < count;) {
    // In a lattice the bonds of a first node follow each other: it is written once for all of them.
    const std::int32_t p = bonds[b].first;
    double sum_x = 0.0, sum_y = 0.0, sum_z = 0.0;
    do {
      const std::int32_t q = bonds[b].second;
      const double gx = g[b];
      const double gy = g[b + count];
      const double gz = g[b + 2 * count];
      x[q] += gx;
      y[q] += gy;
      z[q] += gz;
      sum_x += gx;
      sum_y += gy;
      sum_z += gz;
      ++b;
    } while (b < count && bonds[b].first == p);
    x[p] -= sum_x;
    y[p] -= sum_y;
    z[p] -= planted(Mutant::bond_reaction_missing) ? 0.0 : sum_z;
  }
}

#define VERIFLEX_LAW(Law) template void bond_gradients(const bond::Law&, const double*, std::size_t, double*);
#include "base/mutant.hpp"
#include "bond/each_law.inc"
#undef VERIFLEX_LAW

}  // namespace veriflex::solid
