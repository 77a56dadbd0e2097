/// The hot loop: one fused collide-and-stream sweep over the whole lattice, in place.
///
/// One lattice, structure of arrays, AA pattern [bailey-2009]: an even step leaves each post-collision
/// population in the opposite slot of its own node; an odd step takes it from there, collides, and puts the
/// result where the next even step looks for it. Both are the same row of nodes with other row pointers, and
/// each slot is touched by one node a step, so that threads need not wait for each other.
///
/// A row (along x) holds node x = lane * n + i in lane `lane` of vector i, n = nx/lanes: a shift by one node
/// is the neighbouring vector, and only a row's ends turn the lanes, which is the periodic wrap.
///
/// Half-way walls: what an odd step would take from beyond a wall stands in the same node's slot, and what
/// leaves across it is left there. At the ends of rows that would touch lines which the sweep passes at
/// another time, and so these few populations live in an array of their own.
#pragma once

#include <cstdint>

#include "fluid/collide.hpp"
#include "fluid/scheme.hpp"

namespace veriflex::fluid {

/// Place of a population that comes back from a wall at an end of its row among the row's ten.
constexpr int ends_per_row = 10;
constexpr int end_of_row(int q) { return (q % 2 == 1 ? 0 : 5) + (q <= 2 ? 0 : (q - 5) / 2); }

/// What a sweep works on. Plain data, so that the loops can be compiled for the machine at hand on their own.
template <class Real>
struct Lattice {
  Real* slots[Q];  // one array per population, rows one after the other
  std::int64_t nx, ny, nz;
  Real* ends;  // with walls along x: ends_per_row for each row
  int lanes;   // divides nx
  Collision<Real> law;
  bool forced;  // by a body force, as `scheme` says
  Scheme scheme;
  bool closed[3];  // walls at both ends of an axis

  /// Place of node x in its row.
  std::int64_t place(std::int64_t x) const {
    const std::int64_t n = nx / lanes;
    return x % n * lanes + x / n;
  }
  std::int64_t row(std::int64_t y, std::int64_t z) const { return nx * (y + ny * z); }
};

/// The most lanes that the machine has and nx can be divided into, in two vectors at least.
template <class Real>
int lanes_for(std::int64_t nx);

/// One step of the rows y_begin to y_end - 1 of plane z, by one thread. They may be made in any order in
/// which each comes after the step before of the rows beside it, round the box's edges too.
template <class Real>
using Rows = void (*)(const Lattice<Real>& lattice, std::int64_t z, std::int64_t y_begin, std::int64_t y_end);

/// The loop that is compiled for this lattice and a step of that parity.
template <class Real>
Rows<Real> rows_of(const Lattice<Real>& lattice, bool odd);

/// One step of all nodes. `odd`: the step's parity. Subnormal numbers are taken as zero. Once a stop
/// is asked for it leaves the rest of the planes as they are: the fluid is then of no use.
template <class Real>
void sweep(const Lattice<Real>& lattice, bool odd);

}  // namespace veriflex::fluid
