#include <cmath>
#include <numbers>
#include <random>

#include "base/error.hpp"
#include "bond/derive.hpp"
#include "catch.hpp"
#include "solid/implicit_midpoint.hpp"
#include "solid/leapfrog.hpp"
#include "solid/modes.hpp"

using namespace veriflex;
using namespace veriflex::solid;

namespace {

const bond::AnyLaw paper_fene =
    bond::make_law("fene-lj", [](const std::string& name) -> std::optional<double> {
      if (name == "epsilon") return 2.86970720062559e-4;
      if (name == "sigma") return 1.040694052478347;
      return std::nullopt;
    });
const Material glsm{bond::Harmonic{0.26, 1.0}, 0.025};
const Material glnsm{paper_fene, 0.025};

Network bar(std::int64_t n, std::int64_t m, std::int64_t l) {
  Network network = cubic_lattice({{n, m, l}, 1.0});
  add_angles(network);
  return network;
}

Positions noise(const Network& network, double amplitude) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-amplitude, amplitude);
  Positions u(network.node_count(), 3);
  for (double& component : u.reshaped()) component = uniform(random);
  return u;
}

Positions zero(const Network& network) { return Positions::Zero(network.node_count(), 3); }
FixedDofs nothing_held(const Network& network) { return FixedDofs::Constant(network.node_count(), 3, false); }

}  // namespace

TEST_CASE("The filament's largest frequency is what the lattice gives, the same for both laws at rest") {
  Network rod = rod_lattice({2.5, 51, 1.0});
  add_angles(rod);
  const double omega = largest_frequency(glsm, rod, zero(rod), nothing_held(rod), 1.0);
  CHECK(omega * omega == Approx(2.36227392).epsilon(1e-8));
  CHECK(2.0 / omega == Approx(1.301262).epsilon(1e-6));
  CHECK(largest_frequency(glnsm, rod, zero(rod), nothing_held(rod), 1.0) == Approx(omega).epsilon(1e-9));
}

TEST_CASE("No finite body oscillates faster than the infinite lattice: omega^2 = (4 k + 64 k_a)/m") {
  double last = 0.0;
  for (const std::int64_t n : {3, 6, 10}) {
    const Network cube = bar(n, n, n);
    const double omega = largest_frequency(glsm, cube, zero(cube), nothing_held(cube), 1.0);
    CHECK(omega * omega < 4.0 * 0.26 + 64.0 * 0.025);
    CHECK(omega > last);
    last = omega;
  }
  CHECK(last * last > 0.95 * 2.64);
}

TEST_CASE("A free body has six modes of frequency zero, dense or sparse") {
  for (const std::int64_t length : {3, 14}) {
    const Network network = bar(3, 3, length);
    const Eigen::VectorXd omega =
        lowest_frequencies(glsm, network, zero(network), nothing_held(network), 1.0, 8);
    REQUIRE(omega.size() == 8);
    CHECK(omega.head(6).cwiseAbs().maxCoeff() < 1e-5);
    CHECK(omega[6] > 1e-3);
  }
}

TEST_CASE("A chain of springs has the frequencies 2 sqrt(k/m) sin(pi j / 2n)") {
  const int n = 20;
  const Network chain = cubic_lattice({{1, 1, n}, 1.0});
  FixedDofs held = nothing_held(chain);
  held.leftCols(2).setConstant(true);
  const Eigen::VectorXd omega =
      lowest_frequencies({bond::Harmonic{0.26, 1.0}, 0.0}, chain, zero(chain), held, 1.0, 5);
  for (int j = 1; j < 5; ++j) {
    CHECK(omega[j] ==
          Approx(2.0 * std::sqrt(0.26) * std::sin(std::numbers::pi * j / (2.0 * n))).epsilon(1e-12));
  }
}

TEST_CASE("A harmonic pair swings with the frequency of the leap-frog scheme to round-off") {
  const Network pair = cubic_lattice({{1, 1, 2}, 1.0});
  const double k = 0.26;
  const double dt = 0.5;
  const double omega = 2.0 / dt * std::asin(0.5 * dt * std::sqrt(2.0 * k));
  Positions u = zero(pair);
  u(0, 2) = -0.05;
  u(1, 2) = 0.05;
  Leapfrog motion({bond::Harmonic{k, 1.0}, 0.0}, pair, {}, dt, {}, u, zero(pair));
  for (int step = 1; step <= 2000; ++step) {
    motion.step();
    CHECK(std::abs(motion.displacement()(1, 2) - 0.05 * std::cos(omega * step * dt)) < 1e-12);
  }
}

TEST_CASE(
    "The implicit midpoint rule swings a harmonic pair with tan(w' dt/2) = w dt/2, however long its step") {
  const Network network = cubic_lattice({{1, 1, 2}, 1.0});
  Positions u = zero(network);
  u(1, 2) = 0.01;
  u(0, 2) = -0.01;
  const double omega = std::sqrt(2.0 * 0.26);
  FixedDofs along = FixedDofs::Constant(2, 3, true);  // a pair that is pressed turns aside in a long step
  along.col(2).setConstant(false);
  for (const double dt : {0.1, 1.0, 10.0, 1000.0}) {
    ImplicitMidpoint motion({bond::Harmonic{0.26, 1.0}, 0.0}, network,
                            {.fixed = along, .load = {}, .drive = {}}, dt, u, zero(network));
    const double turn = 2.0 * std::atan(0.5 * omega * dt);
    for (int step = 1; step <= 50; ++step) {
      motion.step();
      CHECK(motion.displacement()(1, 2) == Approx(0.01 * std::cos(turn * step)).margin(1e-13));
    }
  }
}

TEST_CASE("The implicit midpoint rule keeps momentum, finds its way back, and is of second order in energy") {
  for (const Material& material : {glsm, glnsm}) {
    const Network network = bar(3, 3, 4);
    const Positions u = noise(network, 0.02), v = noise(network, 0.02);
    const double total = v.sum();
    const auto energy_of = [&](const ImplicitMidpoint& motion) {
      Leapfrog same(material, network, {}, 1.0, {}, motion.displacement(), motion.velocity());
      return same.potential_energy() + 0.5 * motion.velocity().squaredNorm();
    };
    std::vector<double> drift;
    for (const double dt : {0.5, 0.25}) {
      ImplicitMidpoint there(material, network, {}, dt, u, v);
      const double before = energy_of(there);
      double worst = 0.0;
      while (there.time() < 20.0) {
        there.step();
        worst = std::max(worst, std::abs(energy_of(there) - before));
      }
      drift.push_back(worst);
      CHECK(there.velocity().sum() == Approx(total).margin(1e-13));
      ImplicitMidpoint back(material, network, {}, dt, there.displacement(), -there.velocity());
      while (back.time() < 20.0) back.step();
      CHECK((back.displacement() - u).cwiseAbs().maxCoeff() < 1e-11);
    }
    CHECK(drift[0] / drift[1] == Approx(4.0).epsilon(0.15));
  }
}

TEST_CASE("A loaded, clamped body that the implicit rule damps by nothing swings about its equilibrium") {
  const Network network = cubic_lattice({{1, 1, 2}, 1.0});
  FixedDofs fixed = nothing_held(network);
  fixed.row(0).setConstant(true);
  fixed.row(1) << true, true, false;
  Positions load = zero(network);
  load(1, 2) = 0.0026;
  ImplicitMidpoint motion({bond::Harmonic{0.26, 1.0}, 0.0}, network,
                          {.fixed = fixed, .load = load, .drive = {}}, 0.5, zero(network), zero(network));
  double least = 0.0, most = 0.0;
  for (int step = 0; step < 200; ++step) {
    motion.step();
    least = std::min(least, motion.displacement()(1, 2));
    most = std::max(most, motion.displacement()(1, 2));
  }
  CHECK(least == Approx(0.0).margin(1e-14));
  CHECK(most == Approx(0.02).epsilon(1e-3));
  CHECK(motion.displacement().row(0).isZero(0.0));
}

TEST_CASE("By the implicit rule a point under drag and coupling moves as its line of arithmetic says") {
  // m (v' - v)/dt = F + V (w - s) - gamma s with s = (v + v')/2, which is (u' - u)/dt.
  const Network pair = cubic_lattice({{1, 1, 2}, 1.0});
  constexpr double m = 0.8, gamma = 0.3, F = 0.02, V = 0.7, dt = 0.5;
  const std::vector<std::int32_t> nodes{0, 1};
  Positions load = zero(pair), target = zero(pair), v0 = zero(pair);
  load.col(0).setConstant(F);
  target.col(0).setConstant(-0.1);
  v0.col(0).setConstant(0.03);
  for (const bool subcycled : {true, false}) {
    ImplicitMidpoint motion({bond::Harmonic{0.26, 1.0}, 0.0}, pair, {m, gamma, {}, load, {}}, dt, zero(pair),
                            v0);
    double u = 0.0, v = 0.03;
    Positions mean;
    for (int step = 0; step < 20; ++step) {
      const double frozen = V * (-0.1 - v);
      const double s = subcycled ? (2.0 * m / dt * v + F - 0.1 * V) / (2.0 * m / dt + V + gamma)
                                 : (2.0 * m / dt * v + F + frozen) / (2.0 * m / dt + gamma);
      motion.step({nodes, target, V, subcycled}, mean);
      u += dt * s;
      v = 2.0 * s - v;
      CHECK(motion.displacement()(1, 0) == Approx(u).epsilon(1e-12));
      CHECK(motion.velocity()(1, 0) == Approx(v).epsilon(1e-11));
      CHECK(mean(0, 0) == Approx(subcycled ? V * (-0.1 - s) : frozen).epsilon(1e-11));
    }
  }
}

TEST_CASE("Driven and coupled, the implicit rule and leap-frog come to one motion") {
  const Network network = bar(2, 2, 6);
  Conditions conditions;
  conditions.drive = Drive{{0, 1, 2, 3}, 0, 0.3, 0.4, 3.0};
  conditions.fixed = nothing_held(network);
  for (int i = 0; i < 4; ++i) conditions.fixed.row(i) << false, true, true;
  std::vector<std::int32_t> nodes;
  for (int i = 4; i < 24; ++i) nodes.push_back(i);
  const Positions target = Positions::Constant(20, 3, 0.01);
  Positions mean;
  const auto run = [&](auto&& motion) {
    while (motion.time() < 8.0 - 1e-9) motion.step({nodes, target, 0.5, true}, mean);
    return motion.displacement();
  };
  for (const Material& material : {glsm, glnsm}) {
    const auto implicit = [&](double dt) {
      return run(ImplicitMidpoint(material, network, conditions, dt, zero(network), zero(network)));
    };
    const auto leapfrog = [&](int substeps) {
      return run(
          Leapfrog(material, network, conditions, 0.25, {substeps, 0.0}, zero(network), zero(network)));
    };
    const auto distance = [](const Positions& a, const Positions& b) {
      return (a - b).cwiseAbs().maxCoeff();
    };
    const Positions fine = implicit(1.0 / 64);
    CHECK(distance(implicit(0.25), fine) / distance(implicit(0.125), fine) == Approx(4.2).epsilon(0.1));
    // Leap-frog's force knows the velocity of half a sub-step ago: of first order.
    const double far = distance(leapfrog(64), fine), near = distance(leapfrog(128), fine);
    CHECK(far < 1e-3);
    CHECK(far / near == Approx(2.0).epsilon(0.1));
  }
}

TEST_CASE("Of a body 10^8 times as stiff as leap-frog bears the implicit rule keeps the energy") {
  const Network network = bar(3, 3, 6);
  const Material stiff{bond::Harmonic{2.6e7, 1.0}, 2.5e6};
  const Positions v = noise(network, 1e-3);
  ImplicitMidpoint motion(stiff, network, {}, 1.0, zero(network), v);
  const double before = motion.kinetic_energy() + motion.potential_energy();
  for (int step = 0; step < 100; ++step) motion.step();
  CHECK(motion.kinetic_energy() + motion.potential_energy() == Approx(before).epsilon(1e-3));
}

TEST_CASE("A step over a bond's limit is refused with the step, and nothing has moved") {
  const Network network = cubic_lattice({{1, 1, 2}, 1.0});
  Positions v = zero(network);
  v(1, 2) = 100.0;
  ImplicitMidpoint motion({paper_fene, 0.0}, network, {}, 10.0, zero(network), v);
  CHECK_THROWS_WITH(motion.step(), ContainsSubstring("step 1: "));
  CHECK(motion.displacement().isZero(0.0));
  CHECK(motion.steps() == 0);
}

TEST_CASE("Momentum stays what it was when nothing holds the body") {
  for (const Material& material : {glsm, glnsm}) {
    const Network network = bar(3, 2, 5);
    Leapfrog motion(material, network, {}, 0.2, {}, noise(network, 0.03), noise(network, 0.01));
    const Vec3 before = motion.momentum();
    for (int step = 0; step < 2000; ++step) motion.step();
    CHECK((motion.momentum() - before).norm() < 1e-14);
  }
}

TEST_CASE("The energy error is bounded and of second order in the step") {
  for (const Material& material : {glsm, glnsm}) {
    const Network network = bar(2, 2, 4);
    const auto worst = [&](double dt) {
      Leapfrog motion(material, network, {}, dt, {}, noise(network, 0.01), zero(network));
      const double start = motion.kinetic_energy() + motion.potential_energy();
      double error = 0.0;
      for (int step = 0; step < static_cast<int>(100.0 / dt); ++step) {
        motion.step();
        error = std::max(error, std::abs(motion.kinetic_energy() + motion.potential_energy() - start));
      }
      return error;
    };
    CHECK(std::log2(worst(0.1) / worst(0.05)) == Approx(2.0).margin(0.1));
  }
}

TEST_CASE("A run back in time ends where it began") {
  const Network network = bar(2, 2, 5);
  const Positions u = noise(network, 0.03);
  Leapfrog motion(glnsm, network, {}, 0.2, {}, u, zero(network));
  for (int step = 0; step < 500; ++step) motion.step();
  CHECK((motion.displacement() - u).cwiseAbs().maxCoeff() > 1e-3);
  motion.reverse();
  for (int step = 0; step < 500; ++step) motion.step();
  CHECK((motion.displacement() - u).cwiseAbs().maxCoeff() < 1e-10);
}

TEST_CASE("n sub-steps of dt/n are n steps of dt/n") {
  const Network network = bar(2, 2, 3);
  const Positions u = noise(network, 0.02);
  Leapfrog divided(glsm, network, {}, 0.8, {4, 0.0}, u, zero(network));
  Leapfrog fine(glsm, network, {}, 0.2, {}, u, zero(network));
  for (int step = 0; step < 50; ++step) divided.step();
  for (int step = 0; step < 200; ++step) fine.step();
  CHECK(divided.displacement() == fine.displacement());
}

TEST_CASE(
    "Automatic sub-steps keep the step below the safe part of the linear limit, and rise with compression") {
  const Network network = bar(2, 2, 3);
  Positions squeezed = zero(network);
  squeezed.col(2) = -0.1 * network.rest.col(2);
  const double omega = largest_frequency(glnsm, network, zero(network), nothing_held(network), 1.0);
  Leapfrog relaxed(glnsm, network, {}, 1.0, {1, 0.25}, zero(network), zero(network));
  CHECK(relaxed.substeps() == static_cast<int>(std::ceil(omega / 0.5)));
  Leapfrog tense(glnsm, network, {}, 1.0, {1, 0.25}, squeezed, zero(network));
  CHECK(tense.substeps() > relaxed.substeps());
}

TEST_CASE("Automatic sub-steps follow the stiffest bond during a run, up and down") {
  // A bond that swings about its rest is stiffer while it is short and softer while it is long.
  const Network pair = cubic_lattice({{1, 1, 2}, 1.0});
  Positions v = zero(pair);
  v(1, 2) = -0.05;
  Leapfrog motion({paper_fene, 0.0}, pair, {}, 1.0, {1, 0.02}, zero(pair), v);
  const int at_start = motion.substeps();
  int most = at_start, least_after = at_start;
  for (int step = 0; step < 400; ++step) {
    motion.step();
    if (motion.substeps() > most) least_after = most = motion.substeps();
    least_after = std::min(least_after, motion.substeps());
  }
  CHECK(most > at_start);
  CHECK(least_after < most);
}

TEST_CASE(
    "Held nodes stay, driven nodes go where they are told, a loaded body with drag ends at its static "
    "response") {
  const Network network = bar(2, 2, 4);
  Conditions conditions;
  conditions.fixed = nothing_held(network);
  conditions.fixed.topRows(4).setConstant(true);
  conditions.load = zero(network);
  conditions.load.col(0).tail(4).setConstant(1e-7);
  conditions.drag = 0.15;
  Leapfrog motion(glsm, network, conditions, 0.5, {}, zero(network), zero(network));
  for (int step = 0; step < 40000; ++step) motion.step();
  CHECK(motion.displacement().topRows(4).cwiseAbs().maxCoeff() == 0.0);
  const Positions still = linear_response(glsm, network, conditions.fixed, conditions.load);
  CHECK((motion.displacement() - still).cwiseAbs().maxCoeff() < 1e-5 * still.cwiseAbs().maxCoeff());

  Conditions driven;
  driven.drive = Drive{{15}, 1, 0.01, 0.05, 40.0};
  Leapfrog stroke(glsm, network, driven, 0.5, {2, 0.0}, zero(network), zero(network));
  for (int step = 0; step < 100; ++step) {
    stroke.step();
    CHECK(stroke.displacement()(15, 1) ==
          Approx(driven.drive->at(stroke.time())).epsilon(1e-12).margin(1e-16));
  }
  CHECK(stroke.displacement()(0, 1) != 0.0);
}

TEST_CASE("Drag alone slows a body down by exp(-gamma t/m), to second order in the sub-step") {
  const Network pair = cubic_lattice({{1, 1, 2}, 1.0});
  constexpr double gamma = 0.05, mass = 2.0, start = 1e-3;
  Positions v = zero(pair);
  v.col(0).setConstant(start);  // both alike, so that their bond is not strained
  Conditions conditions;
  conditions.node_mass = mass;
  conditions.drag = gamma;
  const double left = std::exp(-gamma * 40.0 / mass), way = start * mass / gamma * (1.0 - left);
  const auto error = [&](int substeps) {
    Leapfrog motion(glsm, pair, conditions, 1.0, {substeps}, zero(pair), v);
    for (int step = 0; step < 40; ++step) motion.step();
    CHECK(motion.velocity()(0, 0) == Approx(start * left).epsilon(1e-4));
    return std::abs(motion.displacement()(1, 0) / way - 1.0);
  };
  const double coarse = error(1), fine = error(3);
  CHECK(coarse < std::pow(gamma / mass, 2));
  CHECK(coarse / fine == Approx(9.0).epsilon(0.05));
}

TEST_CASE("A bond that leaves its domain stops the run with step, nodes, length and bounds") {
  const Network pair = cubic_lattice({{1, 1, 2}, 1.0});
  Positions v = zero(pair);
  v(1, 2) = 1.0;
  Leapfrog motion({paper_fene, 0.0}, pair, {}, 1.0, {}, zero(pair), v);
  CHECK_THROWS_WITH(
      [&] {
        for (int step = 0; step < 10; ++step) motion.step();
      }(),
      ContainsSubstring("step 1: bond of nodes 0 and 1 has length"));
  CHECK(motion.steps() == 0);
}

TEST_CASE("A step that would take a bond to its limit is made anew in more sub-steps") {
  const Network pair = cubic_lattice({{1, 1, 2}, 1.0});
  Positions v = zero(pair);
  v(1, 2) = 0.15;  // in two steps beyond the largest length
  v(0, 2) = -0.15;
  Leapfrog plain({paper_fene, 0.0}, pair, {}, 1.0, {}, zero(pair), v);
  CHECK_THROWS_AS(
      [&] {
        for (int step = 0; step < 100; ++step) plain.step();
      }(),
      NumericalFailure);
  Leapfrog refusing({paper_fene, 0.0}, pair, {}, 1.0, {.most = 1024}, zero(pair), v);
  const double start = refusing.kinetic_energy() + refusing.potential_energy();
  double farthest = 0.0;
  for (int step = 0; step < 100; ++step) {
    refusing.step();
    farthest = std::max(farthest, std::abs(refusing.kinetic_energy() + refusing.potential_energy() - start));
    CHECK(refusing.momentum().norm() < 1e-14);
  }
  CHECK(refusing.steps() == 100);
  CHECK(farthest < 0.8 * start);  // no energy is made without bound; it is not kept to digits either
}

TEST_CASE("Steps that are not refused are the same bit by bit, whether or not they could be") {
  const Network network = bar(2, 2, 3);
  const Positions u = noise(network, 0.02);
  Leapfrog plain(glnsm, network, {}, 0.5, {2, 0.0}, u, zero(network));
  Leapfrog wary(glnsm, network, {}, 0.5, {.count = 2, .most = 64}, u, zero(network));
  for (int step = 0; step < 50; ++step) {
    plain.step();
    wary.step();
  }
  CHECK(plain.displacement() == wary.displacement());
  CHECK(plain.velocity() == wary.velocity());
}

TEST_CASE("A step that is refused in all sub-steps that are allowed ends the run where it began") {
  const Network pair = cubic_lattice({{1, 1, 2}, 1.0});
  Positions v = zero(pair);
  v(1, 2) = 1.0;
  Leapfrog motion({paper_fene, 0.0}, pair, {}, 1.0, {.most = 2}, zero(pair), v);
  CHECK_THROWS_WITH(motion.step(), ContainsSubstring("step 1: refused in 2 sub-steps, and no more than 2 are "
                                                     "allowed: "));
  CHECK(motion.steps() == 0);
  CHECK(motion.displacement() == zero(pair));
}

TEST_CASE("A step of another length than the one before keeps second order") {
  // v is carried from the middle of one sub-step to the middle of the next.
  const Network pair = cubic_lattice({{1, 1, 2}, 1.0});
  Positions v = zero(pair);
  v(1, 2) = 0.02;
  v(0, 2) = -0.02;
  const auto at_end = [&](double dt) {
    Leapfrog motion({bond::Harmonic{0.26, 1.0}, 0.0}, pair, {}, dt, {}, zero(pair), v);
    const int steps = static_cast<int>(std::lround(4.0 / dt));
    for (int i = 0; i < steps; ++i) {
      Integrator::State state = motion.state();
      state.substeps = i % 2 == 0 ? 1 : 2;
      motion.restore(state);
      motion.step();
    }
    return motion.displacement()(1, 2);
  };
  const double omega = std::sqrt(2.0 * 0.26), exact = 0.02 / omega * std::sin(4.0 * omega);
  const double coarse = std::abs(at_end(0.1) - exact), fine = std::abs(at_end(0.05) - exact);
  CHECK(coarse / fine == Approx(4.0).epsilon(0.1));
}

TEST_CASE("Linear response of a chain of straight angles is the sum of its hinges: P sum j^2 / k_a") {
  const int n = 12;  // two clamped nodes and 10 levers
  Network chain = cubic_lattice({{1, 1, n}, 1.0});
  add_angles(chain);
  FixedDofs held = nothing_held(chain);
  held.topRows(2).setConstant(true);
  Positions load = zero(chain);
  load(n - 1, 0) = 1.0;
  const Positions u = linear_response(glsm, chain, held, load);
  double sum = 0.0;
  for (int j = 1; j <= n - 2; ++j) sum += j * j;
  CHECK(u(n - 1, 0) == Approx(sum / 0.025).epsilon(1e-11));
}

TEST_CASE(
    "Nodes that coincide and angles that fold back stop a motion with their nodes, at the start and later") {
  Network chain = cubic_lattice({{1, 1, 3}, 1.0});
  add_angles(chain);
  Positions coincident = zero(chain);
  coincident(2, 2) = -1.0;
  CHECK_THROWS_WITH(Leapfrog(glsm, chain, {}, 0.1, {}, coincident, zero(chain)),
                    ContainsSubstring("start: nodes 1 and 2 of a bond coincide"));
  CHECK_THROWS_WITH(largest_frequency(glsm, chain, coincident, nothing_held(chain), 1.0),
                    ContainsSubstring("no Hessian: nodes 1 and 2 of a bond coincide"));
  // The last node flies through its neighbour: within one step of 1 it is on the other side.
  Positions v = zero(chain);
  v(2, 2) = -1.5;
  Leapfrog motion(glsm, chain, {}, 1.0, {}, zero(chain), v);
  CHECK_THROWS_WITH(
      motion.step(),
      ContainsSubstring("step 1: angle of nodes 0, 1 and 2 is folded back (0 degrees, 180 at rest)"));
}
