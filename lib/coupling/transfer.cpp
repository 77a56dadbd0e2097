#include "coupling/transfer.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <algorithm>
#include <cassert>

#include "base/error.hpp"
#include "base/mutant.hpp"

namespace veriflex::coupling {

namespace {

/// Floor division's remainder: into the box from anywhere.
std::int64_t into(std::int64_t at, std::int64_t size) {
  const std::int64_t rest = at % size;
  return rest < 0 ? rest + size : rest;
}

/// The same of what a support reaches beyond a box that it begins in, without a division.
std::int64_t back(std::int64_t at, std::int64_t size) {
  while (at >= size) at -= size;  // more than once only in a box below the support's width
  return at;
}

/// So many markers share their work among threads.
constexpr std::size_t worth_threads = 5000;

constexpr double farthest = 1e15;  // beyond, neighbouring nodes are not told apart

}  // namespace

Transfer::Transfer(const Grid& grid, std::array<bool, 3> closed, Delta delta,
                   std::span<const std::int64_t> solid)
    : grid_(grid),
      closed_(closed),
      delta_(delta),
      row_at_(static_cast<std::size_t>(grid.size[1] * grid.size[2]), -1),
      part_(parts::Kind::Coupling, 0.0) {
  if (!solid.empty()) solid_.assign(static_cast<std::size_t>(grid.count()), false);
  for (const std::int64_t node : solid) solid_[static_cast<std::size_t>(node)] = true;
}

bool Transfer::is_solid(std::int64_t x, std::int64_t y, std::int64_t z) const {
  return solid_[static_cast<std::size_t>(
      grid_.index(into(x, grid_.size[0]), into(y, grid_.size[1]), into(z, grid_.size[2])))];
}

void Transfer::locate(const Positions& X) {
  visit(delta_, [&](auto kernel) { locate_with<decltype(kernel)>(X); });
  part_.takes(bytes());
}

std::vector<std::int64_t> Transfer::rows() const {
  std::vector<std::int64_t> numbers;
  for (const Row& row : rows_) numbers.push_back(row.start / grid_.size[0]);
  return numbers;
}

double Transfer::bytes() const {
  return parts::array_bytes(solid_, nodes_, weight_, rows_, place_, row_at_, row_of_, place_of_slot_);
}

template <DeltaKernel K>
void Transfer::locate_with(const Positions& X) {
  constexpr auto width = static_cast<std::size_t>(K::width);
  const auto markers = static_cast<std::size_t>(X.rows());
  struct Support {
    std::array<std::int64_t, 3> first;
    std::array<std::array<double, 4>, 3> weights;
  };
  for (std::size_t m = 0; m < markers; ++m) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double x = X(static_cast<Eigen::Index>(m), static_cast<Eigen::Index>(axis));
      if (std::abs(x) < farthest) continue;
      throw NumericalFailure(
          fmt::format("marker {} is at {} = {}, which is no place in the box", m, "xyz"[axis], x),
          FailureMode::Marker);
    }
  }
  std::vector<Support> supports(markers);
#pragma omp parallel for schedule(static) if (markers >= worth_threads)
  for (std::size_t m = 0; m < markers; ++m) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double x = X(static_cast<Eigen::Index>(m), static_cast<Eigen::Index>(axis));
      supports[m].first[axis] = static_cast<std::int64_t>(support<K>(x, supports[m].weights[axis]));
    }
  }
  for (std::size_t m = 0; m < markers; ++m) {
    Support& s = supports[m];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (closed_[axis]) {
        const double x = X(static_cast<Eigen::Index>(m), static_cast<Eigen::Index>(axis));
        for (std::size_t i = 0; i < width; ++i) {
          const std::int64_t node = s.first[axis] + static_cast<std::int64_t>(i);
          if (s.weights[axis][i] == 0.0 || (node >= 0 && node < grid_.size[axis])) continue;
          throw NumericalFailure(fmt::format("marker {} is at {} = {}: its support reaches node {}, beyond "
                                             "the walled box of nodes 0 to {}",
                                             m, "xyz"[axis], x, node, grid_.size[axis] - 1),
                                 FailureMode::Marker);
        }
      }
      s.first[axis] = into(s.first[axis], grid_.size[axis]);
    }
    if (solid_.empty()) continue;
    for (std::size_t n = 0; n < width * width * width; ++n) {
      const std::size_t l = n % width, j = n / width % width, k = n / (width * width);
      if (s.weights[0][l] * s.weights[1][j] * s.weights[2][k] == 0.0) continue;
      const std::int64_t x = s.first[0] + static_cast<std::int64_t>(l);
      const std::int64_t y = s.first[1] + static_cast<std::int64_t>(j);
      const std::int64_t z = s.first[2] + static_cast<std::int64_t>(k);
      if (!is_solid(x, y, z)) continue;
      const auto row = static_cast<Eigen::Index>(m);
      throw NumericalFailure(
          fmt::format("marker {} is at ({}, {}, {}): its support contains node ({}, {}, {}) of the obstacle",
                      m, X(row, 0), X(row, 1), X(row, 2), into(x, grid_.size[0]), into(y, grid_.size[1]),
                      into(z, grid_.size[2])),
          FailureMode::Marker);
    }
  }

  // Which rows, and which part of each.
  for (const Row& row : rows_) row_at_[static_cast<std::size_t>(row.start / grid_.size[0])] = -1;
  rows_.clear();
  row_of_.resize(markers * width * width);
  for (std::size_t m = 0, i = 0; m < markers; ++m) {
    const auto& first = supports[m].first;
    const std::int64_t last = first[0] + static_cast<std::int64_t>(width) - 1;
    for (std::size_t k = 0; k < width; ++k) {
      const std::int64_t z = back(first[2] + static_cast<std::int64_t>(k), grid_.size[2]);
      for (std::size_t j = 0; j < width; ++j, ++i) {
        const std::int64_t y = back(first[1] + static_cast<std::int64_t>(j), grid_.size[1]);
        std::int32_t& number = row_at_[static_cast<std::size_t>(y + grid_.size[1] * z)];
        if (number < 0) {
          number = static_cast<std::int32_t>(rows_.size());
          rows_.push_back({grid_.index(0, y, z), first[0], last, 0});
        }
        Row& row = rows_[static_cast<std::size_t>(number)];
        row.from = std::min(row.from, first[0]);
        row.to = std::max(row.to, last);
        row_of_[i] = number;
      }
    }
  }
  std::int64_t slot_count = 0;
  for (Row& row : rows_) {
    row.offset = slot_count;
    slot_count += std::min(row.to - row.from + 1, grid_.size[0]);
  }

  // The distinct nodes in the order in which markers meet them, and for each marker their places and weights.
  place_of_slot_.assign(static_cast<std::size_t>(slot_count), -1);
  nodes_.clear();
  place_.resize(markers * width * width * width);
  weight_.resize(place_.size());
  const std::int64_t nx = grid_.size[0];
  for (std::size_t m = 0, i = 0, n = 0; m < markers; ++m) {
    const Support& s = supports[m];
    for (std::size_t k = 0; k < width; ++k) {
      for (std::size_t j = 0; j < width; ++j, ++i) {
        const Row& row = rows_[static_cast<std::size_t>(row_of_[i])];
        const double weight_yz = s.weights[1][j] * s.weights[2][k];
        std::int32_t* const slots = place_of_slot_.data() + row.offset;
        std::int64_t slot = s.first[0] - row.from;
        for (std::size_t l = 0; l < width; ++l, ++n, ++slot) {
          slot = back(slot, nx);
          std::int32_t& place = slots[slot];
          if (place < 0) {
            place = static_cast<std::int32_t>(nodes_.size());
            nodes_.push_back(row.start + back(s.first[0] + static_cast<std::int64_t>(l), nx));
          }
          place_[n] = place;
          weight_[n] = s.weights[0][l] * weight_yz;
          if constexpr (K::in_ball) {
            const Vec3 from_marker =
                Vec3(static_cast<double>(l), static_cast<double>(j), static_cast<double>(k)) -
                (Vec3(X.row(static_cast<Eigen::Index>(m))).array() -
                 Vec3(X.row(static_cast<Eigen::Index>(m))).array().floor() + 1.0)
                    .matrix();
            if (from_marker.squaredNorm() >= (planted(Mutant::ball_not_cut) ? 100.0 : 4.0)) weight_[n] = 0.0;
          }
        }
      }
    }
  }
}

void Transfer::interpolate(const Positions& at_nodes, Positions& at_markers) const {
  const auto markers = static_cast<std::int64_t>(row_of_.size()) / (width() * width());
  const std::int64_t support = width() * width() * width();
  assert(at_nodes.rows() == std::ssize(nodes_));
  at_markers.resize(markers, 3);
#pragma omp parallel for schedule(static) if (static_cast <std::size_t>(markers) >= worth_threads)
  for (std::int64_t m = 0; m < markers; ++m) {
    double sum[3] = {0.0, 0.0, 0.0};
    for (std::int64_t n = m * support;
         n < (m + 1) * support - (planted(Mutant::last_node_not_interpolated) ? 1 : 0); ++n) {
      const auto place = static_cast<Eigen::Index>(place_[static_cast<std::size_t>(n)]);
      const double weight = weight_[static_cast<std::size_t>(n)];
      for (int axis = 0; axis < 3; ++axis) sum[axis] += weight * at_nodes(place, axis);
    }
    for (int axis = 0; axis < 3; ++axis) at_markers(m, axis) = sum[axis];
  }
}

void Transfer::spread(const Positions& at_markers, Positions& at_nodes) const {
  const std::int64_t support = width() * width() * width();
  const auto nodes = static_cast<std::int64_t>(nodes_.size());
  assert(at_markers.rows() * support == std::ssize(place_));
  at_nodes.setZero(nodes, 3);
  const bool alone = static_cast<std::size_t>(at_markers.rows()) < worth_threads;
  const std::int64_t parts = alone ? 1 : omp_get_max_threads();
  // Each thread has nodes of its own, and adds up markers in their order, however many threads there are.
#pragma omp parallel for schedule(static) num_threads(static_cast <int>(parts)) if (parts > 1)
  for (std::int64_t part = 0; part < parts; ++part) {
    const std::int64_t begin = nodes * part / parts, end = nodes * (part + 1) / parts;
    for (std::int64_t m = 0; m < at_markers.rows(); ++m) {
      const double force[3] = {at_markers(m, 0), at_markers(m, 1), at_markers(m, 2)};
      for (std::int64_t n = m * support; n < (m + 1) * support; ++n) {
        const auto place = static_cast<Eigen::Index>(place_[static_cast<std::size_t>(n)]);
        if (place < begin || place >= end) continue;
        const double weight = planted(Mutant::spread_evenly) ? 1.0 / static_cast<double>(support)
                                                             : weight_[static_cast<std::size_t>(n)];
        for (int axis = 0; axis < 3; ++axis) at_nodes(place, axis) += weight * force[axis];
      }
    }
  }
}

std::int64_t Transfer::width() const {
  return visit(delta_, [](auto kernel) -> std::int64_t { return decltype(kernel)::width; });
}

void add_further_rounds(const Transfer& transfer, const Positions& slip, double marker_volume,
                        int forcing_iterations, Positions& to) {
  if (forcing_iterations == 1) return;
  Positions missing = slip, given, answered;
  for (int round = 1; round < forcing_iterations; ++round) {
    transfer.spread((planted(Mutant::rounds_ignore_volume) ? 1.0 : marker_volume) * missing, given);
    transfer.interpolate(given, answered);
    missing -= answered;
    to += missing;
  }
}

}  // namespace veriflex::coupling
