#include "measures/solid/multirate.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "base/error.hpp"
#include "base/work.hpp"
#include "catch.hpp"
#include "measures/solid/runge_kutta.hpp"
#include "solid/leapfrog.hpp"

using namespace veriflex;
using measures::Multirate;
using measures::RungeKutta;

namespace {

constexpr double stiffness = 0.26, mass = 1.0;
const solid::Material harmonic{bond::Harmonic{stiffness, 1.0}, 0.0};
const solid::Network pair_of_nodes = solid::cubic_lattice({{1, 1, 2}, 1.0});
const double omega = std::sqrt(2.0 * stiffness);

// Displacement of a pair along z that lengthens its bond by `extension`.
Positions stretched(double extension) {
  Positions u = Positions::Zero(2, 3);
  u(0, 2) = -0.5 * extension;
  u(1, 2) = 0.5 * extension;
  return u;
}

const Positions at_rest = Positions::Zero(2, 3);

double extension_of(const Positions& u) { return u(1, 2) - u(0, 2); }

// Of a harmonic pair under drag, let go at an extension of 0.1.
double exact_extension(double drag, double time) {
  const double swings = std::sqrt(omega * omega - 0.25 * drag * drag);
  return 0.1 * std::exp(-0.5 * drag * time) *
         (std::cos(swings * time) + 0.5 * drag / swings * std::sin(swings * time));
}

double energy_of(const Multirate& motion) {
  return 0.5 * stiffness * std::pow(extension_of(motion.displacement()), 2) +
         0.5 * mass * motion.velocity().squaredNorm();
}

}  // namespace

TEST_CASE("Multirate methods have their order where the drag is slow") {
  const int order = GENERATE(3, 4);
  constexpr double drag = 0.1, duration = 16.0;
  const auto error_of = [&](int steps) {
    Multirate motion(harmonic, pair_of_nodes, mass, drag, order, duration / steps, 12, stretched(0.1),
                     at_rest);
    for (int i = 0; i < steps; ++i) motion.step();
    CHECK(motion.time() == Approx(duration).epsilon(1e-12));
    return std::abs(extension_of(motion.displacement()) - exact_extension(drag, duration));
  };
  CHECK(std::log2(error_of(128) / error_of(256)) == Approx(order).margin(0.06));
}

TEST_CASE(
    "A step of a multirate method takes the drag at its stages and the bonds at those of the sub-steps") {
  Multirate third(harmonic, pair_of_nodes, mass, 0.1, 3, 1.0, 12, stretched(0.1), at_rest);
  Multirate fourth(harmonic, pair_of_nodes, mass, 0.1, 4, 1.0, 10, stretched(0.1), at_rest);
  const auto bonds_of_steps = [](Multirate& motion, int steps) {
    const std::uint64_t before = work::done().bond_evaluations;
    for (int i = 0; i < steps; ++i) motion.step();
    return work::done().bond_evaluations - before;
  };
  // And once more at the start of each step, and twice at that of a motion.
  CHECK(bonds_of_steps(third, 10) <= 10 * (12 * 3 + 1) + 2);
  CHECK(bonds_of_steps(fourth, 10) <= 10 * (10 * 4 + 1) + 2);
  CHECK(third.drag_evaluations() <= 10 * 3 + 1);
  CHECK(fourth.drag_evaluations() <= 10 * 5 + 1);
}

TEST_CASE("A multirate method finds the motion that an embedded Runge-Kutta method finds") {
  const solid::Network chain = solid::cubic_lattice({{1, 1, 5}, 1.0});
  const solid::Material material{bond::ShiftedFene{stiffness, 1.0, 0.5}, 0.0};
  std::mt19937 random(5);
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  Positions u(5, 3), v(5, 3);
  for (Eigen::Index i = 0; i < u.size(); ++i) u.data()[i] = noise(random);
  for (Eigen::Index i = 0; i < v.size(); ++i) v.data()[i] = noise(random);
  constexpr double drag = 0.05;
  RungeKutta embedded(material, chain, mass, drag, 1e-13, 1.0, u, v);
  while (embedded.time() < 10.0) embedded.step();
  constexpr int steps = 1000;
  Multirate motion(material, chain, mass, drag, 4, embedded.time() / steps, 10, u, v);
  for (int i = 0; i < steps; ++i) motion.step();
  CHECK((motion.displacement() - embedded.displacement()).cwiseAbs().maxCoeff() < 1e-9);
  CHECK((motion.velocity() - embedded.velocity()).cwiseAbs().maxCoeff() < 1e-9);
  // They find it apart from one another: both went far, and the drag took its part.
  CHECK((embedded.displacement() - u).cwiseAbs().maxCoeff() > 0.1);
}

TEST_CASE("Without drag a multirate method loses energy as its sub-steps do and leap-frog keeps it") {
  // |1 + iy - y^2/2 - iy^3/6|^2 of order 3, with y^4/24 more of order 4: what is left after a sub-step.
  const int order = GENERATE(3, 4);
  const int substeps = order == 3 ? 12 : 10;
  constexpr int steps = 200;
  const double dt = 0.25 * substeps / omega, y = 0.25;
  Multirate motion(harmonic, pair_of_nodes, mass, 0.0, order, dt, substeps, stretched(0.1), at_rest);
  const double start = energy_of(motion);
  for (int i = 0; i < steps; ++i) motion.step();
  const std::complex<double> z(0.0, y);
  const std::complex<double> factor =
      1.0 + z + z * z / 2.0 + z * z * z / 6.0 + (order == 4 ? z * z * z * z / 24.0 : 0.0);
  CHECK(energy_of(motion) / start == Approx(std::pow(std::norm(factor), steps * substeps)).epsilon(1e-9));
  CHECK(energy_of(motion) < (order == 3 ? 0.5 : 0.995) * start);

  // Leap-frog's energy swings by (y/2)^2 and comes back: in the last tenth of the run as in the first.
  solid::Leapfrog leapfrog(harmonic, pair_of_nodes, {}, dt, {substeps, 0.0}, stretched(0.1), at_rest);
  double first = 0.0, last = 0.0;
  for (int i = 0; i < steps; ++i) {
    leapfrog.step();
    const double energy = 0.5 * stiffness * std::pow(extension_of(leapfrog.displacement()), 2) +
                          0.5 * mass * leapfrog.velocity().squaredNorm();
    const double departure = std::abs(energy / start - 1.0);
    if (i < steps / 10) first = std::max(first, departure);
    if (i >= steps - steps / 10) last = std::max(last, departure);
  }
  CHECK(first < 0.3 * y * y);
  CHECK(last < 1.2 * first);
}

TEST_CASE("A multirate method finds the passage through rest between two steps") {
  Multirate motion(harmonic, pair_of_nodes, mass, 0.0, 4, 0.2, 20, stretched(-0.1), at_rest);
  Eigen::VectorXd extension(2);
  extension << -1.0, 1.0;
  while (extension.dot(motion.displacement().col(2)) < 0.0) motion.step();
  CHECK(motion.passage(extension) == Approx(0.5 * std::numbers::pi / omega).epsilon(1e-7));
  CHECK(motion.passage(extension) < motion.time());
}

TEST_CASE("A multirate motion that starts beyond a bond's limit is refused by name") {
  Multirate motion({bond::ShiftedFene{stiffness, 1.0, 0.5}, 0.0}, pair_of_nodes, mass, 0.0, 3, 0.1, 4,
                   stretched(0.6), at_rest);
  CHECK_THROWS_WITH(motion.step(), ContainsSubstring("step 1: bond of nodes 0 and 1 has length 1.6"));
  CHECK_THROWS_AS(motion.step(), NumericalFailure);
}
