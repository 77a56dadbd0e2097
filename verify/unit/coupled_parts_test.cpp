// A coupled scene put together otherwise: bodies divided and joined, parts that have nothing to do with it,
// and a motion of twice the amplitude.
#include "catch.hpp"
#include "driven_bar.hpp"

using namespace veriflex;
using namespace veriflex::unit;

namespace {

void append(Positions& rows, const Positions& more) {
  Positions both(rows.rows() + more.rows(), 3);
  both << rows, more;
  rows = both;
}

/// One network of both, without a bond between them.
scene::Body joined(scene::Body a, const scene::Body& b) {
  const auto nodes = static_cast<std::int32_t>(a.network.node_count());
  const auto bonds = static_cast<std::int32_t>(a.network.bonds.size());
  append(a.network.rest, b.network.rest.rowwise() + (b.place - a.place).transpose());
  append(a.network.vectors, b.network.vectors);
  for (const auto& [first, second] : b.network.bonds)
    a.network.bonds.push_back({first + nodes, second + nodes});
  for (solid::Angle angle : b.network.angles) {
    angle.bond_a += bonds;
    angle.bond_b += bonds;
    a.network.angles.push_back(angle);
  }
  append(a.conditions.load, b.conditions.load);
  append(a.start.displacement, b.start.displacement);
  append(a.start.velocity, b.start.velocity);
  for (const std::int32_t driven : b.conditions.drive->nodes)
    a.conditions.drive->nodes.push_back(driven + nodes);
  return a;
}

}  // namespace

TEST_CASE("A body is as many bodies in its place, each with its share of mass, stiffness, load and volume") {
  // Spacing, step and density of the fluid are 1, so that the unit of mass is not free in a scene; this is
  // what is left of its freedom. Shares are powers of two: the same bits.
  for (const Setting& setting : settings()) {
    const scene::State whole = run(disordered(setting));
    for (const int parts : {2, 4}) {
      INFO(words_of(setting) << ", " << parts << " parts");
      const double share = 1.0 / parts;
      scene::Scene scene = disordered(setting);
      scene::Body& body = scene.bodies.front();
      body.material = material_of(setting, share);
      body.conditions.node_mass *= share;
      body.conditions.load *= share;
      body.coupling->marker_volume *= share;
      scene.bodies.assign(static_cast<std::size_t>(parts), body);
      CHECK(distance(run(scene), whole) == 0.0);
    }
  }
}

TEST_CASE(
    "Two bars are one network of both: to the bit apart, to round-off where they share nodes of the fluid") {
  // There one network adds marker by marker, and two bodies add their sums.
  for (const Setting& setting : settings()) {
    for (const double apart : {2.5, 5.0}) {
      INFO(words_of(setting) << ", " << apart << " apart");
      const Vec3 place(2.25, 2.5, 3.125);  // and its distance from the other are no rounded numbers
      scene::Scene two = disordered(setting, place);
      two.bodies.push_back(kicked_bar(setting, place + Vec3(0.0, apart, 0.0)));
      scene::Scene one = two;
      one.bodies = {joined(two.bodies[0], two.bodies[1])};
      const scene::State p = run(two), q = run(one);
      Positions both = displacement(p, 0);
      append(both, displacement(p, 1));
      const double difference = worse(distance(both, displacement(q)), distance(*p.fluid, *q.fluid));
      CHECK(difference < rounding_of_place);
      if (apart == 5.0) CHECK(difference == 0.0);
    }
  }
}

TEST_CASE("A body without coupling in the midst of another is nothing to it, nor is that to the body") {
  for (const Setting& setting : settings()) {
    INFO(words_of(setting));
    scene::Scene scene = disordered(setting);
    const scene::State before = run(scene);
    scene::Body bystander = kicked_bar(setting, {5.8, 5.1, 6.0});
    bystander.coupling.reset();
    scene.bodies.push_back(bystander);
    const scene::State with = run(scene);
    CHECK(distance(with, before) == 0.0);
    CHECK(displacement(with, 1) == displacement(run({.bodies = {bystander}})));
  }
}

TEST_CASE("What is behind a wall is nothing to a body: an empty chamber, short or long") {
  // Populations turn back at an obstacle as at a wall. Moments add what comes back in another order there.
  for (const Setting& setting : settings()) {
    INFO(words_of(setting));
    scene::Scene walled = in_fluid(setting, kicked_bar(setting, somewhere));
    walled.fluid->walls[2] = fluid::Walls{};
    const auto with_chamber = [&](std::int64_t length) {
      scene::Scene scene = walled;
      Grid& grid = scene.fluid->grid;
      grid.size[2] = 14 + 1 + length;
      for (std::int64_t y = 0; y < grid.size[1]; ++y) {
        for (std::int64_t x = 0; x < grid.size[0]; ++x) scene.fluid->obstacle.push_back(grid.index(x, y, 14));
      }
      return run(scene);
    };
    const scene::State alone = run(walled), with = with_chamber(6);
    CHECK(distance(alone, with_chamber(12)) == distance(alone, with));
    CHECK(distance(alone, with) < rounding_of_place);
    if (setting.relaxation_time != 1.0) CHECK(distance(alone, with) == 0.0);
    for (std::size_t node = alone.fluid->populations.size(); node < with.fluid->populations.size(); ++node)
      CHECK(with.fluid->populations[node] == fluid::Populations{});
  }
}

TEST_CASE("Twice a small drive moves body and fluid twice as far, but for what grows with the drive") {
  const auto moved_by = [](const Setting& setting, double amplitude) {
    scene::Body body = bar(setting, somewhere);
    body.conditions.drive->amplitude = amplitude;
    return run(in_fluid(setting, body));
  };
  // How far twice the response to `amplitude` is from that to twice the amplitude, over the latter.
  const auto departure = [&](const Setting& setting, double amplitude) {
    scene::State once = moved_by(setting, amplitude);
    const scene::State twice = moved_by(setting, 2.0 * amplitude);
    once.bodies.front().elastic->displacement *= 2.0;
    double fluid = 0.0;
    for (fluid::Populations& h : once.fluid->populations) {
      for (double& population : h) fluid = worse(fluid, std::abs(population *= 2.0));
    }
    return std::array{
        distance(displacement(once), displacement(twice)) / largest_magnitude(displacement(twice)),
        distance(*once.fluid, *twice.fluid) / fluid};
  };
  for (const Setting& setting : settings()) {
    INFO(words_of(setting));
    const auto small = departure(setting, 1e-5), larger = departure(setting, 1e-4);
    for (const std::size_t of : {0U, 1U}) {
      CAPTURE(of, small[of], larger[of]);
      CHECK(larger[of] < 1e-4);                                     // of the amplitude
      CHECK(larger[of] / small[of] == Approx(10.0).epsilon(0.05));  // and with it
    }
  }
}
