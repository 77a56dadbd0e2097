#include "base/work.hpp"

#include <deque>
#include <mutex>

namespace veriflex::work {

namespace {

// Tallies outlive their threads.
std::mutex guard;
std::deque<Tally>& tallies() {
  static std::deque<Tally> all;
  return all;
}

}  // namespace

Tally& new_tally() {
  const std::lock_guard lock(guard);
  return tallies().emplace_back();
}

Counts done() {
  const std::lock_guard lock(guard);
  Counts sum;
  for (const Tally& tally : tallies()) {
    sum.node_updates += tally.node_updates.load(std::memory_order_relaxed);
    sum.bond_evaluations += tally.bond_evaluations.load(std::memory_order_relaxed);
    sum.angle_evaluations += tally.angle_evaluations.load(std::memory_order_relaxed);
  }
  return sum;
}

}  // namespace veriflex::work
