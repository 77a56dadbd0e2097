// The layer on an oscillating plate against its own equation and limits, and bodies without ends.
#include "analytic/elastic_layer.hpp"

#include <numbers>

#include "bond/harmonic.hpp"
#include "catch.hpp"
#include "scene/periodic_body.hpp"
#include "solid/leapfrog.hpp"

using namespace veriflex;
using Complex = std::complex<double>;
using analytic::ElasticLayer;
using analytic::Filling;
using std::numbers::pi;

namespace {

ElasticLayer layer(double shear_modulus, Filling filling) {
  return {.thickness = 20.0,
          .height = 60.0,
          .shear_modulus = shear_modulus,
          .density = 2.0,
          .fluid_density = 1.0,
          .viscosity = 1.0 / 6.0,
          .omega = 2.0 * pi / 4000.0,
          .filling = filling};
}

Complex lambda_of(const ElasticLayer& l) { return std::sqrt(Complex(0.0, l.omega / l.viscosity)); }

double energy_of(const solid::Network& network, const Positions& u) {
  const solid::Material material{bond::Harmonic{0.26, network.spacing}, 0.025};
  const Positions rest = Positions::Zero(u.rows(), 3);
  return solid::Leapfrog(material, network, {}, 1.0, {}, u, rest).potential_energy();
}

}  // namespace

TEST_CASE(
    "An elastic layer of almost nothing leaves the fluid that fills it alone with the plate and the wall") {
  ElasticLayer nothing = layer(1e-12, Filling::Moving);
  nothing.density = 1e-12;
  const Complex lambda = lambda_of(nothing);
  const Complex fluid = std::sinh(lambda * 40.0) / std::sinh(lambda * 60.0);
  CHECK(std::abs(interface_velocity(nothing) / fluid - 1.0) < 1e-8);
}

TEST_CASE("A stiff elastic layer moves with its plate, but for the shear that inertia and fluid ask for") {
  for (const Filling filling : {Filling::None, Filling::Moving, Filling::Between}) {
    const ElasticLayer stiff = layer(1e4, filling);
    const Complex lambda = lambda_of(stiff), i(0.0, 1.0);
    const double mu = stiff.viscosity, density = filling == Filling::Moving ? 3.0 : 2.0;
    Complex on_it = mu * lambda / std::tanh(lambda * 40.0);
    if (filling == Filling::Between) on_it += mu * lambda * std::tanh(lambda * 20.0);
    // G u' at y is what is above it needs: on_it + i omega rho (h - y).
    const Complex lost = i * stiff.omega / 1e4 * (on_it * 20.0 + 0.5 * i * stiff.omega * density * 400.0);
    CHECK(std::abs((1.0 - interface_velocity(stiff)) / lost - 1.0) < 1e-3);
  }
}

TEST_CASE("An elastic layer starts with its plate and ends with the interface") {
  for (const Filling filling : {Filling::None, Filling::Moving, Filling::Between}) {
    const ElasticLayer l = layer(0.05, filling);
    CHECK(std::abs(layer_velocity(l, 0.0) - 1.0) < 1e-15);
    CHECK(std::abs(layer_velocity(l, 20.0) - interface_velocity(l)) < 1e-13);
  }
}

TEST_CASE("An elastic layer and the fluid above move as the finite differences of their equations say") {
  for (const double G : {0.01, 0.05, 0.26}) {
    const ElasticLayer l = layer(G, Filling::Moving);
    constexpr std::size_t cells = 3000, inside = 1000;
    const double size = l.height / cells;
    const Complex i(0.0, 1.0);
    const auto modulus = [&](std::size_t cell) {  // stress over the gradient of velocity
      return l.viscosity + (cell < inside ? G / (i * l.omega) : Complex(0.0));
    };
    // Thomas' algorithm from the wall to the plate: v of a cell is `ratio` times that of the one below.
    std::vector<Complex> ratio(cells);
    Complex above = 2.0 * modulus(cells - 1), beyond = 0.0;
    for (std::size_t c = cells; c-- > 0;) {
      const Complex below = c > 0 ? 2.0 / (1.0 / modulus(c) + 1.0 / modulus(c - 1)) : 2.0 * modulus(c);
      const double density = c < inside ? 3.0 : 1.0;
      ratio[c] = below / (below + above * (1.0 - beyond) + i * l.omega * density * size * size);
      above = below;
      beyond = ratio[c];
    }
    Complex v = 1.0;
    for (std::size_t c = 0; c < inside; ++c) v *= ratio[c];
    CHECK(std::abs(v / layer_velocity(l, l.thickness - 0.5 * size) - 1.0) < 1e-5);
  }
}

TEST_CASE("A block that is bonded across the box shears with G = 4 k_a/r0^3 and has no ends there") {
  constexpr double gamma = 1e-5, r0 = 1.5;
  solid::Network network = solid::cubic_lattice({{3, 2, 4}, r0});
  const std::size_t before = network.bonds.size();
  scene::bond_across(network, 0);
  scene::bond_across(network, 1);
  CHECK(network.bonds.size() == before + 2 * 4 + 3 * 4);
  CHECK(network.vectors.rowwise().norm().isApproxToConstant(r0, 1e-15));
  CHECK(solid::boundary_nodes(network).size() == 2 * 6);  // the faces across z
  solid::add_angles(network);
  Positions u = Positions::Zero(network.node_count(), 3);
  u.col(1) = gamma * network.rest.col(2);
  const double volume = 6.0 * 3.0 * r0 * r0 * r0;  // of the three layers of cells between the nodes
  CHECK(energy_of(network, u) / (0.5 * gamma * gamma * volume) ==
        Approx(4.0 * 0.025 / (r0 * r0 * r0)).epsilon(1e-4));
  u.setConstant(0.3);
  CHECK(energy_of(network, u) == Approx(0.0).margin(1e-18));
}

TEST_CASE("Only rows of nodes that go from one end to the other are bonded across") {
  // The second row has a low end alone.
  solid::Network network;
  network.rest = (Positions(3, 3) << 0, 0, 0, 1, 0, 0, 0, 1, 0).finished();
  network.spacing = 1.0;
  network.vectors.resize(0, 3);
  scene::bond_across(network, 0);
  REQUIRE(network.bonds.size() == 1);
  CHECK(network.bonds[0].first == 0);
  CHECK(network.bonds[0].second == 1);
  CHECK(network.vectors.row(0) == Eigen::RowVector3d(-1.0, 0.0, 0.0));
}
