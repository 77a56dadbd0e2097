#include "analytic/lattice_wave.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "analytic/decaying_flow.hpp"
#include "analytic/stream_growth.hpp"
#include "catch.hpp"
#include "fluid/initial.hpp"

using namespace veriflex;
using analytic::Complex;
using analytic::ContinuumWave;
using analytic::lattice_wave;
using analytic::LatticeWave;

namespace {

const double speed_of_sound = std::sqrt(fluid::sound_speed_squared);

ContinuumWave shear(const Vec3& along) { return {0.0, along}; }
ContinuumWave sound(const Vec3& k) { return {1.0, speed_of_sound * k.normalized()}; }

/// Relative departure of the decay rate from nu k^2, over k^2, where k is small.
double viscosity_error(const Vec3& direction, const Vec3& along, double tau) {
  const Vec3 k = 0.02 * direction.normalized();
  const double nu_k2 = fluid::viscosity(tau) * k.squaredNorm();
  return (lattice_wave(k, tau, shear(along)).decay_rate() / nu_k2 - 1.0) / k.squaredNorm();
}

}  // namespace

TEST_CASE("Long waves decay with nu k^2 and travel at 1/sqrt(3), in any direction") {
  for (const double tau : {0.51, 0.6, 0.8, 1.0, 1.5, 2.0}) {
    for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(0, 1, 1), Vec3(1, 1, 1), Vec3(0.3, -0.5, 0.7)}) {
      CAPTURE(tau, direction.transpose());
      const Vec3 k = 0.01 * direction.normalized();
      const double nu_k2 = fluid::viscosity(tau) * 1e-4;
      // The lattice's own errors are of relative order k^2 = 1e-4, with factors of up to 4.
      const LatticeWave s = lattice_wave(k, tau, shear(direction.unitOrthogonal()));
      CHECK(s.decay_rate() == Approx(nu_k2).epsilon(4e-4));
      CHECK(std::abs(s.angular_frequency()) < 1e-13);
      const LatticeWave p = lattice_wave(k, tau, sound(k));
      CHECK(p.decay_rate() == Approx(nu_k2).epsilon(4e-4));
      CHECK(p.angular_frequency() == Approx(0.01 * speed_of_sound).epsilon(1e-4));
    }
  }
}

TEST_CASE(
    "The viscosity's error is (1/12 - s^2/3) k^2 along an axis, s = tau - 1/2, and others along (0,1,1)") {
  for (const double tau : {0.51, 0.6, 0.8, 1.0, 1.5, 2.0}) {
    CAPTURE(tau);
    const double s = tau - 0.5;
    const auto near = [](double value) { return Approx(value).margin(2e-3); };  // the next term, k^2 = 4e-4
    CHECK(viscosity_error({1, 0, 0}, {0, 1, 0}, tau) == near(1.0 / 12.0 - s * s / 3.0));
    CHECK(viscosity_error({0, 1, 1}, {1, 0, 0}, tau) == near(1.0 / 4.0 - 4.0 * s * s / 3.0));
    CHECK(viscosity_error({0, 1, 1}, {0, 1, -1}, tau) == near(s * s / 6.0));
  }
}

TEST_CASE("Eigenvalue and eigenvectors belong to the matrix, and to each other") {
  for (const double tau : {0.51, 0.8, 1.0, 2.0}) {
    for (const Vec3& k : {Vec3(0.2, 0, 0), Vec3(0, 0.7, 0.7), Vec3(0.1, -0.4, 0.3)}) {
      for (const Vec3& stream : {Vec3(0, 0, 0), Vec3(0.1, 0.02, 0.05)}) {
        const auto step = analytic::one_step(k, tau, stream);
        for (const ContinuumWave& like : {shear(k.unitOrthogonal()), sound(k), sound(-k)}) {
          CAPTURE(tau, k.transpose(), stream.transpose(), like.density);
          const LatticeWave wave = lattice_wave(k, tau, like, stream);
          CHECK((step * wave.shape - wave.factor * wave.shape).norm() < 1e-13);
          CHECK((step.transpose() * wave.projection - wave.factor * wave.projection).norm() < 1e-12);
          CHECK(std::abs((wave.projection.transpose() * wave.shape)(0) - 1.0) < 1e-13);
        }
      }
    }
  }
}

TEST_CASE("Eigenvalues in high precision (reference/lattice_wave.py)") {
  const auto along = [](const Vec3& direction, int n) { return 2.0 * std::numbers::pi / n * direction; };
  const auto near = [](Complex a, Complex b) { return std::abs(a - b) < 1e-14; };
  CHECK(near(lattice_wave(along({0, 1, 1}, 16), 0.6, shear({1, 0, 0})).factor, 0.98898712553910742721));
  CHECK(near(lattice_wave(along({1, 0, 0}, 8), 1.0, shear({0, 1, 0})).factor, 0.90236892706218250813));
  const Vec3 k = along({0, 1, 1}, 12);
  CHECK(near(lattice_wave(k, 0.8, sound(k)).factor, {0.86008739708437127376, -0.38883485939882542454}));
  const Vec3 q = along({1, 0, 0}, 32);
  CHECK(near(lattice_wave(q, 2.0, sound(q)).factor, {0.97386248824620561362, -0.11254933497846996565}));
}

TEST_CASE("At tau = 1 a shear wave along an axis has the factor 1 - (1 - cos k)/3") {
  for (const double k : {0.1, 0.7, 1.5}) {
    const Complex factor = lattice_wave({k, 0, 0}, 1.0, shear({0, 0, 1})).factor;
    CHECK(std::abs(factor - (1.0 - (1.0 - std::cos(k)) / 3.0)) < 1e-14);
  }
}

TEST_CASE("A stream U carries a shear wave along and takes 3 (U.k)^2/k^2 of its viscosity") {
  const Vec3 U(0.1, 0.05, 0.0);
  for (const double tau : {0.6, 1.0, 1.5}) {
    const Vec3 k = 0.01 * Vec3(0.6, 0.0, 0.8);
    const LatticeWave wave = lattice_wave(k, tau, shear({0, 1, 0}), U);
    const double nu_k2 = fluid::viscosity(tau) * k.squaredNorm();
    CHECK(wave.angular_frequency() == Approx(U.dot(k)).epsilon(4.0 * k.squaredNorm()));
    CHECK(1.0 - wave.decay_rate() / nu_k2 == Approx(3.0 * 0.06 * 0.06).epsilon(0.03));
  }
}

TEST_CASE("Populations near equilibrium have the density, momentum and viscous stress asked for") {
  const double rho = 1.02, tau = 0.8;
  const Vec3 u(0.01, -0.02, 0.03);
  Mat3 gradient;
  gradient << 1e-3, 2e-3, -3e-3, 4e-3, -3e-3, 5e-4, 1e-3, 2e-3, 2e-3;  // no divergence
  const fluid::Populations h = fluid::near_equilibrium(rho, u, gradient, tau);
  CHECK(fluid::density_deviation(h) == Approx(rho - 1.0).epsilon(1e-13));
  CHECK((fluid::momentum(h) - rho * u).norm() < 1e-16);
  const Mat3 stress = rho * fluid::viscosity(tau) * (gradient + gradient.transpose());
  CHECK((fluid::viscous_stress(h, tau) - stress).norm() < 1e-15);
  // A swelling fluid keeps its density in the moment of starting, too.
  CHECK(fluid::density_deviation(fluid::near_equilibrium(rho, u, Mat3(Mat3::Identity()), tau)) ==
        Approx(rho - 1.0).epsilon(1e-13));
}

TEST_CASE("Decaying flows satisfy the Navier-Stokes equations, and their gradient is that of the velocity") {
  for (const analytic::Pattern pattern : {analytic::Pattern::TaylorGreen, analytic::Pattern::Shear}) {
    const analytic::DecayingFlow flow{pattern, 2, 0, 0.7, 0.3, 0.05, {0.02, 0.1, -0.03}};
    const double time = 1.7, d = 1e-3;
    const Vec3 x(0.4, -0.8, 2.1);
    const auto velocity = [&](const Vec3& at, double t) { return flow.at(at, t).velocity; };
    const analytic::FlowState here = flow.at(x, time);
    Vec3 pressure_gradient, laplace = -6.0 * here.velocity / (d * d);
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 e = d * Vec3::Unit(axis);
      const Vec3 slope = (velocity(x + e, time) - velocity(x - e, time)) / (2.0 * d);
      CHECK((here.gradient.row(axis).transpose() - slope).norm() < 1e-6);
      pressure_gradient[axis] = (flow.at(x + e, time).pressure - flow.at(x - e, time).pressure) / (2.0 * d);
      laplace += (velocity(x + e, time) + velocity(x - e, time)) / (d * d);
    }
    const Vec3 rate = (velocity(x, time + d) - velocity(x, time - d)) / (2.0 * d);
    const Vec3 carried = here.gradient.transpose() * here.velocity;
    CHECK(std::abs(here.gradient.trace()) < 1e-16);
    CHECK(carried.norm() > 1e-3);
    CHECK((rate + carried + pressure_gradient - flow.viscosity * laplace).norm() < 1e-7);
  }
}

TEST_CASE("The swelling's divergence is what the pressure's change along the flow asks for") {
  const analytic::DecayingFlow flow{analytic::Pattern::TaylorGreen, 0, 1, 0.7, 0.3, 0.05};
  const double d = 1e-4, c2 = fluid::sound_speed_squared;
  const Vec3 x(0.4, -0.8, 0.0);
  double divergence = 0.0;
  double change = (flow.at(x, d).pressure - flow.at(x, -d).pressure) / (2.0 * d);
  for (int axis = 0; axis < 2; ++axis) {
    const Vec3 e = d * Vec3::Unit(axis);
    divergence += (flow.swelling(x + e, c2)[axis] - flow.swelling(x - e, c2)[axis]) / (2.0 * d);
    change += flow.at(x, 0.0).velocity[axis] * (flow.at(x + e, 0.0).pressure - flow.at(x - e, 0.0).pressure) /
              (2.0 * d);
  }
  CHECK(std::abs(change) > 1e-4);
  CHECK(divergence == Approx(-change / c2).epsilon(1e-6));
}

TEST_CASE("The fastest wave on a stream is that of all waves of the box, found with half of them") {
  const Grid box{{4, 3, 2}};
  for (const Vec3& stream : {Vec3(0.45, 0.1, -0.2), Vec3(0.3, 0.0, 0.0), Vec3(0.0, 0.0, 0.0)}) {
    double fastest = 0.0;
    for (std::int64_t number = 0; number < box.count(); ++number) {
      const auto [x, y, z] = box.node(number);
      const Vec3 k =
          2.0 * std::numbers::pi *
          Vec3(static_cast<double>(x) / 4.0, static_cast<double>(y) / 3.0, static_cast<double>(z) / 2.0);
      const Eigen::ComplexEigenSolver<Eigen::MatrixXcd> all(
          Eigen::MatrixXcd(analytic::one_step(k, 0.55, stream)));
      fastest = std::max(fastest, all.eigenvalues().cwiseAbs().maxCoeff());
    }
    CHECK(analytic::fastest_wave(box, 0.55, stream).factor == Approx(fastest).epsilon(1e-13));
  }
}

TEST_CASE("A fluid at rest is stable at any tau above 1/2, and a stream at tau = 1 up to U + c_s = 1") {
  const Grid box{{6, 6, 1}};
  for (const double tau : {0.5001, 0.6, 1.0, 100.0}) {
    CHECK(analytic::fastest_wave(box, tau, Vec3::Zero()).factor == Approx(1.0).epsilon(1e-12));
  }
  const double limit = 1.0 - 1.0 / std::sqrt(3.0);
  CHECK(analytic::fastest_wave(box, 1.0, {0.999 * limit, 0.0, 0.0}).factor < 1.0 + 1e-12);
  CHECK(analytic::fastest_wave(box, 1.0, {1.001 * limit, 0.0, 0.0}).factor > 1.0 + 1e-5);
}
