/// Layers of nodes across z, and what is held of them in a static comparison.
#pragma once

#include <vector>

#include "solid/statics.hpp"

namespace veriflex::drivers::compare {

/// Nodes by layer, from the lowest z.
std::vector<std::vector<Eigen::Index>> layers_of(const solid::Network& network);

void hold(solid::Held& held, const std::vector<Eigen::Index>& nodes, const std::vector<int>& axes);

double sum_over(const Positions& reaction, const std::vector<Eigen::Index>& nodes, int axis);

inline constexpr const char* newton = "statics: Newton with line search, sparse Cholesky";

}  // namespace veriflex::drivers::compare
