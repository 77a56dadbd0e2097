#include "measures/solid/runge_kutta.hpp"

#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "catch.hpp"

using namespace veriflex;
using measures::RungeKutta;

namespace {

// Displacement of a pair along z that lengthens its bond by `extension`.
Positions stretched(double extension) {
  Positions u = Positions::Zero(2, 3);
  u(0, 2) = -0.5 * extension;
  u(1, 2) = 0.5 * extension;
  return u;
}

const solid::Network pair_of_nodes = solid::cubic_lattice({{1, 1, 2}, 1.0});

}  // namespace

TEST_CASE("A harmonic pair moves as the cosine, to the tolerance and at any step's end") {
  const double omega = std::sqrt(2.0 * 0.26);
  RungeKutta motion({bond::Harmonic{0.26, 1.0}, 0.0}, pair_of_nodes, 1.0, 0.0, 1e-12, omega, stretched(0.1),
                    Positions::Zero(2, 3));
  while (motion.time() < 20.0) {
    motion.step();
    CHECK(motion.displacement()(1, 2) == Approx(0.05 * std::cos(omega * motion.time())).margin(1e-12));
    CHECK(motion.velocity()(1, 2) == Approx(-0.05 * omega * std::sin(omega * motion.time())).margin(1e-12));
  }
  CHECK(motion.steps() < 100);
}

TEST_CASE("The passage through rest is found between two steps") {
  const double omega = std::sqrt(2.0 * 0.26);
  RungeKutta motion({bond::Harmonic{0.26, 1.0}, 0.0}, pair_of_nodes, 1.0, 0.0, 1e-12, omega, stretched(-0.1),
                    Positions::Zero(2, 3));
  Eigen::VectorXd extension(2);
  extension << -1.0, 1.0;
  while (extension.dot(motion.displacement().col(2)) < 0.0) motion.step();
  CHECK(motion.passage(extension) == Approx(0.5 * std::numbers::pi / omega).epsilon(1e-12));
}

TEST_CASE("A pair let go near its limit keeps its energy, and trials beyond the limit are halved") {
  const bond::FeneLj law{1.0, 1.0, 30.0, 1.5, std::pow(2.0, 1.0 / 6.0)};
  const auto energy = [&](const RungeKutta& motion) {
    const Positions u = motion.displacement();
    return law.energy(1.0 + u(1, 2) - u(0, 2)) + 0.5 * motion.velocity().squaredNorm();
  };
  RungeKutta motion({law, 0.0}, pair_of_nodes, 1.0, 0.0, 1e-11, 30.0, stretched(0.499),
                    Positions::Zero(2, 3));
  const double start = energy(motion);
  for (int i = 0; i < 300; ++i) motion.step();
  CHECK(energy(motion) == Approx(start).epsilon(1e-8));
}

TEST_CASE("A motion that starts beyond a bond's limit is refused by name") {
  RungeKutta motion({bond::ShiftedFene{0.26, 1.0, 0.5}, 0.0}, pair_of_nodes, 1.0, 0.0, 1e-8, 1.0,
                    stretched(0.6), Positions::Zero(2, 3));
  CHECK_THROWS_AS(motion.step(), NumericalFailure);
}
