#include "solid/angle_kernel.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace veriflex::solid {

namespace {

constexpr std::size_t block_size =
    64;  // angles gathered at a time; 14 arrays of 512 bytes stay in the first-level cache

using Lane = double[block_size];

struct alignas(64) Block {
  Lane ax, ay, az, bx, by, bz;
  Lane straight;                      // 1 or 0
  Lane gax, gay, gaz, gbx, gby, gbz;  // gradient by a and b
  Lane undefined;                     // 1 or 0
};

// atan(x)/x as a polynomial in y = x^2 on [0, 1]: Chebyshev interpolation with 22 nodes, error 9e-19 before
// rounding.
constexpr std::array arc_tangent{
    1.0,
    -0.3333333333333325,
    0.19999999999986157,
    -0.14285714284820428,
    0.11111111080383854,
    -0.09090908440338843,
    0.07692298432985685,
    -0.06666572806289763,
    0.05881647236717415,
    -0.05259103789485882,
    0.0474370596643217,
    -0.042828645702794474,
    0.038129809754225044,
    -0.03264116292977077,
    0.0259471057039563,
    -0.018386836817918875,
    0.011122014669752633,
    -0.005484778971809356,
    0.002090633535263676,
    -0.0005727925781292097,
    9.978410811953032e-05,
    -8.26799581733715e-06,
};

// Horner's scheme without a loop: a loop inside keeps the compiler from vectorising the one outside.
template <std::size_t... I>
inline double horner(double y, std::index_sequence<I...>) {
  double sum = arc_tangent.back();
  ((sum = sum * y + arc_tangent[arc_tangent.size() - 2 - I]), ...);
  return sum;
}

inline double arc_tangent_over_x(double y) {
  return horner(y, std::make_index_sequence<arc_tangent.size() - 1>{});
}

// a d - b c by Kahan's scheme, see angle.hpp.
inline double difference_of_products(double a, double d, double b, double c) {
  const double bc = b * c;
  return std::fma(a, d, -bc) + std::fma(-b, c, bc);
}

void gather(const Angle* angles, std::size_t count, const double* d, std::size_t bonds, Block& block) {
  const double* const x = d;
  const double* const y = d + bonds;
  const double* const z = d + 2 * bonds;
  for (std::size_t i = 0; i < count; ++i) {
    const Angle& t = angles[i];
    block.ax[i] = t.sign_a * x[t.bond_a];
    block.ay[i] = t.sign_a * y[t.bond_a];
    block.az[i] = t.sign_a * z[t.bond_a];
    block.bx[i] = t.sign_b * x[t.bond_b];
    block.by[i] = t.sign_b * y[t.bond_b];
    block.bz[i] = t.sign_b * z[t.bond_b];
    block.straight[i] = t.straight ? 1.0 : 0.0;
  }
  // The rest of the last block repeats a right angle that is at rest.
  for (std::size_t i = count; i < block_size; ++i) {
    block.ax[i] = block.by[i] = 1.0;
    block.ay[i] = block.az[i] = block.bx[i] = block.bz[i] = block.straight[i] = 0.0;
  }
}

// Gradients of a block. No branch: the loop becomes vector instructions.
void evaluate(Block& block, double stiffness) {
  for (std::size_t i = 0; i < block_size; ++i) {
    const double ax = block.ax[i], ay = block.ay[i], az = block.az[i];
    const double bx = block.bx[i], by = block.by[i], bz = block.bz[i];
    const double straight = block.straight[i];
    const double wx = difference_of_products(ay, bz, az, by);
    const double wy = difference_of_products(az, bx, ax, bz);
    const double wz = difference_of_products(ax, by, ay, bx);
    const double s = std::sqrt(wx * wx + wy * wy + wz * wz);
    const double c = ax * bx + ay * by + az * bz;
    const double a2 = ax * ax + ay * ay + az * az;
    const double b2 = bx * bx + by * by + bz * bz;
    // Conditions are kept as numbers: combined truth values would keep the loop from becoming vector
    // instructions.
    const double limit = (1.0 - 1e-12) * a2 * b2;
    const double bent = c * c < limit ? 1.0 : 0.0;
    const double flat = c < 0.0 ? straight : 0.0;  // a straight angle may be
    block.undefined[i] = bent + flat > 0.5 ? 0.0 : 1.0;

    // The deviation is -atan2(num, den); only its quotient by s is needed.
    const double num = straight > 0.5 ? s : c;
    const double den = straight > 0.5 ? -c : s;
    const double steep = std::abs(num);
    const double wide = std::abs(den);
    const double x = std::min(steep, wide) / std::max(steep, wide);
    const double q = arc_tangent_over_x(x * x);
    double angle = x * q;
    angle = steep > wide ? 0.5 * std::numbers::pi - angle : angle;
    angle = den < 0.0 ? std::numbers::pi - angle : angle;
    angle = num < 0.0 ? -angle : angle;
    // Near 180 degrees angle/s is q/wide: no quotient of two small numbers.
    const double nearly_flat = steep <= wide ? flat : 0.0;
    const double rho = -(nearly_flat > 0.5 ? q : angle) / (nearly_flat > 0.5 ? wide : s);

    const double by_a = stiffness * rho / a2;
    const double by_b = -stiffness * rho / b2;
    block.gax[i] = by_a * (ay * wz - az * wy);
    block.gay[i] = by_a * (az * wx - ax * wz);
    block.gaz[i] = by_a * (ax * wy - ay * wx);
    block.gbx[i] = by_b * (by * wz - bz * wy);
    block.gby[i] = by_b * (bz * wx - bx * wz);
    block.gbz[i] = by_b * (bx * wy - by * wx);
  }
}

void scatter(const Angle* angles, std::size_t count, const Block& block, double* g, std::size_t bonds) {
  double* const x = g;
  double* const y = g + bonds;
  double* const z = g + 2 * bonds;
  for (std::size_t i = 0; i < count; ++i) {
    const Angle& t = angles[i];
    x[t.bond_a] += t.sign_a * block.gax[i];
    y[t.bond_a] += t.sign_a * block.gay[i];
    z[t.bond_a] += t.sign_a * block.gaz[i];
    x[t.bond_b] += t.sign_b * block.gbx[i];
    y[t.bond_b] += t.sign_b * block.gby[i];
    z[t.bond_b] += t.sign_b * block.gbz[i];
  }
}

}  // namespace

bool add_angle_gradients(const Angle* angles, std::size_t count, const double* d, std::size_t bonds,
                         double stiffness, double* g) {
  Block block;
  double undefined = 0.0;
  for (std::size_t first = 0; first < count; first += block_size) {
    const std::size_t size = std::min(block_size, count - first);
    gather(angles + first, size, d, bonds, block);
    evaluate(block, stiffness);
    for (const double one : block.undefined) undefined += one;
    scatter(angles + first, size, block, g, bonds);
  }
  return undefined == 0.0;
}

}  // namespace veriflex::solid
