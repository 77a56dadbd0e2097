/// Smoothed delta functions between markers and lattice nodes, by name: the kernels of kernels.cmake.
/// [wu-qi-2014, Eq. 8; peskin-2002]
#pragma once

#include <array>
#include <cmath>
#include <cstdlib>

#include "base/mutant.hpp"
#include "base/named.hpp"
#include "coupling/kernels.hpp"

namespace veriflex::coupling {

enum class Delta {
#define VERIFLEX_EACH(Kernel, id) Kernel,
#include "coupling/each_kernel.inc"
#undef VERIFLEX_EACH
};

inline constexpr std::array deltas{
#define VERIFLEX_EACH(Kernel, id) Named<Delta>{Delta::Kernel, Kernel::name, #id, Kernel::text},
#include "coupling/each_kernel.inc"
#undef VERIFLEX_EACH
};

/// Calls use(kernel) with the type that `delta` stands for.
template <class Use>
auto visit(Delta delta, Use use) {
  switch (delta) {
#define VERIFLEX_EACH(Kernel, id) \
  case Delta::Kernel:             \
    return use(Kernel{});
#include "coupling/each_kernel.inc"
#undef VERIFLEX_EACH
  }
  std::abort();  // there is no other value
}

/// First node of the support of a marker at x, and the weights of the `width` nodes from there.
template <DeltaKernel K>
double support(double x, std::array<double, 4>& weights) {
  static_assert(K::width <= 4);
  const double first =
      K::width % 2 == 0 ? std::floor(x) - (K::width / 2 - 1) : std::round(x) - (K::width - 1) / 2;
  const double shift = planted(Mutant::support_shifted) ? 0.01 : 0.0;
  if constexpr (requires { K::weigh(x, weights); }) {
    K::weigh(x - shift - (first + 1.0), weights);
  } else {
    for (int i = 0; i < K::width; ++i) weights[static_cast<std::size_t>(i)] = K::phi(first + i - x + shift);
  }
  return first;
}

}  // namespace veriflex::coupling
