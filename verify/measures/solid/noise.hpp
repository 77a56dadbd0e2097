/// Noise that is the same with any library.
#pragma once

#include <random>

#include "base/vec.hpp"

namespace veriflex::measures {

/// Each coordinate of so many nodes uniform in +- amplitude.
inline Positions noise(Eigen::Index nodes, double amplitude, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Positions all(nodes, 3);
  for (double& value : all.reshaped()) {
    const double uniform = static_cast<double>(random() >> 11) * 0x1p-53;  // in [0, 1)
    value = amplitude * (2.0 * uniform - 1.0);
  }
  return all;
}

}  // namespace veriflex::measures
