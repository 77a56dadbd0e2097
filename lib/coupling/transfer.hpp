/// Exchange between markers and the lattice: interpolation of velocities and spreading of forces.
/// [wu-qi-2014, Eqs. 9, 11]
///
///   u(X) = sum_x u(x) D(x - X),   g(x) = sum_X F D(x - X)
///
/// with the same weights, so that the one is the adjoint of the other and what the markers gain the lattice
/// loses. Only the nodes under the supports are touched, each once, whatever the number of markers that share
/// it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/grid.hpp"
#include "base/parts.hpp"
#include "base/vec.hpp"
#include "coupling/delta.hpp"

namespace veriflex::coupling {

class Transfer {
 public:
  /// `closed`: axes with walls, which no support may reach across; the others are periodic. `solid`: nodes
  /// without fluid, which no support may contain.
  Transfer(const Grid& grid, std::array<bool, 3> closed, Delta delta,
           std::span<const std::int64_t> solid = {});

  /// Supports and weights of markers at X, one row each, in node coordinates of the box. A marker may be any
  /// number of box lengths away along a periodic axis. Throws NumericalFailure, which names the marker, when
  /// its position is not a number, or a node where it has a weight lies beyond a wall or is solid; the
  /// supports are then those of the call before.
  void locate(const Positions& X);

  /// The distinct nodes under the supports.
  std::span<const std::int64_t> nodes() const { return nodes_; }

  /// The rows that these stand in, y + ny z of each once.
  std::vector<std::int64_t> rows() const;

  /// Memory of supports, weights and the lists between  [bytes].
  double bytes() const;

  /// `at_nodes`: one row per nodes(); result: one row per marker.
  void interpolate(const Positions& at_nodes, Positions& at_markers) const;

  /// Adjoint of interpolate(): one row per nodes() out of one per marker.
  void spread(const Positions& at_markers, Positions& at_nodes) const;

 private:
  template <DeltaKernel K>
  void locate_with(const Positions& X);
  std::int64_t width() const;
  bool is_solid(std::int64_t x, std::int64_t y, std::int64_t z) const;

  Grid grid_;
  std::array<bool, 3> closed_;
  Delta delta_;
  std::vector<bool> solid_;  // per node of the box; empty where all is fluid
  std::vector<std::int64_t> nodes_;
  // Per marker and node of its support: place in nodes(), and weight.
  std::vector<std::int32_t> place_;
  std::vector<double> weight_;

  struct Row {
    std::int64_t start;     // first node of the row in the box
    std::int64_t from, to;  // touched x; `to` may lie beyond the box
    std::int64_t offset;    // of `from` in place_of_slot_
  };
  std::vector<std::int32_t> row_at_;  // per row (y, z) of the box: its number among rows_, or -1
  std::vector<Row> rows_;
  std::vector<std::int32_t> row_of_;         // per marker and row of its support
  std::vector<std::int32_t> place_of_slot_;  // per touched x of a row: place in nodes(), or -1
  parts::Built part_;
};

/// What the iterations of multi-direct forcing after the first ask for, added to `to`, one row per marker:
/// each finds the slip that the force so far, V times the slips before, leaves in a fluid at rest.
void add_further_rounds(const Transfer& transfer, const Positions& slip, double marker_volume,
                        int forcing_iterations, Positions& to);

}  // namespace veriflex::coupling
