#include "coupling/transfer.hpp"

#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "base/error.hpp"
#include "bond/harmonic.hpp"
#include "catch.hpp"
#include "scene/markers.hpp"
#include "scene/simulation.hpp"
#include "solid/network.hpp"
#include "thread_count.hpp"

using namespace veriflex;
using namespace veriflex::coupling;

namespace {

const std::array<bool, 3> periodic{false, false, false};
const Grid box{{12, 9, 7}};

/// Markers anywhere, also several box lengths away, and in clusters that share nodes.
Positions scattered(int count, double extent, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-extent, extent);
  return Positions::NullaryExpr(count, 3, [&] { return place(random); });
}

double weight_directly(Delta delta, const Vec3& X, const Vec3& x) {
  return visit(delta, [&](auto kernel) {
    double weight = 1.0;
    Vec3 distance;
    for (int axis = 0; axis < 3; ++axis) {
      const auto size = static_cast<double>(box.size[static_cast<std::size_t>(axis)]);
      distance[axis] = std::remainder(x[axis] - X[axis], size);
      weight *= kernel.phi(distance[axis]);
    }
    return kernel.in_ball && distance.norm() >= 2.0 ? 0.0 : weight;
  });
}

}  // namespace

TEST_CASE("Each distinct node under the supports stands in the list once, and has the kernel's weight") {
  for (const Named<Delta>& row : deltas) {
    const Delta delta = row.value;
    const Positions X = scattered(6, 40.0, 3);
    Transfer transfer(box, periodic, delta);
    transfer.locate(scattered(20, 5.0, 1));  // leaves nothing behind
    transfer.locate(X);
    const auto nodes = transfer.nodes();
    CHECK(std::set<std::int64_t>(nodes.begin(), nodes.end()).size() == nodes.size());
    for (Eigen::Index m = 0; m < X.rows(); ++m) {
      Positions force = Positions::Zero(X.rows(), 3);
      force(m, 1) = 1.0;
      Positions spread;
      transfer.spread(force, spread);
      for (std::int64_t node = 0; node < box.count(); ++node) {
        const auto at = box.node(node);
        const double expected =
            weight_directly(delta, X.row(m), {double(at[0]), double(at[1]), double(at[2])});
        const auto found = std::find(nodes.begin(), nodes.end(), node);
        const double weight = found == nodes.end() ? 0.0 : spread(found - nodes.begin(), 1);
        CHECK(std::abs(weight - expected) < 1e-13);
      }
    }
  }
}

TEST_CASE("Spreading is the adjoint of interpolating") {
  for (const Named<Delta>& row : deltas) {
    const Delta delta = row.value;
    const Positions X = scattered(40, 30.0, 5);
    Transfer transfer(box, periodic, delta);
    transfer.locate(X);
    const Positions u = Positions::Random(static_cast<Eigen::Index>(transfer.nodes().size()), 3);
    const Positions F = Positions::Random(X.rows(), 3);
    Positions g, at_markers;
    transfer.spread(F, g);
    transfer.interpolate(u, at_markers);
    CHECK(g.cwiseProduct(u).sum() == Approx(F.cwiseProduct(at_markers).sum()).epsilon(1e-12));
  }
}

TEST_CASE("Many markers share their work among threads, and every sum is the same") {
  const Grid wide{{40, 30, 50}};
  const Positions X = scattered(6000, 30.0, 6);
  const auto with = [&](int threads) {
    const unit::Threads some(threads);
    Transfer transfer(wide, periodic, Delta::Cosine);
    transfer.locate(X);
    Positions g, at_markers;
    transfer.spread(X, g);
    transfer.interpolate(g, at_markers);
    return std::pair(g, at_markers);
  };
  const auto alone = with(1);
  for (const int threads : {2, 3, 7}) CHECK(with(threads) == alone);
}

TEST_CASE("A body and the fluid together keep their momentum to round-off") {
  for (const bool subcycled : {false, true}) {
    solid::Network network = solid::cubic_lattice({{3, 3, 6}, 1.0});
    solid::add_angles(network);
    scene::Body body{{bond::Harmonic{0.26, 1.0}, 0.025}, network, {}, {4, 0.0}};
    body.conditions.load = Positions::Zero(network.node_count(), 3);
    body.conditions.load(0, 0) = 1e-3;  // inner forces only
    body.conditions.load(1, 0) = -1e-3;
    body.place = {14.3, 8.2, 9.9};
    body.coupling = {.subcycled = subcycled};
    scene::Simulation simulation(
        {.fluid = fluid::Spec{.grid = {{16, 10, 12}}, .relaxation_time = 0.8}, .bodies = {body}});
    for (int step = 0; step < 200; ++step) simulation.advance();
    CHECK(simulation.momentum().norm() < 1e-14);
    CHECK(simulation.body().exchanged().norm() > 1e-9);
  }
}

TEST_CASE("Over ten thousand steps the momentum of body and fluid together moves by round-off only") {
  // Two loads that are no couple's pair would be seen at once; these turn and shear the body for ever.
  solid::Network network = solid::cubic_lattice({{2, 2, 4}, 1.0});
  solid::add_angles(network);
  scene::Body body{{bond::Harmonic{0.26, 1.0}, 0.025}, network, {}, {2, 0.0}};
  body.conditions.load = Positions::Zero(network.node_count(), 3);
  body.conditions.load(0, 0) = 1e-3;
  body.conditions.load(network.node_count() - 1, 0) = -1e-3;
  body.place = {9.3, 7.2, 6.9};
  body.coupling.emplace();
  scene::Simulation simulation(
      {.fluid = fluid::Spec{.grid = {{10, 8, 8}}, .relaxation_time = 0.8}, .bodies = {body}});
  double greatest = 0.0;
  for (int step = 0; step < 10000; ++step) {
    simulation.advance();
    greatest = std::max(greatest, simulation.body().solid().momentum().norm());
  }
  CHECK(greatest > 1e-6);
  CHECK(simulation.momentum().norm() < 1e-14);
}

TEST_CASE("Listed nodes are coupled, and a list that names no node of the body is refused") {
  scene::Body body{.material = {bond::Harmonic{0.26, 1.0}, 0.0},
                   .network = solid::cubic_lattice({{2, 2, 4}, 1.0}),
                   .coupling = scene::CouplingSpec{.coupled = scene::Coupled::Listed, .listed = {7, 3}}};
  CHECK(scene::coupled_nodes(body) == std::vector<std::int32_t>{3, 7});
  body.coupling->listed = {16};
  CHECK_THROWS_WITH(scene::coupled_nodes(body), ContainsSubstring("lists node 16"));
  body.coupling->listed = {2, 2};
  CHECK_THROWS_WITH(scene::coupled_nodes(body), ContainsSubstring("node 2 twice"));
}

TEST_CASE("Markers at one place share all nodes of their supports, the first one included") {
  for (const Named<Delta>& row : deltas) {
    Transfer transfer(box, periodic, row.value);
    const Vec3 place(5.2, 4.4, 3.7);
    transfer.locate(place.transpose());
    const std::vector<std::int64_t> alone(transfer.nodes().begin(), transfer.nodes().end());
    transfer.locate(place.transpose().replicate(3, 1));
    CHECK(std::vector<std::int64_t>(transfer.nodes().begin(), transfer.nodes().end()) == alone);
  }
}

TEST_CASE("A marker whose support leaves a walled box stops the run with its place") {
  Transfer transfer(box, {false, true, false}, Delta::Cosine);
  const Positions good = Positions::Constant(3, 3, 4.0);
  transfer.locate(good);
  for (const int marker : {0, 1, 2}) {
    Positions X = good;
    X(marker, 1) = 0.5;
    const std::string name = "marker " + std::to_string(marker);
    CHECK_THROWS_WITH(transfer.locate(X), ContainsSubstring(name + " is at y = 0.5"));
    X(marker, 1) = NAN;
    CHECK_THROWS_WITH(transfer.locate(X),
                      ContainsSubstring(name) && ContainsSubstring("no place in the box"));
  }
}

TEST_CASE("Turning a body keeps its handedness and lays its axis along the one asked for") {
  const Positions frame = Mat3::Identity();
  for (int axis = 0; axis < 3; ++axis) {
    const Mat3 turned = scene::turned(frame, axis);
    CHECK(turned.determinant() == 1.0);
    CHECK(turned(2, axis) == 1.0);
  }
}
