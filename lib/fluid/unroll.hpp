/// Loops over populations that leave no loop behind.
#pragma once

#include <type_traits>
#include <utility>

#include "fluid/lattice.hpp"

namespace veriflex::fluid {

// All of a row is one function without calls: left to themselves, compilers keep the populations of some of
// the many variants in memory, and drop prefetches as calls that do nothing.
template <class Do, int... Is>
[[gnu::always_inline]] inline void unroll(Do work, std::integer_sequence<int, Is...>) {
  (work(std::integral_constant<int, Is>{}), ...);
}

/// Calls work(q) for q = 0 ... Q - 1, each time with another constant.
template <class Do>
[[gnu::always_inline]] inline void for_each_population(Do work) {
  unroll(work, std::make_integer_sequence<int, Q>{});
}

}  // namespace veriflex::fluid
