/// The hot loop at tau = 1: density and momentum of every node, from one copy of the box into another.
///
/// What leaves a node is computed once (moments.hpp). It is added up where it is on its way to, in three
/// stages that keep little: along x a vector of nodes waits in registers for its neighbours, the sums of two
/// rows wait in the first-level cache for the next row, and those of two planes in the second-level cache for
/// the next plane. Of a diagonal (c_y, c_z) only the sum and the difference of its two populations
/// travel, and of all that goes to the next plane three sums, for its c_z is everywhere the same.
///
/// A thread takes planes of its own, in tiles of rows whose sums fit its second-level cache, and computes
/// what leaves the rows and planes around a tile as well, so that threads need not wait for each other. Every
/// sum is made in the same order whatever the tiles.
///
/// Rows are divided into lanes as in sweep.hpp. The four moments of a vector stand one after the other, so
/// that a box is one stream that is read and one that is written.
///
/// Half-way walls: what would leave across a wall is added to its own node's sums as what comes back.
#pragma once

#include <cstdint>

#include "fluid/moments.hpp"
#include "fluid/scheme.hpp"

namespace veriflex::fluid {

/// What a sweep works on. Plain data, as Lattice.
template <class Real>
struct MomentLattice {
  const Real* from;  // M of all nodes
  Real* to;
  std::int64_t nx, ny, nz;
  int lanes;  // divides nx
  MomentForce<Real> law;
  bool forced;
  Scheme scheme;
  bool closed[3];  // walls at both ends of an axis
  bool streams;    // what is written is not read again before it has left the caches
  Real* scratch;   // scratch_size numbers for each thread, at a cache line's start

  /// Place of moment 0 of a node in from and to; moment k stands k * lanes further.
  std::int64_t place(std::int64_t x, std::int64_t row) const {
    const std::int64_t n = nx / lanes;
    return 4 * (nx * row + x % n * lanes) + x / n;
  }
};

/// Numbers that a thread needs beside the lattice; a multiple of 64.
template <class Real>
std::int64_t scratch_size(std::int64_t nx, std::int64_t ny);

/// One step of all nodes. Subnormal numbers are taken as zero. Once a stop is asked for it leaves the rest of
/// the planes as they are: what it has written is then of no use.
template <class Real>
void sweep(const MomentLattice<Real>& lattice);

/// The populations that leave a node of moments M.
template <class Real>
void leave_node(const MomentLattice<Real>& lattice, const Real (&M)[4], Real (&H)[Q]);

}  // namespace veriflex::fluid
