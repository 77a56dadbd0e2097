#include "solid/angle_kernel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/mutant.hpp"

namespace veriflex::solid {

namespace {

// Stars worked on at a time: their arms and gradients, 54 arrays of 256 bytes, stay in the first-level cache.
constexpr std::size_t block_size = 32;

using Lane = double[block_size];

struct Arm {
  Lane x, y, z;
  Lane squared, inverse;  // r^2 and 1/r^2
};

// Gradient by an arm. Its part along the arm stands apart, so that the arm enters once, not once per angle.
struct Gradient {
  Lane x, y, z;
  Lane along;  // times the arm over its squared length
};

struct alignas(64) Block {
  Arm arms[AngleStars::max_arms];
  Gradient gradients[AngleStars::max_arms];
  Lane strayed;  // 1 where an angle of the star is far from rest, else 0
};

// An angle is near its rest value up to 30 degrees: tan^2 of the deviation below 1/3.
constexpr double near_rest = 1.0 / 3.0;

// atan(x)/x = 1 + y p(y) with y = x^2 on [0, 1/3]: Chebyshev interpolation, error 7e-18 before rounding.
constexpr std::array arc_tangent{
    1.0,
    -0.3333333333333333,
    0.1999999999999917,
    -0.14285714285551976,
    0.11111111098553819,
    -0.0909090858207502,
    0.07692295286793505,
    -0.06666469623891029,
    0.05880212512340686,
    -0.05246779832347255,
    0.046721786047603464,
    -0.039937323927724346,
    0.029952661529252887,
    -0.016659167405869497,
    0.004874352567045785,
};

// Horner's scheme over every second coefficient, from the last one back to `first`. Without a loop: one
// inside keeps the compiler from vectorising the one outside.
template <std::size_t first, std::size_t... I>
inline double horner(double y2, std::index_sequence<I...>) {
  constexpr std::size_t last = first + 2 * sizeof...(I);
  double sum = arc_tangent[last];
  ((sum = sum * y2 + arc_tangent[last - 2 - 2 * I]), ...);
  return sum;
}

// Even and odd powers apart: two chains of dependent operations of half the length.
inline double arc_tangent_over_x(double y) {
  constexpr std::size_t half = (arc_tangent.size() - 1) / 2;
  static_assert(arc_tangent.size() == 2 * half + 1);
  const double even = horner<0>(y * y, std::make_index_sequence<half>{});
  const double odd = horner<1>(y * y, std::make_index_sequence<half - 1>{});
  return planted(Mutant::angle_taken_as_tangent) ? 1.0 : even + y * odd;
}

// a d - b c by Kahan's scheme, see angle.hpp.
inline double difference_of_products(double a, double d, double b, double c) {
  const double bc = b * c;
  return std::fma(a, d, -bc) + std::fma(-b, c, bc);
}

struct Vector {
  double x, y, z;
};

inline double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

inline Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline Vector precise_cross(const Vector& a, const Vector& b) {
  return {difference_of_products(a.y, b.z, a.z, b.y), difference_of_products(a.z, b.x, a.x, b.z),
          difference_of_products(a.x, b.y, a.y, b.x)};
}

inline Vector scaled(double f, const Vector& a) { return {f * a.x, f * a.y, f * a.z}; }

// Gradient by both arms, and tan^2 of the deviation (NaN where the angle is undefined).
struct Bend {
  Vector by_a, by_b;
  double along;  // as in Gradient, the same for both
  double tan2;
};

// Inlined whatever the compiler thinks of it: a call would keep the loop over stars from becoming vector
// instructions.
//
// Both need no square root: with s = |a x b| and c = a.b, the deviation over s is q/c for a straight and
// -c q/s^2 for a right angle, q = atan(x)/x at the deviation's tangent x, of which only the square enters.
[[gnu::always_inline]] inline Bend bend_straight(const Vector& a, const Vector& b, double inverse_a,
                                                 double inverse_b, double stiffness) {
  const Vector w = precise_cross(a, b);
  const double c = dot(a, b);
  const double inverse = 1.0 / c;
  const double tan2 = dot(w, w) * inverse * inverse;
  const double rho = stiffness * inverse * arc_tangent_over_x(tan2);
  return {scaled(rho * inverse_a, cross(a, w)), scaled(-rho * inverse_b, cross(b, w)), 0.0,
          c < 0.0 ? tan2 : 1.0};
}

// Here a x b itself is not needed: s^2 = a^2 b^2 - c^2 and a x (a x b) = c a - a^2 b do not cancel.
[[gnu::always_inline]] inline Bend bend_right(const Vector& a, const Vector& b, double a2, double b2,
                                              double stiffness) {
  const double c = dot(a, b);
  const double slope = c * (1.0 / (a2 * b2 - c * c));
  const double tan2 = c * slope;
  const double rho = -stiffness * slope * arc_tangent_over_x(tan2);
  return {scaled(-rho, b), scaled(-rho, a), rho * c, tan2};
}

// Gradient of any angle, as in angle.hpp. `tan2` is NaN where there is none.
Bend bend_anywhere(const Vector& a, const Vector& b, bool straight, double stiffness) {
  const Vector w = precise_cross(a, b);
  const double s = std::sqrt(dot(w, w));
  const double c = dot(a, b);
  const double a2 = dot(a, a);
  const double b2 = dot(b, b);
  const bool defined = (straight && c < 0.0) || c * c < (1.0 - 1e-12) * a2 * b2;
  const double rho = stiffness * (straight ? -std::atan2(s, -c) : -std::atan2(c, s)) / s;
  return {scaled(rho / a2, cross(a, w)), scaled(-rho / b2, cross(b, w)), 0.0, defined ? 1.0 : std::nan("")};
}

[[gnu::always_inline]] inline Bend bend(const Arm& a, const Arm& b, bool straight, double stiffness,
                                        std::size_t i) {
  const Vector va{a.x[i], a.y[i], a.z[i]};
  const Vector vb{b.x[i], b.y[i], b.z[i]};
  return straight ? bend_straight(va, vb, a.inverse[i], b.inverse[i], stiffness)
                  : bend_right(va, vb, a.squared[i], b.squared[i], stiffness);
}

inline void add(Gradient& gradient, const Vector& v, std::size_t i) {
  gradient.x[i] += v.x;
  gradient.y[i] += v.y;
  gradient.z[i] += v.z;
}

// One pair of arms in all stars of the block. No branch: the loop becomes vector instructions.
template <bool straight>
void bend_all(const Arm& __restrict a, const Arm& __restrict b, double stiffness, std::size_t lanes,
              Gradient& __restrict by_a, Gradient& __restrict by_b, Lane& __restrict strayed) {
  for (std::size_t i = 0; i < lanes; ++i) {
    const Bend one = bend(a, b, straight, stiffness, i);
    add(by_a, one.by_a, i);
    add(by_b, one.by_b, i);
    if constexpr (!straight) {
      by_a.along[i] += one.along;
      by_b.along[i] += one.along;
    }
    strayed[i] =
        one.tan2 <= (planted(Mutant::strayed_angles_unnoticed) ? 1e300 : near_rest) ? strayed[i] : 1.0;
  }
}

// The same for one star, with the formula for any angle where one has left its surroundings of rest. Returns
// whether all are defined.
bool bend_strayed(const AngleStars::Group& group, std::size_t arms, double stiffness, std::size_t i,
                  Block& block) {
  for (std::size_t arm = 0; arm < arms; ++arm) {
    Gradient& gradient = block.gradients[arm];
    gradient.x[i] = gradient.y[i] = gradient.z[i] = gradient.along[i] = 0.0;
  }
  for (const auto& [p, q, straight] : group.pairs) {
    const Arm& a = block.arms[p];
    const Arm& b = block.arms[q];
    Bend one = bend(a, b, straight, stiffness, i);
    if (!(one.tan2 <= near_rest))
      one = bend_anywhere({a.x[i], a.y[i], a.z[i]}, {b.x[i], b.y[i], b.z[i]}, straight, stiffness);
    if (std::isnan(one.tan2)) return false;
    add(block.gradients[p], one.by_a, i);
    add(block.gradients[q], one.by_b, i);
    block.gradients[p].along[i] += one.along;
    block.gradients[q].along[i] += one.along;
  }
  return true;
}

void load(const std::int32_t* arms, std::size_t lanes, const double* d, std::size_t bonds,
          Arm& __restrict arm) {
  const double* const x = d;
  const double* const y = d + bonds;
  const double* const z = d + 2 * bonds;
  for (std::size_t i = 0; i < lanes; ++i) {
    const std::int32_t bond = arms[i] >> 1;
    const double sign = 1.0 - 2.0 * (arms[i] & 1);
    arm.x[i] = sign * x[bond];
    arm.y[i] = sign * y[bond];
    arm.z[i] = sign * z[bond];
  }
  for (std::size_t i = 0; i < lanes; ++i) {
    arm.squared[i] = arm.x[i] * arm.x[i] + arm.y[i] * arm.y[i] + arm.z[i] * arm.z[i];
    arm.inverse[i] = 1.0 / arm.squared[i];
  }
}

void hand_back(const std::int32_t* arms, std::size_t lanes, std::size_t stars, const Arm& __restrict arm,
               Gradient& __restrict gradient, std::size_t bonds, double* g) {
  for (std::size_t i = 0; i < lanes; ++i) {
    const double sign = 1.0 - 2.0 * (arms[i] & 1);
    const double along = gradient.along[i] * arm.inverse[i];
    gradient.x[i] = sign * (gradient.x[i] + along * arm.x[i]);
    gradient.y[i] = sign * (gradient.y[i] + along * arm.y[i]);
    gradient.z[i] = sign * (gradient.z[i] + along * arm.z[i]);
  }
  double* const x = g;
  double* const y = g + bonds;
  double* const z = g + 2 * bonds;
  for (std::size_t i = 0; i < stars; ++i) {
    const std::int32_t bond = arms[i] >> 1;
    x[bond] += gradient.x[i];
    y[bond] += gradient.y[i];
    z[bond] += gradient.z[i];
  }
}

}  // namespace

bool add_angle_gradients(const AngleStars& stars, const double* d, std::size_t bonds, double stiffness,
                         double* g) {
  Block block;
  for (const AngleStars::Group& group : stars.groups) {
    const std::size_t arms = group.arms.size() / group.lanes;
    for (std::size_t first = 0; first < group.lanes; first += block_size) {
      const std::size_t lanes = std::min(block_size, group.lanes - first);
      const std::size_t stars_here = std::min(lanes, group.stars - first);
      for (std::size_t arm = 0; arm < arms; ++arm) {
        load(&group.arms[arm * group.lanes + first], lanes, d, bonds, block.arms[arm]);
        block.gradients[arm] = {};
      }
      std::fill_n(block.strayed, lanes, 0.0);
      for (const auto& [a, b, straight] : group.pairs) {
        (straight ? bend_all<true> : bend_all<false>)(block.arms[a], block.arms[b], stiffness, lanes,
                                                      block.gradients[a], block.gradients[b], block.strayed);
      }
      for (std::size_t i = 0; i < stars_here; ++i) {
        if (block.strayed[i] != 0.0 && !bend_strayed(group, arms, stiffness, i, block)) return false;
      }
      for (std::size_t arm = 0; arm < arms; ++arm)
        hand_back(&group.arms[arm * group.lanes + first], lanes, stars_here, block.arms[arm],
                  block.gradients[arm], bonds, g);
    }
  }
  return true;
}

}  // namespace veriflex::solid
