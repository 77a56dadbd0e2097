#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <cmath>
#include <random>

#include "base/error.hpp"
#include "bond/derive.hpp"
#include "catch.hpp"
#include "solid/bonds.hpp"
#include "solid/statics.hpp"
#include "solid/tension_test.hpp"

using namespace veriflex;
using namespace veriflex::solid;

namespace {

const bond::AnyLaw fene_lj = bond::make_law("fene-lj", [](const std::string& name) -> std::optional<double> {
  return name == "depth" || name == "diameter" ? std::optional(1.0) : std::nullopt;
});
const bond::AnyLaw harmonic = bond::Harmonic{0.26, 1.0};
const bond::AnyLaw shifted = bond::ShiftedFene{0.26, 1.0, 0.5};

Block block_of(const bond::AnyLaw& law, std::int64_t n, std::int64_t m, std::int64_t l) {
  return {{n, m, l}, bond::derive(law).rest_length};
}

Positions noise(Eigen::Index nodes, double amplitude) {
  std::mt19937 random(20141);
  std::uniform_real_distribution<double> uniform(-amplitude, amplitude);
  Positions u(3, nodes);
  for (double& component : u.reshaped()) component = uniform(random);
  return u;
}

template <class Use>
void with(const bond::AnyLaw& law, Use use) {
  std::visit(use, law);
}

}  // namespace

TEST_CASE("A block of n x m x l nodes has the nodes and bonds of a cubic lattice") {
  const Block block{{4, 3, 12}, 0.96};
  const Network network = cubic_lattice(block);
  CHECK(network.rest.cols() == 144);
  CHECK(static_cast<std::int64_t>(network.bonds.size()) == block.bond_count());
  CHECK(block.bond_count() == 3 * 3 * 12 + 4 * 2 * 12 + 4 * 3 * 11);
  for (const Bond& b : network.bonds) {
    CHECK(b.first < b.second);
    CHECK(b.vector.norm() == 0.96);
    CHECK((network.rest.col(b.second) - network.rest.col(b.first) - b.vector).norm() < 1e-14);
  }
  CHECK(cubic_lattice({{1, 1, 2}, 1.0}).bonds.size() == 1);
  CHECK(cubic_lattice({{1, 1, 9}, 1.0}).bonds.size() == 8);
}

TEST_CASE("Counts of absurd blocks saturate instead of overflowing") {
  CHECK(Block{{1'000'000'000'000, 1'000'000'000'000, 2}, 1.0}.node_count() ==
        std::numeric_limits<std::int64_t>::max());
}

TEST_CASE("Forces are minus the gradient of the energy, and add up to no force and no torque") {
  for (const bond::AnyLaw& any : {harmonic, fene_lj, shifted}) {
    with(any, [&](const auto& law) {
      const Network network = cubic_lattice(block_of(any, 3, 2, 4));
      Positions u = noise(network.rest.cols(), 0.05);
      const Positions g = gradient(law, network, u);
      const double scale = g.cwiseAbs().maxCoeff();
      for (const Eigen::Index i : {0, 7, 40, 71}) {
        const Derivative d = central_derivative(
            [&](double value) {
              Positions moved = u;
              moved.data()[i] = value;
              return energy(law, network, moved);
            },
            u.data()[i], 1e-4);
        CHECK(std::abs(d.value - g.data()[i]) <= 10.0 * d.error + 1e-9 * scale);
      }
      CHECK(g.rowwise().sum().norm() <= 1e-13 * scale * static_cast<double>(g.cols()));
      Vec3 torque = Vec3::Zero();
      for (Eigen::Index i = 0; i < g.cols(); ++i)
        torque += Vec3(network.rest.col(i) + u.col(i)).cross(Vec3(g.col(i)));
      CHECK(torque.norm() <= 1e-12 * scale * static_cast<double>(g.cols()));
    });
  }
}

TEST_CASE("The Hessian is the derivative of the gradient, and symmetric") {
  for (const bond::AnyLaw& any : {harmonic, fene_lj, shifted}) {
    with(any, [&](const auto& law) {
      const Network network = cubic_lattice(block_of(any, 2, 3, 3));
      const Positions u = noise(network.rest.cols(), 0.05);
      const auto entries = hessian(law, network, u);
      Eigen::SparseMatrix<double> sparse(u.size(), u.size());
      sparse.setFromTriplets(entries.begin(), entries.end());
      const Eigen::MatrixXd h(sparse);
      const double scale = h.cwiseAbs().maxCoeff();
      CHECK((h - h.transpose()).cwiseAbs().maxCoeff() <= 1e-15 * scale);
      const double step = 1e-5;
      for (const Eigen::Index i : {0, 10, 26, 53}) {
        Positions up = u;
        Positions down = u;
        up.data()[i] += step;
        down.data()[i] -= step;
        const Positions difference =
            (gradient(law, network, up) - gradient(law, network, down)) / (2.0 * step);
        CHECK((difference.reshaped() - h.col(i)).cwiseAbs().maxCoeff() <= 1e-6 * scale);
      }
    });
  }
}

TEST_CASE("The energy does not change when the body is moved or turned") {
  with(fene_lj, [&](const auto& law) {
    const Network network = cubic_lattice(block_of(fene_lj, 3, 3, 3));
    const Positions u = noise(network.rest.cols(), 0.05);
    const double before = energy(law, network, u);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
    const Positions x = network.rest + u;
    const Positions turned = (turn * x).colwise() + Vec3(3.0, -2.0, 5.0);
    CHECK(energy(law, network, turned - network.rest) == Approx(before).epsilon(1e-13));
  });
}

TEST_CASE("A pair held at a length pulls with the tension of its bond") {
  for (const bond::AnyLaw& law : {harmonic, fene_lj, shifted}) {
    const Block pair = block_of(law, 1, 1, 2);
    for (const double strain : {-0.2, -1e-3, 1e-6, 0.02, 0.4}) {
      const Pulled p = pull_to_strain(law, pair, true, strain);
      const double r = pair.spacing * (1.0 + strain);
      CHECK(p.stress * pair.section() == Approx(bond::tension(law, r)).epsilon(1e-9));
    }
  }
}

TEST_CASE("The stress is the derivative of the stored energy by the length") {
  with(fene_lj, [&](const auto& law) {
    const Block bar = block_of(fene_lj, 2, 3, 6);
    const Network network = cubic_lattice(bar);
    const auto stored = [&](double strain) {
      const Positions u = (network.rest.array().colwise() * Eigen::Array3d(0.0, 0.0, strain)).matrix();
      return energy(law, network, u);
    };
    for (const double strain : {-0.1, 0.05, 0.3}) {
      const Derivative d = central_derivative(stored, strain, 1e-4);
      CHECK(pull_to_strain(fene_lj, bar, true, strain).stress * bar.section() * bar.length() ==
            Approx(d.value).epsilon(1e-8));
    }
  });
}

TEST_CASE("Load control finds the strain that displacement control was given") {
  for (const bond::AnyLaw& law : {harmonic, fene_lj, shifted}) {
    const Block bar = block_of(law, 2, 2, 7);
    for (const double strain : {-0.15, -0.01, 0.003, 0.1, 0.4}) {
      const Pulled held = pull_to_strain(law, bar, true, strain);
      const Pulled loaded = pull_with_stress(law, bar, true, held.stress);
      CHECK(loaded.strain == Approx(strain).epsilon(1e-9));
      CHECK(held.residual <= 1e-12);
      CHECK(loaded.residual <= 1e-12);
    }
  }
}

TEST_CASE("However large the load, no step goes over the bond's limit") {
  const Block chain = block_of(fene_lj, 1, 1, 5);
  const double reach = *bond::derive(fene_lj).strain_at_reach;
  for (const double stress : {1e3, 1e5, 1e7}) {
    const Pulled p = pull_with_stress(fene_lj, chain, true, stress);
    CHECK(p.strain < reach);
    CHECK(p.strain > 0.4);
    CHECK(p.residual <= 1e-12);
  }
  CHECK(pull_with_stress(fene_lj, chain, true, -1e7).strain > -0.7);
}

TEST_CASE("Without angles a lattice at rest is a mechanism, and says how often") {
  // A chain whose first node is held: each other node can move two ways across the axis.
  CHECK_THROWS_WITH(pull_to_strain(fene_lj, block_of(fene_lj, 1, 1, 6), false, 0.0),
                    StartsWith("mechanism: 10 zero modes"));
  CHECK_THROWS_AS(pull_to_strain(harmonic, block_of(harmonic, 3, 3, 5), false, 0.0), NumericalFailure);
}

TEST_CASE("A compressed chain that may move sideways is unstable, and says how often") {
  CHECK_THROWS_WITH(pull_to_strain(fene_lj, block_of(fene_lj, 1, 1, 6), false, -0.01),
                    StartsWith("unstable: 10 negative"));
}

TEST_CASE("A stretched chain that may move sideways returns to its axis") {
  const Block chain = block_of(fene_lj, 1, 1, 6);
  const Network network = cubic_lattice(chain);
  Held held = Held::Constant(3, 6, false);
  held.col(0).setConstant(true);
  held.col(5).setConstant(true);
  Positions u = Positions::Zero(3, 6);
  u.row(2) = 0.1 * network.rest.row(2);
  u(0, 2) = 0.1;
  u(1, 3) = -0.05;
  const Equilibrium e = equilibrium(fene_lj, network, u, held, Positions::Zero(3, 6));
  CHECK(e.u.topRows(2).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(e.residual <= 1e-12);
  CHECK(e.reaction.rowwise().sum().norm() < 1e-10);
}

TEST_CASE("The equilibrium does not depend on where the search starts") {
  const Block bar = block_of(fene_lj, 2, 2, 8);
  const Network network = cubic_lattice(bar);
  Held held = Held::Constant(3, bar.node_count(), true);
  held.row(2).segment(4, bar.node_count() - 8).setConstant(false);
  const double expected = pull_to_strain(fene_lj, bar, true, 0.2).stress;
  Positions u = Positions::Zero(3, bar.node_count());
  u.row(2) = 0.2 * network.rest.row(2);
  const Positions off = noise(u.cols(), 0.05);
  for (Eigen::Index i = 0; i < u.cols(); ++i) {
    if (!held(2, i)) u(2, i) += off(2, i);
  }
  const Equilibrium e = equilibrium(fene_lj, network, u, held, Positions::Zero(3, u.cols()));
  CHECK(e.reaction.row(2).tail(4).sum() / bar.section() == Approx(expected).epsilon(1e-12));
}

TEST_CASE("A start outside the law's domain is refused") {
  const Network network = cubic_lattice(block_of(fene_lj, 1, 1, 3));
  Positions u = Positions::Zero(3, 3);
  u(2, 2) = 0.6;
  CHECK_THROWS_WITH(equilibrium(fene_lj, network, u, Held::Constant(3, 3, true), Positions::Zero(3, 3)),
                    ContainsSubstring("outside the domain"));
}

TEST_CASE("The modulus of a bar scales with powers of two bit for bit") {
  const Block unit = block_of(fene_lj, 2, 2, 5);
  const double eta = std::ldexp(1.0, -30);
  const double sigma = std::ldexp(1.0, 5);
  const bond::AnyLaw scaled = bond::rescaled(fene_lj, eta, sigma);
  const double stress = pull_to_strain(fene_lj, unit, true, 0.1).stress;
  const double other = pull_to_strain(scaled, {unit.nodes, unit.spacing * sigma}, true, 0.1).stress;
  CHECK(other / eta * sigma * sigma * sigma == stress);
}
