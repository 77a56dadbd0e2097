/// Forces of several bodies at the nodes of one lattice, where those that share a node add up.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/parts.hpp"
#include "base/vec.hpp"

namespace veriflex::coupling {

class SummedForces {
 public:
  void clear();

  /// `nodes` holds each node once; `force` has one row for each of them.
  void add(std::span<const std::int64_t> nodes, const Positions& force);

  /// Puts what was added together. Of two bodies it does not matter which was added first; sums of more are
  /// made in the order in which they were added.
  void sum();

  /// Each node once, in rising order, and the force on it.
  std::span<const std::int64_t> nodes() const { return nodes_; }
  const Positions& force() const { return force_; }

 private:
  struct Share {
    std::int64_t node;
    std::size_t order;
    Vec3 force;
  };
  std::vector<Share> shares_;
  std::vector<std::int64_t> nodes_;
  Positions force_;
  parts::Built part_{parts::Kind::Sum, 0.0};
};

}  // namespace veriflex::coupling
