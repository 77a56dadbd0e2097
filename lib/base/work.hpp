/// How much the hot loops have done: what a run cost in units that no machine changes.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace veriflex::work {

/// Of this process so far, of all its threads.
struct Counts {
  std::uint64_t node_updates = 0;       // one lattice node collided and streamed once
  std::uint64_t bond_evaluations = 0;   // the gradient of one bond
  std::uint64_t angle_evaluations = 0;  // of one angle
};
Counts done();

/// The counts by name, for whoever stores, reads or adds them up.
struct Field {
  const char* name;
  const char* meaning;
  std::uint64_t Counts::*count;
};
inline constexpr std::array fields{
    Field{"node_updates", "lattice nodes collided and streamed, over all steps", &Counts::node_updates},
    Field{"bond_evaluations", "gradients of bonds", &Counts::bond_evaluations},
    Field{"angle_evaluations", "gradients of angles", &Counts::angle_evaluations},
};

/// What one thread has done. Only that thread writes, so that counting costs no more than an addition; the
/// list of all tallies is theirs, so that nothing is allocated.
struct Tally {
  std::atomic<std::uint64_t> node_updates{0}, bond_evaluations{0}, angle_evaluations{0};
  Tally* previous = nullptr;
  Tally* next = nullptr;

  Tally();
  ~Tally();
  Tally(const Tally&) = delete;
  Tally& operator=(const Tally&) = delete;
};

inline Tally& mine() {
  thread_local Tally tally;
  return tally;
}

inline void add(std::atomic<std::uint64_t>& to, std::uint64_t count) {
  to.store(to.load(std::memory_order_relaxed) + count, std::memory_order_relaxed);
}

}  // namespace veriflex::work
