#include "fluid/fluid.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "base/error.hpp"
#include "catch.hpp"
#include "plain_fluid.hpp"

using namespace veriflex;
using namespace veriflex::fluid;

namespace {

std::vector<std::int64_t> all_nodes(const Spec& spec) {
  std::vector<std::int64_t> nodes(static_cast<std::size_t>(spec.grid.count()));
  std::iota(nodes.begin(), nodes.end(), 0);
  return nodes;
}

std::vector<Populations> populations_of(const Fluid& fluid) {
  const std::vector<std::int64_t> nodes = all_nodes(fluid.spec());
  std::vector<Populations> h(nodes.size());
  fluid.populations(nodes, h);
  return h;
}

/// The largest difference to the textbook over eight steps with a force at some nodes.
double departure_from_plain(const Spec& spec) {
  const std::unique_ptr<Fluid> fast = make_fluid(spec);
  PlainFluid plain(spec, disorder(0.1));
  fast->start(disorder(0.1));
  std::vector<std::int64_t> pushed;
  for (std::int64_t node = 0; node < spec.grid.count(); node += 5) pushed.push_back(node);
  Positions push(static_cast<Eigen::Index>(pushed.size()), 3);
  std::vector<Vec3> force(static_cast<std::size_t>(spec.grid.count()), Vec3::Zero());
  for (std::size_t i = 0; i < pushed.size(); ++i) {
    const Vec3 g =
        0.001 * Vec3(std::sin(3.0 * static_cast<double>(i)), 0.5, std::cos(static_cast<double>(i)));
    push.row(static_cast<Eigen::Index>(i)) = g;
    force[static_cast<std::size_t>(pushed[i])] = g;
  }
  double worst = 0.0;
  for (int step = 0; step < 8; ++step) {
    fast->collide_and_stream({pushed, &push});
    plain.step(force);
    const std::vector<Populations> h = populations_of(*fast);
    for (std::size_t node = 0; node < h.size(); ++node) {
      if (std::find(spec.obstacle.begin(), spec.obstacle.end(), node) != spec.obstacle.end()) continue;
      const Populations expected = plain.populations(static_cast<std::int64_t>(node));
      for (std::size_t q = 0; q < Q; ++q) {
        const double error = std::abs(h[node][q] - expected[q]);
        worst = error <= worst || std::isnan(worst) ? worst : error;
      }
    }
  }
  return worst;
}

Spec box(std::int64_t x, std::int64_t y, std::int64_t z, double relaxation_time = 0.8) {
  return {.grid = {{x, y, z}}, .relaxation_time = relaxation_time};
}

/// A fluid of populations and, at tau = 1, one of moments.
constexpr double of_either[] = {0.8, 1.0};

}  // namespace

TEST_CASE("The sweep is the textbook's collide and stream, whatever divides the row into lanes") {
  for (const std::int64_t nx : {1, 2, 3, 8, 12, 16, 32, 48}) {
    CAPTURE(nx);
    CHECK(departure_from_plain(box(nx, 5, 6)) < 1e-15);
  }
  CHECK(departure_from_plain(box(16, 1, 1)) < 1e-15);
  CHECK(departure_from_plain(box(8, 4, 1)) < 1e-15);
  Spec single = box(16, 4, 5);
  single.storage = Storage::Float;
  CHECK(departure_from_plain(single) < 1e-7);
}

TEST_CASE("A fluid that is started again is as one that never ran, after odd and even steps") {
  for (const double relaxation_time : of_either) {
    for (const std::int64_t before : {3, 4}) {
      CAPTURE(relaxation_time, before);
      const std::unique_ptr<Fluid> again = make_fluid(box(8, 4, 5, relaxation_time)),
                                   fresh = make_fluid(box(8, 4, 5, relaxation_time));
      again->start(disorder(0.1));
      again->advance(before);
      for (Fluid* fluid : {again.get(), fresh.get()}) {
        fluid->start(disorder(0.05));
        CHECK(fluid->steps() == 0);
        fluid->advance(3);
      }
      CHECK(again->steps() == 3);
      CHECK(populations_of(*again) == populations_of(*fresh));
    }
  }
}

TEST_CASE("Walls on any faces, at rest or sliding, are half-way bounce-back") {
  for (int closed = 1; closed < 8; ++closed) {
    for (const std::int64_t nx : {6, 8, 16}) {
      for (const bool moves : {false, true}) {
        Spec spec = box(nx, 4, 5);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if ((closed >> axis & 1) != 0) spec.walls[axis] = moves ? sliding() : Walls{};
        }
        CAPTURE(closed, nx, moves);
        CHECK(departure_from_plain(spec) < 1e-15);
      }
    }
  }
}

TEST_CASE(
    "Inflow is a wall that moves through itself, outflow the mean of what the last two nodes were given, "
    "beside "
    "walls, forces and obstacles") {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const std::int64_t nx : {1, 6, 8, 16}) {
      for (const double tau : of_either) {
        Spec spec = box(nx, 4, 5, tau);
        spec.walls[axis] = passage();
        CAPTURE(axis, nx, tau);
        CHECK(departure_from_plain(spec) < 1e-15);
        spec.walls[(axis + 1) % 3] = sliding();
        CHECK(departure_from_plain(spec) < 1e-15);
        if (nx > 1) spec.obstacle = {spec.grid.index(0, 0, 0), spec.grid.index(2, 1, 2)};
        CHECK(departure_from_plain(spec) < 1e-15);
      }
    }
  }
}

TEST_CASE("Obstacles turn populations back, beside walls too") {
  Spec spec = box(8, 6, 7);
  for (const std::int64_t z : {2, 3}) {
    for (const std::int64_t y : {0, 1, 3}) {
      for (const std::int64_t x : {0, 1, 4}) spec.obstacle.push_back(spec.grid.index(x, y, z));
    }
  }
  CHECK(departure_from_plain(spec) < 1e-15);
  spec.walls[0] = Walls{};
  spec.walls[1] = Walls{};
  CHECK(departure_from_plain(spec) < 1e-15);
}

TEST_CASE("The inside of an obstacle is at rest, whatever pushes there, and in no extreme or sum") {
  for (const double tau : of_either) {
    CAPTURE(tau);
    Spec spec = box(8, 6, 7, tau);
    spec.body_force = {0.01, 0.0, 0.0};
    for (const std::int64_t z : {2, 3}) {
      for (const std::int64_t y : {1, 2, 3}) {
        for (const std::int64_t x : {1, 2, 3}) spec.obstacle.push_back(spec.grid.index(x, y, z));
      }
    }
    const std::unique_ptr<Fluid> fluid = make_fluid(spec);
    const std::int64_t inner = spec.obstacle[4];
    fluid->start([inner](std::int64_t node) { return equilibrium(node == inner ? NAN : 1.0, Vec3::Zero()); });
    const std::vector<std::int64_t> pushed{inner};
    const Positions push = Positions::Constant(1, 3, 0.1);
    for (int step = 0; step < 7; ++step) fluid->collide_and_stream({pushed, &push});
    Positions u;
    fluid->velocities(spec.obstacle, u);
    CHECK(u.isZero(0.0));
    std::vector<Populations> h(spec.obstacle.size());
    fluid->populations(spec.obstacle, h);
    for (const Populations& here : h) CHECK(here == Populations{});
    const Extremes worst = fluid->extremes();
    CHECK(std::isfinite(worst.max_speed));
    CHECK(worst.min_density > 0.9);
    CHECK(std::isfinite(fluid->totals().mass_deviation));
    const std::vector<Populations> all = populations_of(*fluid);
    for (const Populations& here : all) CHECK(std::isfinite(density_deviation(here)));
  }
}

TEST_CASE("Both force schemes are the textbook's") {
  for (const Scheme scheme : {Scheme::FirstOrder, Scheme::Guo}) {
    Spec spec = box(8, 4, 5);
    spec.body_force = {1e-3, -2e-3, 5e-4};
    spec.scheme = scheme;
    CHECK(departure_from_plain(spec) < 1e-15);
    spec.walls[2] = Walls{};
    CHECK(departure_from_plain(spec) < 1e-15);
  }
}

TEST_CASE("Any number of threads gives the same populations bit for bit") {
  const int threads = omp_get_max_threads();
  for (const bool closed : {false, true}) {
    Spec spec = box(16, 5, 7);
    spec.body_force = {1e-3, 0.0, 0.0};
    if (closed) spec.walls[0] = sliding();
    std::vector<std::vector<Populations>> results;
    for (const int n : {1, 2, 3}) {
      omp_set_num_threads(n);
      const std::unique_ptr<Fluid> fluid = make_fluid(spec);
      fluid->start(disorder(0.1));
      for (int step = 0; step < 5; ++step) fluid->collide_and_stream();
      results.push_back(populations_of(*fluid));
    }
    omp_set_num_threads(threads);
    CHECK(results[1] == results[0]);
    CHECK(results[2] == results[0]);
  }
}

TEST_CASE("Mass and momentum stay to round-off, and a uniform force adds exactly itself") {
  for (const double tau : of_either) {
    CAPTURE(tau);
    Spec spec = box(16, 8, 8, tau);
    spec.body_force = {1e-5, 2e-5, -3e-5};
    for (const Scheme scheme : {Scheme::FirstOrder, Scheme::Guo}) {
      spec.scheme = scheme;
      const std::unique_ptr<Fluid> fluid = make_fluid(spec);
      fluid->start(disorder(0.01));
      const Totals before = fluid->totals();
      for (int step = 0; step < 100; ++step) fluid->collide_and_stream();
      const Totals after = fluid->totals();
      const auto volume = static_cast<double>(spec.grid.count());
      CHECK(std::abs(after.mass_deviation - before.mass_deviation) < 1e-14 * volume);
      CHECK((after.momentum - before.momentum - 100.0 * volume * spec.body_force).norm() < 1e-14 * volume);
    }
  }
}

TEST_CASE("The staggered momentum of D3Q15 is conserved where nothing pushes") {
  for (const double tau : of_either) {
    CAPTURE(tau);
    const std::unique_ptr<Fluid> fluid = make_fluid(box(8, 6, 4, tau));
    fluid->start(disorder(0.1));
    const Vec3 before = fluid->totals().staggered_momentum;
    CHECK(before.norm() > 0.01);
    for (int step = 0; step < 101; ++step) fluid->collide_and_stream();
    CHECK((fluid->totals().staggered_momentum - before).norm() < 1e-12);
  }
}

TEST_CASE("The equilibrium has the density and the momentum that it was asked for, and no viscous stress") {
  const Vec3 u(0.03, -0.02, 0.05);
  const Populations h = equilibrium(1.1, u);
  CHECK(density_deviation(h) == Approx(0.1).epsilon(1e-14));
  CHECK((momentum(h) - 1.1 * u).norm() < 1e-16);
  CHECK(viscous_stress(h, 0.8).norm() < 1e-16);
}

TEST_CASE("Extremes name the node, and what is not a number is the greatest of all") {
  for (const double tau : of_either) {
    CAPTURE(tau);
    const std::unique_ptr<Fluid> fluid = make_fluid(box(8, 4, 4, tau));
    fluid->start([](std::int64_t node) {
      return equilibrium(node == 37 ? 0.9 : 1.0, {node == 90 ? 0.2 : 0.0, 0.0, 0.0});
    });
    Extremes worst = fluid->extremes();
    CHECK(worst.min_density == Approx(0.9));
    CHECK(worst.min_density_node == 37);
    CHECK(worst.max_speed == Approx(0.2));
    CHECK(worst.max_speed_node == 90);
    fluid->start([](std::int64_t node) { return equilibrium(node == 5 ? NAN : 1.0, Vec3::Zero()); });
    worst = fluid->extremes();
    CHECK(std::isnan(worst.max_speed));
    CHECK(worst.max_speed_node == 5);
    CHECK(std::isnan(worst.min_density));
    CHECK(worst.min_density_node == 5);
    fluid->collide_and_stream();
    CHECK(std::isnan(fluid->extremes().max_speed));
    // An infinite density moves nothing, and is no density.
    fluid->start([](std::int64_t node) {
      Populations h{};
      if (node == 37) h[0] = INFINITY;
      return h;
    });
    worst = fluid->extremes();
    CHECK(std::isnan(worst.min_density));
    CHECK(worst.min_density_node == 37);
  }
}

TEST_CASE("A fluid without viscosity and a box beyond the memory are refused by name") {
  Spec spec = box(4, 4, 4);
  spec.relaxation_time = 0.5;
  CHECK_THROWS_WITH(make_fluid(spec), ContainsSubstring("'relaxation_time' is 0.5"));
  CHECK_THROWS_WITH(make_fluid(box(100000, 100000, 1000)), ContainsSubstring("GB are available"));
}
