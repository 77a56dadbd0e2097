#include "scene/contact.hpp"

#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "base/mutant.hpp"

namespace veriflex::scene {

namespace {

constexpr double farthest_cell = 1e15;  // beyond, neighbouring cells are not told apart

/// Cells of one spacing, by their lowest corner; periodic axes are wrapped.
class Cells {
 public:
  Cells(const Grid& grid, const std::array<bool, 3>& closed) : grid_(grid), closed_(closed) {}

  bool has_place(const Vec3& X) const { return X.cwiseAbs().maxCoeff() < farthest_cell; }

  std::int64_t key(const Vec3& X, std::int64_t dx, std::int64_t dy, std::int64_t dz) const {
    const std::array<std::int64_t, 3> shift{dx, dy, dz};
    std::uint64_t key = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::int64_t at =
          static_cast<std::int64_t>(std::floor(X[static_cast<Eigen::Index>(axis)])) + shift[axis];
      const std::int64_t size = grid_.size[axis];
      if (!closed_[axis]) at = (at % size + size) % size;
      key = key * 2'000'003u + static_cast<std::uint64_t>(at);
    }
    return static_cast<std::int64_t>(key);
  }

  double distance(const Vec3& a, const Vec3& b) const {
    Vec3 d = a - b;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double& along = d[static_cast<Eigen::Index>(axis)];
      if (!closed_[axis] && !planted(Mutant::contact_across_edge_missed))
        along = std::remainder(along, static_cast<double>(grid_.size[axis]));
    }
    return d.norm();
  }

 private:
  const Grid& grid_;
  const std::array<bool, 3>& closed_;
};

}  // namespace

std::optional<Encounter> nearest_within(double distance, const Positions& a, const Positions& b,
                                        const Grid& grid, const std::array<bool, 3>& closed) {
  const Cells cells(grid, closed);
  std::unordered_map<std::int64_t, std::vector<Eigen::Index>> in_cell;
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    const Vec3 X = a.row(i);
    if (cells.has_place(X)) in_cell[cells.key(X, 0, 0, 0)].push_back(i);
  }
  std::optional<Encounter> nearest;
  for (Eigen::Index j = 0; j < b.rows(); ++j) {
    const Vec3 X = b.row(j);
    if (!cells.has_place(X)) continue;
    for (std::int64_t n = 0; n < 27; ++n) {
      const auto found = in_cell.find(cells.key(X, n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
      if (found == in_cell.end()) continue;
      for (const Eigen::Index i : found->second) {
        const double apart = cells.distance(a.row(i), X);
        if (apart < (nearest ? nearest->distance : distance)) nearest = Encounter{i, j, apart};
      }
    }
  }
  return nearest;
}

}  // namespace veriflex::scene
