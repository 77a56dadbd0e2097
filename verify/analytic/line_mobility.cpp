#include "analytic/line_mobility.hpp"

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <vector>

#include "analytic/lattice_wave.hpp"
#include "fluid/lattice.hpp"

namespace veriflex::analytic {

namespace {

using Eigen::Index;
using Eigen::VectorXcd;
using std::numbers::pi;

struct Wave {
  double k;
  int count;  // itself and that with - k, which is as good
};

/// Of a box of so many nodes, but those of two nodes, which the kernel lets nothing of.
std::vector<Wave> waves(std::int64_t nodes) {
  std::vector<Wave> all{{0.0, 1}};
  for (std::int64_t i = 1; 2 * i < nodes; ++i)
    all.push_back({2.0 * pi * static_cast<double>(i) / static_cast<double>(nodes), 2});
  return all;
}

/// Velocity sum f c of a wave exp(i k.x + i omega t) per force along x and along z, a column each; of the
/// same wave both ways.
Eigen::Matrix<Complex, 3, 2> response(const Vec3& k, double relaxation_time, double omega = 0.0) {
  using Step = Eigen::Matrix<Complex, fluid::Q, fluid::Q>;
  Eigen::Matrix<Complex, fluid::Q, 2> pushed;
  Eigen::Matrix<Complex, 3, fluid::Q> velocities;
  for (int q = 0; q < fluid::Q; ++q) {
    const auto& c = fluid::c[static_cast<std::size_t>(q)];
    const Vec3 v(c[0], c[1], c[2]);
    velocities.col(q) = v.cast<Complex>();
    const Complex arrived = 3.0 * fluid::w(q) * std::polar(1.0, -k.dot(v));
    pushed.row(q) << arrived * v.x(), arrived * v.z();
  }
  const Step left = std::polar(1.0, omega) * Step::Identity() - one_step(k, relaxation_time);
  return velocities * left.partialPivLu().solve(pushed);
}

}  // namespace

double interpolated(double wavenumber) { return 0.5 * (1.0 + std::cos(wavenumber)); }

double interpolated_slope(double wavenumber) {
  return wavenumber == 0.0 ? 1.0 : std::sin(wavenumber) / wavenumber;
}

double roll_response(double wavenumber, double relaxation_time) {
  const Eigen::Matrix<Complex, 3, 2> u = response({wavenumber, 0.0, wavenumber}, relaxation_time);
  return u(0, 0).real() - u(0, 1).real();  // of a force along (1, 0, -1), across the wave
}

OscillatingMobility oscillating_line_mobility(const Grid& box, double relaxation_time, std::int64_t markers,
                                              double omega) {
  const std::vector<Wave> x = waves(box.size[0]), y = waves(box.size[1]), z = waves(box.size[2]);
  OscillatingMobility sum{VectorXcd::Zero(markers), VectorXcd::Zero(markers), VectorXcd::Zero(markers)};
  for (const Wave& a : x) {
    Complex along = 0.0, across = 0.0, turned = 0.0;
    for (const Wave& b : y) {
      for (const Wave& c : z) {
        if (a.k + b.k + c.k == 0.0) continue;
        const double plane = std::pow(interpolated(a.k) * interpolated(b.k), 2) * a.count * b.count * c.count;
        const double kernel = interpolated(c.k), slope = c.k * interpolated_slope(c.k);
        const Eigen::Matrix<Complex, 3, 2> u = response({a.k, b.k, c.k}, relaxation_time, omega);
        along += plane * kernel * kernel * u(0, 0);
        across += plane * kernel * kernel * u(2, 1);
        turned -= plane * kernel * slope * u(2, 0);
      }
    }
    for (Index d = 0; d < markers; ++d) {
      const double phase = a.k * static_cast<double>(d);
      sum.along[d] += along * std::cos(phase);
      sum.across[d] += across * std::cos(phase);
      sum.turned[d] += turned * std::sin(phase);
    }
  }
  const auto nodes = static_cast<double>(box.count());
  return {sum.along / nodes, sum.across / nodes, sum.turned / nodes};
}

Mobility line_mobility(const Grid& box, double relaxation_time, std::int64_t markers) {
  const OscillatingMobility steady = oscillating_line_mobility(box, relaxation_time, markers, 0.0);
  return {steady.along.real(), steady.across.real(), steady.turned.real()};
}

double marker_radius(double relaxation_time, double slip) {
  constexpr std::int64_t wide = 48;
  const double mu = fluid::viscosity(relaxation_time);
  const double in_cube = line_mobility({{wide, wide, wide}}, relaxation_time, 1).across[0];
  // A cube holds back by that of a point.                                                      [hasimoto-1959]
  const double unbounded = in_cube + 2.837297 / (6.0 * pi * mu * static_cast<double>(wide));
  return 1.0 / (6.0 * pi * mu * (unbounded + slip));
}

}  // namespace veriflex::analytic
