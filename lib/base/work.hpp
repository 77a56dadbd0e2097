/// How much the hot loops have done: what a run cost in units that no machine changes.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "base/mutant.hpp"

namespace veriflex::work {

/// Of this process so far, of all its threads.
struct Counts {
  std::uint64_t node_updates = 0;           // one lattice node collided and streamed once
  std::uint64_t bond_evaluations = 0;       // the gradient of one bond
  std::uint64_t angle_evaluations = 0;      // of one angle
  std::uint64_t marker_interpolations = 0;  // velocity at one marker out of the nodes around it
  std::uint64_t bytes_moved = 0;            // what these read and write at least
};
Counts done();

/// What one thread has done. Only that thread writes, so that counting costs no more than an addition.
struct Tally {
  std::atomic<std::uint64_t> node_updates{0}, bond_evaluations{0}, angle_evaluations{0},
      marker_interpolations{0}, bytes_moved{0};
  Tally* next = nullptr;
};

/// A tally in the list of all, where it stays when its thread has ended: a thread that had to give it up at
/// its end would need memory for that at its start, and glibc aborts without. Throws std::bad_alloc.
Tally* new_tally();

/// The counts by name, for whoever stores, reads or adds them up.
struct Field {
  const char* name;
  const char* meaning;
  std::uint64_t Counts::*count;
  std::atomic<std::uint64_t> Tally::*tally;
};
inline constexpr std::array fields{
    Field{"node_updates", "lattice nodes collided and streamed, over all steps", &Counts::node_updates,
          &Tally::node_updates},
    Field{"bond_evaluations", "gradients of bonds", &Counts::bond_evaluations, &Tally::bond_evaluations},
    Field{"angle_evaluations", "gradients of angles", &Counts::angle_evaluations, &Tally::angle_evaluations},
    Field{"marker_interpolations", "velocities interpolated at markers; as many forces are spread",
          &Counts::marker_interpolations, &Tally::marker_interpolations},
    Field{"bytes_moved", "least traffic of these: a node's state in and out, positions in and gradients out",
          &Counts::bytes_moved, &Tally::bytes_moved},
};

inline Tally& mine() {
  thread_local Tally* tally = nullptr;
  if (tally == nullptr) tally = new_tally();
  return *tally;
}

inline void add(std::atomic<std::uint64_t>& to, std::uint64_t count) {
  to.store(to.load(std::memory_order_relaxed) + count, std::memory_order_relaxed);
}

/// So many of each, as they are done. A position and a gradient are 24 bytes, a bond has two, an angle three.
inline void add_nodes(std::uint64_t count, std::uint64_t bytes_each) {
  add(mine().node_updates, count);
  add(mine().bytes_moved, count * bytes_each);
}
inline void add_bonds(std::uint64_t count) {
  add(mine().bond_evaluations, count);
  add(mine().bytes_moved, count * 96);
}
inline void add_angles(std::uint64_t count) {
  add(mine().angle_evaluations, planted(Mutant::angles_not_counted) ? 0 : count);
  add(mine().bytes_moved, count * 144);
}

inline void add_markers(std::uint64_t count) { add(mine().marker_interpolations, count); }

}  // namespace veriflex::work
