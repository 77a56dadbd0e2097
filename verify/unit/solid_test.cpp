#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>

#include "base/error.hpp"
#include "bond/derive.hpp"
#include "catch.hpp"
#include "solid/elastic.hpp"
#include "solid/statics.hpp"
#include "solid/tension_test.hpp"

using namespace veriflex;
using namespace veriflex::solid;

namespace {

const bond::AnyLaw fene_lj = bond::make_law("fene-lj", [](const std::string& name) -> std::optional<double> {
  return name == "epsilon" || name == "sigma" ? std::optional(1.0) : std::nullopt;
});
const bond::AnyLaw harmonic = bond::Harmonic{0.26, 1.0};
const bond::AnyLaw shifted = bond::ShiftedFene{0.26, 1.0, 0.5};

Block block_of(const bond::AnyLaw& law, std::int64_t n, std::int64_t m, std::int64_t l) {
  return {{n, m, l}, bond::derive(law).rest_length};
}

Positions noise(Eigen::Index nodes, double amplitude) {
  std::mt19937 random(20141);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Positions u(nodes, 3);
  for (double& component : u.reshaped()) component = amplitude * uniform(random);
  return u;
}

double energy_at(const Material& material, const Network& network, const Positions& u) {
  return visit(material, [&](const auto& law, const auto& angle) {
    Workspace work;
    REQUIRE(deform(law, network, u, work));
    return energy(law, angle, network, work);
  });
}

Positions gradient_at(const Material& material, const Network& network, const Positions& u) {
  return visit(material, [&](const auto& law, const auto& angle) {
    Workspace work;
    Positions g;
    REQUIRE(deform(law, network, u, work));
    REQUIRE(gradient(law, angle, network, work, g));
    return g;
  });
}

Eigen::MatrixXd hessian_at(const Material& material, const Network& network, const Positions& u) {
  return visit(material, [&](const auto& law, const auto& angle) {
    Workspace work;
    REQUIRE(deform(law, network, u, work));
    const auto entries = hessian(law, angle, network, work);
    Eigen::SparseMatrix<double> sparse(u.size(), u.size());
    sparse.setFromTriplets(entries.begin(), entries.end());
    return Eigen::MatrixXd(sparse);
  });
}

// Each law with and without angles.
std::vector<Material> materials() {
  return {{harmonic, 0.0},   {fene_lj, 0.0},  {shifted, 0.0},
          {harmonic, 0.025}, {fene_lj, 95.0}, {shifted, 0.025}};
}

Network block_network(const Material& material, std::int64_t n, std::int64_t m, std::int64_t l) {
  Network network = cubic_lattice(block_of(material.law, n, m, l));
  if (material.angle_stiffness > 0.0) add_angles(network);
  return network;
}

Positions no_load(const Network& network) { return Positions::Zero(network.node_count(), 3); }

}  // namespace

TEST_CASE("A block of n x m x l nodes has the nodes and bonds of a cubic lattice") {
  const Block block{{4, 3, 12}, 0.96};
  const Network network = cubic_lattice(block);
  CHECK(network.node_count() == 144);
  CHECK(static_cast<std::int64_t>(network.bonds.size()) == block.bond_count());
  CHECK(block.bond_count() == 3 * 3 * 12 + 4 * 2 * 12 + 4 * 3 * 11);
  for (std::size_t b = 0; b < network.bonds.size(); ++b) {
    const Vec3 vector = network.vectors.row(static_cast<Eigen::Index>(b));
    CHECK(network.bonds[b].first < network.bonds[b].second);
    CHECK(vector.norm() == 0.96);
    const Vec3 between = network.rest.row(network.bonds[b].second) - network.rest.row(network.bonds[b].first);
    CHECK((between - vector).norm() < 1e-14);
  }
  CHECK(cubic_lattice({{1, 1, 2}, 1.0}).bonds.size() == 1);
  CHECK(cubic_lattice({{1, 1, 9}, 1.0}).bonds.size() == 8);
}

TEST_CASE(
    "The paper's filament: 21 nodes a section, 1071 nodes, 2682 bonds, 11203 angles, 630 nodes on its "
    "surface") {
  Network rod = rod_lattice({2.5, 51, 1.0});
  CHECK(rod.node_count() == 1071);
  CHECK(rod.bonds.size() == 2682);
  CHECK(rod.angles.empty());
  add_angles(rod);
  CHECK(rod.angles.size() == 11203);
  CHECK(std::count_if(rod.angles.begin(), rod.angles.end(), [](const Angle& a) { return a.straight; }) ==
        2151);
  CHECK(boundary_nodes(rod).size() == 630);
  CHECK(rod_lattice({2.5, 1, 1.0}).node_count() == 21);
  CHECK(rod.rest.col(0).head(21).squaredNorm() == 34.0);  // sum of x^2 over a section
  CHECK(rod.rest.colwise().sum().head(2).norm() < 1e-10);
}

TEST_CASE("Counts of absurd blocks saturate instead of overflowing") {
  CHECK(Block{{1'000'000'000'000, 1'000'000'000'000, 2}, 1.0}.node_count() ==
        std::numeric_limits<std::int64_t>::max());
}

TEST_CASE("Forces are minus the gradient of the energy, and add up to no force and no torque") {
  for (const Material& material : materials()) {
    const Network network = block_network(material, 3, 2, 4);
    const Positions u = noise(network.node_count(), 0.05);
    const Positions g = gradient_at(material, network, u);
    const double scale = g.cwiseAbs().maxCoeff();
    for (const Eigen::Index i : {0, 7, 40, 71}) {
      const Derivative d = central_derivative(
          [&](double value) {
            Positions moved = u;
            moved.data()[i] = value;
            return energy_at(material, network, moved);
          },
          u.data()[i], 1e-4);
      CHECK(std::abs(d.value - g.data()[i]) <= 10.0 * d.error + 1e-9 * scale);
    }
    const double rounding = 1e-15 * scale * static_cast<double>(network.bonds.size());
    CHECK(g.colwise().sum().norm() <= rounding);
    Vec3 torque = Vec3::Zero();
    for (Eigen::Index i = 0; i < g.rows(); ++i) {
      torque += Vec3(network.rest.row(i) + u.row(i)).cross(Vec3(g.row(i)));
    }
    CHECK(torque.norm() <= 10.0 * rounding);
  }
}

TEST_CASE("The Hessian is the derivative of the gradient, and symmetric") {
  for (const Material& material : materials()) {
    const Network network = block_network(material, 2, 3, 3);
    for (const double amplitude : {0.05, 0.0}) {  // 0: every straight angle at exactly 180 degrees
      const Positions u = noise(network.node_count(), amplitude);
      const Eigen::MatrixXd h = hessian_at(material, network, u);
      const double scale = h.cwiseAbs().maxCoeff();
      CHECK((h - h.transpose()).cwiseAbs().maxCoeff() <= 1e-14 * scale);
      const double step = 1e-5;
      for (const Eigen::Index i : {0, 10, 26, 53}) {
        Positions up = u;
        Positions down = u;
        up.data()[i] += step;
        down.data()[i] -= step;
        const Positions difference =
            (gradient_at(material, network, up) - gradient_at(material, network, down)) / (2.0 * step);
        CHECK((difference.reshaped() - h.col(i)).cwiseAbs().maxCoeff() <= 1e-6 * scale);
      }
    }
  }
}

TEST_CASE("The energy does not change when the body is moved or turned") {
  const Material material{fene_lj, 95.0};
  const Network network = block_network(material, 3, 3, 3);
  const Positions u = noise(network.node_count(), 0.05);
  const double before = energy_at(material, network, u);
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
  const Positions x = network.rest + u;
  const Positions turned = (x * turn.transpose()).rowwise() + Vec3(3.0, -2.0, 5.0).transpose();
  CHECK(energy_at(material, network, turned - network.rest) == Approx(before).epsilon(1e-13));
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

TEST_CASE("Near the limits of a law a bar still pulls as one bond does") {
  // Within 5 % of a limit, where an uneven start could leave the domain or turn bonds round.
  for (const auto& [law, strain] : {std::pair{harmonic, -0.96},
                                    {harmonic, -0.9999},
                                    {shifted, 0.48},
                                    {shifted, -0.4999},
                                    {fene_lj, 0.56},
                                    {fene_lj, -0.55}}) {
    for (const Block& bar : {block_of(law, 3, 3, 10), block_of(law, 1, 1, 3)}) {
      const Pulled p = pull_to_strain(law, bar, true, strain);
      const double r = bar.spacing * (1.0 + strain);
      INFO(bond::name_of(law) << " at " << strain);
      CHECK(p.stress * bar.spacing * bar.spacing == Approx(bond::tension(law, r)).epsilon(1e-9));
    }
  }
  CHECK(pull_to_strain(harmonic, block_of(harmonic, 3, 3, 10), true, -0.96).stress ==
        Approx(-0.2496).epsilon(1e-9));
}

TEST_CASE("An equilibrium whose bonds have turned round is refused") {
  const Network network = cubic_lattice(block_of(harmonic, 1, 1, 3));
  Positions u = no_load(network);
  u(1, 2) = 1.5;
  CHECK_THROWS_WITH(refuse_turned_bonds(network, u),
                    ContainsSubstring("bond of nodes 1 and 2 has turned round"));
  u(1, 2) = 0.5;
  CHECK_NOTHROW(refuse_turned_bonds(network, u));
}

TEST_CASE("Forces beyond double precision are no equilibrium") {
  CHECK_THROWS_AS(pull_with_stress(harmonic, {{3, 3, 3}, 1e200}, true, 1e200), NumericalFailure);
}

TEST_CASE("The stress is the derivative of the stored energy by the length") {
  const Block bar = block_of(fene_lj, 2, 3, 6);
  const Network network = cubic_lattice(bar);
  const auto stored = [&](double strain) {
    Positions u = no_load(network);
    u.col(2) = strain * network.rest.col(2);
    return energy_at({fene_lj, 0.0}, network, u);
  };
  for (const double strain : {-0.1, 0.05, 0.3}) {
    const Derivative d = central_derivative(stored, strain, 1e-4);
    CHECK(pull_to_strain(fene_lj, bar, true, strain).stress * bar.section() * bar.length() ==
          Approx(d.value).epsilon(1e-8));
  }
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
  const double r_max = *bond::derive(fene_lj).strain_at_r_max;
  for (const double stress : {1e3, 1e5, 1e7}) {
    const Pulled p = pull_with_stress(fene_lj, chain, true, stress);
    CHECK(p.strain < r_max);
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
  const Network network = cubic_lattice(block_of(fene_lj, 1, 1, 6));
  FixedDofs held = FixedDofs::Constant(6, 3, false);
  held.row(0).setConstant(true);
  held.row(5).setConstant(true);
  Positions u = no_load(network);
  u.col(2) = 0.1 * network.rest.col(2);
  u(2, 0) = 0.1;
  u(3, 1) = -0.05;
  const Equilibrium e = equilibrium({fene_lj, 0.0}, network, u, held, no_load(network));
  CHECK(e.u.leftCols(2).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(e.residual <= 1e-12);
  CHECK(e.reaction.colwise().sum().norm() < 1e-10);
}

TEST_CASE("The equilibrium does not depend on where the search starts") {
  const Block bar = block_of(fene_lj, 2, 2, 8);
  const Network network = cubic_lattice(bar);
  FixedDofs held = FixedDofs::Constant(bar.node_count(), 3, true);
  held.col(2).segment(4, bar.node_count() - 8).setConstant(false);
  const double expected = pull_to_strain(fene_lj, bar, true, 0.2).stress;
  Positions u = no_load(network);
  u.col(2) = 0.2 * network.rest.col(2);
  const Positions off = noise(u.rows(), 0.05);
  for (Eigen::Index i = 0; i < u.rows(); ++i) {
    if (!held(i, 2)) u(i, 2) += off(i, 2);
  }
  const Equilibrium e = equilibrium({fene_lj, 0.0}, network, u, held, no_load(network));
  CHECK(e.reaction.col(2).tail(4).sum() / bar.section() == Approx(expected).epsilon(1e-12));
}

TEST_CASE("A start outside the law's domain is refused") {
  const Network network = cubic_lattice(block_of(fene_lj, 1, 1, 3));
  Positions u = no_load(network);
  u(2, 2) = 0.6;
  CHECK_THROWS_WITH(
      equilibrium({fene_lj, 0.0}, network, u, FixedDofs::Constant(3, 3, true), no_load(network)),
      ContainsSubstring("bond of nodes 1 and 2 has length 1.56"));
}

TEST_CASE("With angles a lattice at rest has no zero modes but its six rigid motions") {
  const Material material{harmonic, 0.025};
  const Network network = block_network(material, 3, 2, 3);
  const Eigen::MatrixXd h = hessian_at(material, network, no_load(network));
  const Eigen::VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(h).eigenvalues();
  CHECK(eigenvalues.head(6).cwiseAbs().maxCoeff() < 1e-14);
  CHECK(eigenvalues[6] > 1e-4);
  CHECK_THROWS_WITH(
      equilibrium(material, network, no_load(network), FixedDofs::Constant(18, 3, false), no_load(network)),
      ContainsSubstring("mechanism: 6 zero modes"));
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

TEST_CASE(
    "A static solution says what is undefined at its start: which nodes coincide, which angle is folded "
    "back") {
  Network chain = cubic_lattice({{1, 1, 4}, 1.0});
  add_angles(chain);
  const FixedDofs held = FixedDofs::Constant(4, 3, false);
  const Material material{harmonic, 0.025};
  Positions coincident = no_load(chain);
  coincident(1, 2) = -1.0;
  CHECK_THROWS_WITH(equilibrium(material, chain, coincident, held, no_load(chain)),
                    ContainsSubstring("start of a static solution: nodes 0 and 1 of a bond coincide"));
  Positions folded = no_load(chain);
  folded(2, 2) = -1.5;
  CHECK_THROWS_WITH(equilibrium(material, chain, folded, held, no_load(chain)),
                    ContainsSubstring("angle of nodes 0, 1 and 2 is folded back (0 degrees, 180 at rest)"));
  Network flat = chain;
  for (Angle& angle : flat.angles) angle.straight = false;
  CHECK_THROWS_WITH(equilibrium(material, flat, no_load(chain), held, no_load(chain)),
                    ContainsSubstring("angle of nodes 0, 1 and 2 is flat (180 degrees, 90 at rest)"));
  Positions nan = no_load(chain);
  nan(3, 0) = std::nan("");
  CHECK_THROWS_WITH(equilibrium(material, chain, nan, held, no_load(chain)),
                    ContainsSubstring("bond of nodes 2 and 3 has length nan"));
}
