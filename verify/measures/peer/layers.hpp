/// Layers of nodes across z, and what is held of them in a static comparison.
#pragma once

#include <vector>

#include "io/document.hpp"
#include "solid/statics.hpp"

namespace veriflex::measures::peer {

/// Nodes by layer, from the lowest z.
std::vector<std::vector<Eigen::Index>> layers_of(const solid::Network& network);

/// Throws InputError at the case's `data` where a static comparison has no answer: all nodes in one layer,
/// layers so close that they differ by rounding, nodes that nothing ties to the layers that are held. `held`
/// of them from the lowest are; the last one too when `last_held`.
void require_statics(const solid::Network& network, std::size_t held, bool last_held, const io::Table& peer);

void hold(solid::FixedDofs& held, const std::vector<Eigen::Index>& nodes, const std::vector<int>& axes);

double sum_over(const Positions& reaction, const std::vector<Eigen::Index>& nodes, int axis);

inline constexpr const char* of_all_states =
    "largest out-of-balance force over the largest tension, all states";
inline constexpr const char* newton = "statics: Newton with line search, sparse Cholesky";

}  // namespace veriflex::measures::peer
