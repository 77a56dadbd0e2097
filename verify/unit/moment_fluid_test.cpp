#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "base/error.hpp"
#include "base/work.hpp"
#include "catch.hpp"
#include "fluid/fluid.hpp"
#include "fluid/initial.hpp"
#include "plain_fluid.hpp"
#include "thread_count.hpp"

using namespace veriflex;
using namespace veriflex::fluid;

namespace {

using Random = std::mt19937;

std::int64_t one_of(Random& random, const std::vector<std::int64_t>& values) {
  return values[std::uniform_int_distribution<std::size_t>(0, values.size() - 1)(random)];
}

bool happens(Random& random, double probability) { return std::bernoulli_distribution(probability)(random); }

Vec3 vector_up_to(Random& random, double size) {
  std::uniform_real_distribution<double> number(-size, size);
  const double x = number(random), y = number(random);
  return {x, y, number(random)};
}

/// A small box with anything that a fluid may have.
Spec any_spec(Random& random, Storage storage) {
  const std::vector<std::int64_t> sizes{1, 1, 2, 2, 3, 4, 5, 6, 7, 9};
  Spec spec{.grid = {{one_of(random, {1, 2, 3, 4, 5, 7, 8, 12, 16, 24, 32}), one_of(random, sizes),
                      one_of(random, sizes)}},
            .relaxation_time = 1.0,
            .storage = storage};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!happens(random, 0.4)) continue;
    spec.walls[axis] = Walls{};
    if (happens(random, 0.5)) spec.walls[axis] = {vector_up_to(random, 0.01), vector_up_to(random, 0.01)};
    spec.walls[axis]->low_velocity[static_cast<Eigen::Index>(axis)] = 0.0;
    spec.walls[axis]->high_velocity[static_cast<Eigen::Index>(axis)] = 0.0;
    if (axis == 0 && spec.grid.size[0] > 3 && happens(random, 0.5)) {
      spec.walls[0]->openings = passage(happens(random, 0.5)).openings;
    }
  }
  if (happens(random, 0.5)) spec.body_force = vector_up_to(random, 1e-5);
  spec.scheme = happens(random, 0.5) ? Scheme::FirstOrder : Scheme::Guo;
  if (happens(random, 0.4)) {
    for (std::int64_t node = 1; node < spec.grid.count(); ++node) {
      if (happens(random, 0.1)) spec.obstacle.push_back(node);
    }
  }
  return spec;
}

std::string words_of(const Spec& spec) {
  const auto [nx, ny, nz] = spec.grid.size;
  std::string words = std::to_string(nx) + " x " + std::to_string(ny) + " x " + std::to_string(nz);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (spec.walls[axis]) words += std::string(", walls ") + "xyz"[axis];
    if (spec.walls[axis] && std::holds_alternative<Outflow>(spec.walls[axis]->openings[1])) words += " open";
  }
  words += ", " + std::to_string(spec.obstacle.size()) + " nodes of obstacle, force " +
           std::to_string(spec.body_force.norm());
  return words + (spec.scheme == Scheme::Guo ? ", Guo" : "");
}

Spec with(Spec spec, Representation representation) {
  spec.representation = representation;
  return spec;
}

std::unique_ptr<Fluid> of_moments(const Spec& spec) {
  return make_fluid(with(spec, Representation::Moments));
}

std::vector<Populations> populations_of(const Fluid& fluid) { return fluid.state().populations; }

/// Forces on some nodes, neighbours among them, that differ from step to step.
struct Pushes {
  std::vector<std::int64_t> nodes;
  Positions force;

  explicit Pushes(const Spec& spec) {
    for (std::int64_t node = 0; node < spec.grid.count(); ++node) {
      if (node % 5 < 2) nodes.push_back(node);
    }
    force.resize(static_cast<Eigen::Index>(nodes.size()), 3);
  }

  NodeForces at(int step) {
    for (Eigen::Index i = 0; i < force.rows(); ++i) {
      const double phase = 3.0 * static_cast<double>(i) + 0.3 * step;
      force.row(i) = 1e-4 * Vec3(std::sin(phase), std::cos(1.3 * phase), std::sin(0.7 * phase));
    }
    return {nodes, &force};
  }
};

double largest_difference(const std::vector<Populations>& a, const std::vector<Populations>& b) {
  double worst = 0.0;
  for (std::size_t node = 0; node < a.size(); ++node) {
    for (std::size_t q = 0; q < Q; ++q) {
      const double difference = std::abs(a[node][q] - b[node][q]);
      if (!(difference <= worst)) worst = difference;
    }
  }
  return worst;
}

/// Between a fluid of moments and one of populations, the largest over all looks at them.
double departure_from_populations(const Spec& spec, int steps, int every) {
  const auto moments = of_moments(spec);
  const auto populations = make_fluid(with(spec, Representation::Populations));
  moments->start(disorder(0.05));
  populations->start(disorder(0.05));
  Pushes pushes(spec);
  double worst = 0.0;
  for (int step = 1; step <= steps; ++step) {
    const NodeForces forces = pushes.at(step);
    moments->collide_and_stream(forces);
    populations->collide_and_stream(forces);
    if (step % every != 0 && step > 3) continue;
    const double now = largest_difference(populations_of(*moments), populations_of(*populations));
    if (!(now <= worst)) worst = now;
  }
  return worst;
}

Spec box(std::int64_t x, std::int64_t y, std::int64_t z) {
  return {.grid = {{x, y, z}}, .relaxation_time = 1.0, .representation = Representation::Moments};
}

/// Walls, an obstacle and a force at once.
Spec crowded(std::int64_t nx, Storage storage = Storage::Double) {
  Spec spec = box(nx, 7, 9);
  spec.storage = storage;
  spec.body_force = {1e-4, 2e-4, -1e-4};
  spec.scheme = Scheme::Guo;
  spec.walls[1] = sliding();
  for (const std::int64_t z : {2, 3}) {
    for (const std::int64_t x : {0, 1, 5}) spec.obstacle.push_back(spec.grid.index(x, 3, z));
  }
  return spec;
}

}  // namespace

TEST_CASE("At tau = 1 moments alone make the flow of populations, in any small box, over a thousand steps") {
  const unit::Threads one(1);
  Random random(2026);
  for (int i = 0; i < 50; ++i) {
    const Spec spec = any_spec(random, Storage::Double);
    INFO("box " << i << ": " << words_of(spec));
    CHECK(departure_from_populations(spec, 1000, 97) < 1e-12);
  }
}

TEST_CASE("The same in float, to its digits") {
  const unit::Threads one(1);
  Random random(7);
  for (int i = 0; i < 40; ++i) {
    const Spec spec = any_spec(random, Storage::Float);
    INFO("box " << i << ": " << words_of(spec));
    CHECK(departure_from_populations(spec, 30, 7) < 1e-6);
  }
}

TEST_CASE("Moments are the textbook's collide and stream at tau = 1, in rows and tiles of any length") {
  for (const std::int64_t nx : {8, 16, 48, 64}) {
    for (const bool closed : {false, true}) {
      Spec spec = box(nx, nx == 64 ? 80 : 5, 3);
      spec.body_force = {1e-4, 0.0, 2e-4};
      if (closed) spec.walls[0] = sliding();
      const auto fluid = make_fluid(spec);
      fluid->start(disorder(0.1));
      PlainFluid plain(spec, disorder(0.1));
      for (int step = 0; step < 4; ++step) {
        fluid->collide_and_stream();
        plain.step(std::vector<Vec3>(static_cast<std::size_t>(spec.grid.count()), Vec3::Zero()));
      }
      const std::vector<Populations> h = populations_of(*fluid);
      double worst = 0.0;
      for (std::size_t node = 0; node < h.size(); ++node) {
        const Populations expected = plain.populations(static_cast<std::int64_t>(node));
        for (std::size_t q = 0; q < Q; ++q) worst = std::max(worst, std::abs(h[node][q] - expected[q]));
      }
      CAPTURE(nx, closed);
      CHECK(worst < 1e-15);
    }
  }
}

TEST_CASE("Moments are the same bit for bit with any number of threads") {
  for (const Spec& spec : {box(16, 5, 7), crowded(16), crowded(7), crowded(16, Storage::Float)}) {
    std::vector<State> results;
    for (const int n : {1, 2, 3, 5}) {
      const unit::Threads some(n);
      const auto fluid = make_fluid(spec);
      fluid->start(disorder(0.1));
      Pushes pushes(spec);
      for (int step = 0; step < 7; ++step) fluid->collide_and_stream(pushes.at(step));
      results.push_back(fluid->state());
    }
    for (const State& other : results) {
      CHECK(other.moments == results[0].moments);
      CHECK(other.populations == results[0].populations);
    }
  }
}

TEST_CASE("Many forces on one plane are added the same by any number of threads") {
  const Spec spec = box(40, 60, 3);
  std::vector<std::int64_t> nodes(1500);
  std::iota(nodes.begin(), nodes.end(), 2400);
  std::reverse(nodes.begin(), nodes.end());
  Positions force(1500, 3);
  for (Eigen::Index i = 0; i < 1500; ++i)
    force.row(i) = 1e-4 * Vec3::Constant(std::sin(static_cast<double>(i)));
  std::vector<std::vector<std::array<double, 4>>> results;
  for (const int n : {1, 2, 3, 5}) {
    const unit::Threads some(n);
    const auto fluid = make_fluid(spec);
    for (int step = 0; step < 3; ++step) fluid->collide_and_stream({nodes, &force});
    results.push_back(fluid->state().moments);
  }
  for (const auto& other : results) CHECK(other == results[0]);
}

TEST_CASE("A fluid of moments gives back the populations that it was started from, to the last bit") {
  for (const Spec& spec : {box(8, 4, 5), crowded(12)}) {
    const auto fluid = make_fluid(spec);
    for (const Populations& h : populations_of(*fluid)) CHECK(h == Populations{});
    fluid->collide_and_stream();
    fluid->start(disorder(0.1));
    CHECK(fluid->steps() == 0);
    const std::vector<Populations> h = populations_of(*fluid);
    for (std::size_t node = 0; node < h.size(); ++node) {
      const bool solid = std::find(spec.obstacle.begin(), spec.obstacle.end(), node) != spec.obstacle.end();
      CHECK(h[node] == (solid ? Populations{} : disorder(0.1)(static_cast<std::int64_t>(node))));
    }
  }
}

TEST_CASE("A fluid of moments goes on bit by bit from a state, and from that of a fluid of populations") {
  for (const Spec& spec : {crowded(16), crowded(7), crowded(16, Storage::Float)}) {
    Pushes pushes(spec);
    for (const int until : {0, 1, 4, 7}) {
      CAPTURE(until);
      const auto whole = make_fluid(spec);
      whole->start(disorder(0.1));
      for (int step = 0; step < until; ++step) whole->collide_and_stream(pushes.at(step));
      const State state = whole->state();
      const auto other = make_fluid(spec);
      other->collide_and_stream();
      other->restore(state);
      CHECK(other->steps() == until);
      CHECK(other->state().populations == state.populations);
      CHECK(other->state().moments == state.moments);
      for (int step = until; step < until + 3; ++step) {
        whole->collide_and_stream(pushes.at(step));
        other->collide_and_stream(pushes.at(step));
      }
      CHECK(other->state().moments == whole->state().moments);
      CHECK(other->state().populations == whole->state().populations);

      const auto populations = make_fluid(with(spec, Representation::Populations));
      populations->restore(state);
      other->restore(populations->state());
      CHECK(populations->state().moments.empty());
      for (int step = 0; step < 3; ++step) {
        populations->collide_and_stream();
        other->collide_and_stream();
      }
      CHECK(largest_difference(populations_of(*other), populations_of(*populations)) <
            (spec.storage == Storage::Double ? 1e-14 : 1e-6));
    }
  }
}

TEST_CASE("Velocities, sums, extremes and stress of moments are those of populations") {
  const Spec spec = crowded(12);
  const auto moments = of_moments(spec);
  const auto populations = make_fluid(with(spec, Representation::Populations));
  std::vector<std::int64_t> nodes(static_cast<std::size_t>(spec.grid.count()));
  std::iota(nodes.begin(), nodes.end(), 0);
  moments->start(disorder(0.1));
  populations->start(disorder(0.1));
  Pushes pushes(spec);
  for (int step = 0; step < 6; ++step) {
    Positions u, v;
    moments->velocities(nodes, u);
    populations->velocities(nodes, v);
    CHECK((u - v).cwiseAbs().maxCoeff() < 1e-14);
    const Totals a = moments->totals(), b = populations->totals();
    CHECK(std::abs(a.mass_deviation - b.mass_deviation) < 1e-12);
    CHECK((a.momentum - b.momentum).norm() < 1e-12);
    CHECK((a.staggered_momentum - b.staggered_momentum).norm() < 1e-12);
    const Extremes p = moments->extremes(), q = populations->extremes();
    CHECK(p.min_density == Approx(q.min_density).epsilon(1e-14));
    CHECK(p.max_speed == Approx(q.max_speed).epsilon(1e-13));
    CHECK(p.min_density_node == q.min_density_node);
    CHECK(p.max_speed_node == q.max_speed_node);
    const std::vector<Populations> h = populations_of(*moments), k = populations_of(*populations);
    double stress = 0.0, worst = 0.0;
    for (std::size_t node = 0; node < h.size(); ++node) {
      const Mat3 expected = viscous_stress(k[node], 1.0);
      stress = std::max(stress, expected.norm());
      worst = std::max(worst, (viscous_stress(h[node], 1.0) - expected).norm());
    }
    CHECK(stress > 1e-3);
    CHECK(worst < 1e-14);
    moments->collide_and_stream(pushes.at(step));
    populations->collide_and_stream(pushes.at(step));
  }
}

TEST_CASE("Moments stand for populations at tau = 1 and nowhere else, in half of the memory") {
  Spec spec{.grid = {{64, 64, 64}}, .relaxation_time = 1.0};
  CHECK(representation_of(spec) == Representation::Moments);
  CHECK(representation_of(with(spec, Representation::Populations)) == Representation::Populations);
  const double nodes = static_cast<double>(spec.grid.count());
  CHECK(memory_bytes(spec) < 70.0 * nodes);
  CHECK(memory_bytes(spec) > 64.0 * nodes);
  CHECK(memory_bytes(with(spec, Representation::Populations)) > 120.0 * nodes);
  CHECK(start_bytes(spec) == 120.0 * nodes);
  CHECK(start_bytes(with(spec, Representation::Populations)) == 0.0);
  spec.relaxation_time = std::nextafter(1.0, 2.0);
  CHECK(representation_of(spec) == Representation::Populations);
  spec.representation = Representation::Moments;
  CHECK_THROWS_WITH(make_fluid(spec), ContainsSubstring("moments alone are no state of this fluid"));
  CHECK_THROWS_AS(memory_bytes(spec), BadParameter);
  CHECK_THROWS_WITH(make_fluid(with(box(100000, 100000, 1000), Representation::Auto)),
                    ContainsSubstring("its moments take"));
}

TEST_CASE("A step of moments updates each node once") {
  const auto fluid = make_fluid(crowded(16));
  const std::uint64_t before = work::done().node_updates;
  fluid->collide_and_stream();
  CHECK(work::done().node_updates - before == 16 * 7 * 9);
}
