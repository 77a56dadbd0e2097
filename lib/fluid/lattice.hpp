/// The D3Q15 lattice: velocities, weights, and the moments that make it a fluid.
/// [wu-qi-2014, Eqs. 3-4]
///
/// Opposite velocities stand side by side: 2k + 1 and 2k + 2 for k = 0 .. 6; the first of a pair has c_x > 0,
/// or is along +y or +z.
#pragma once

#include <array>

namespace veriflex::fluid {

constexpr int Q = 15;

constexpr std::array<std::array<int, 3>, Q> c{{{0, 0, 0},
                                               {1, 0, 0},
                                               {-1, 0, 0},
                                               {0, 1, 0},
                                               {0, -1, 0},
                                               {0, 0, 1},
                                               {0, 0, -1},
                                               {1, 1, 1},
                                               {-1, -1, -1},
                                               {1, 1, -1},
                                               {-1, -1, 1},
                                               {1, -1, 1},
                                               {-1, 1, -1},
                                               {1, -1, -1},
                                               {-1, 1, 1}}};

/// Weights in seventy-seconds, so that sums below are exact.
constexpr std::array<int, Q> w72{16, 8, 8, 8, 8, 8, 8, 1, 1, 1, 1, 1, 1, 1, 1};

constexpr double w(int q) { return w72[static_cast<std::size_t>(q)] / 72.0; }

constexpr double sound_speed_squared = 1.0 / 3.0;

constexpr int opposite(int q) { return q == 0 ? 0 : q % 2 == 1 ? q + 1 : q - 1; }

/// nu = (tau - 1/2)/3  [L^2 T^-1]
constexpr double viscosity(double relaxation_time) { return (relaxation_time - 0.5) / 3.0; }

namespace moments {

/// 72 times the sum of w c_i c_j ... over the axes given; an axis of -1 stands for no factor.
constexpr int sum72(int i, int j = -1, int k = -1, int l = -1) {
  int sum = 0;
  for (std::size_t q = 0; q < Q; ++q) {
    int term = w72[q];
    for (const int axis : {i, j, k, l}) {
      if (axis >= 0) term *= c[q][static_cast<std::size_t>(axis)];
    }
    sum += term;
  }
  return sum;
}

constexpr bool isotropic_to_fourth_order() {
  const auto same = [](int a, int b) { return a == b ? 1 : 0; };
  for (int i = 0; i < 3; ++i) {
    if (sum72(i) != 0) return false;
    for (int j = 0; j < 3; ++j) {
      if (sum72(i, j) != 24 * same(i, j)) return false;  // c_s^2 = 1/3
      for (int k = 0; k < 3; ++k) {
        if (sum72(i, j, k) != 0) return false;
        for (int l = 0; l < 3; ++l) {  // c_s^4 = 1/9
          const int isotropic = same(i, j) * same(k, l) + same(i, k) * same(j, l) + same(i, l) * same(j, k);
          if (sum72(i, j, k, l) != 8 * isotropic) return false;
        }
      }
    }
  }
  return sum72(-1) == 72;
}

constexpr bool opposites_are_opposite() {
  for (int q = 0; q < Q; ++q) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (c[static_cast<std::size_t>(q)][axis] != -c[static_cast<std::size_t>(opposite(q))][axis])
        return false;
    }
  }
  return true;
}

}  // namespace moments

static_assert(moments::isotropic_to_fourth_order());
static_assert(moments::opposites_are_opposite());

}  // namespace veriflex::fluid
