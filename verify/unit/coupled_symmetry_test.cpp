// The same coupled scene elsewhere, turned, mirrored, with other numbers, or carried by a stream: what must
// be the same bits, what the same to round-off, and what a stream changes.
#include <algorithm>
#include <numeric>

#include "catch.hpp"
#include "driven_bar.hpp"

using namespace veriflex;
using namespace veriflex::unit;

namespace {

/// Of the box: axis a becomes axis to[a], and its nodes are counted from the other end where sign[a] is -1.
struct Turn {
  std::array<std::size_t, 3> to;
  std::array<int, 3> sign;
};

/// The 24 rotations and 24 reflections of a cube.
std::vector<Turn> cube_group() {
  std::vector<Turn> all;
  std::array<std::size_t, 3> to{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs)
      all.push_back({to, {signs & 1 ? -1 : 1, signs & 2 ? -1 : 1, signs & 4 ? -1 : 1}});
  } while (std::next_permutation(to.begin(), to.end()));
  return all;
}

Eigen::Index column(std::size_t axis) { return static_cast<Eigen::Index>(axis); }

Positions turned(const Positions& vectors, const Turn& turn) {
  Positions result(vectors.rows(), 3);
  for (std::size_t a = 0; a < 3; ++a) result.col(column(turn.to[a])) = turn.sign[a] * vectors.col(column(a));
  return result;
}

Grid turned(const Grid& grid, const Turn& turn) {
  Grid result{};
  for (std::size_t a = 0; a < 3; ++a) result.size[turn.to[a]] = grid.size[a];
  return result;
}

int turned(int q, const Turn& turn) {
  const auto found = std::find_if(fluid::c.begin(), fluid::c.end(), [&](const auto& velocity) {
    for (std::size_t a = 0; a < 3; ++a) {
      if (velocity[turn.to[a]] != turn.sign[a] * fluid::c[static_cast<std::size_t>(q)][a]) return false;
    }
    return true;
  });
  return static_cast<int>(found - fluid::c.begin());
}

std::vector<fluid::Populations> turned(const std::vector<fluid::Populations>& flow, const Grid& grid,
                                       const Turn& turn) {
  const Grid to = turned(grid, turn);
  std::vector<fluid::Populations> result(flow.size());
  for (std::size_t node = 0; node < flow.size(); ++node) {
    const auto at = grid.node(static_cast<std::int64_t>(node));
    std::array<std::int64_t, 3> there{};
    for (std::size_t a = 0; a < 3; ++a)
      there[turn.to[a]] = turn.sign[a] > 0 ? at[a] : grid.size[a] - 1 - at[a];
    const auto target = static_cast<std::size_t>(to.index(there[0], there[1], there[2]));
    for (int q = 0; q < fluid::Q; ++q)
      result[target][static_cast<std::size_t>(turned(q, turn))] = flow[node][static_cast<std::size_t>(q)];
  }
  return result;
}

std::vector<fluid::Populations> initial_flow(const scene::Scene& scene) {
  std::vector<fluid::Populations> flow(static_cast<std::size_t>(scene.fluid->grid.count()));
  for (std::size_t node = 0; node < flow.size(); ++node)
    flow[node] = scene.initial_flow(static_cast<std::int64_t>(node));
  return flow;
}

void start_from(scene::Scene& scene, const std::vector<fluid::Populations>& flow) {
  scene.initial_flow = [flow](std::int64_t node) { return flow[static_cast<std::size_t>(node)]; };
}

scene::Scene turned(scene::Scene scene, const Turn& turn) {
  const Grid grid = scene.fluid->grid;
  start_from(scene, turned(initial_flow(scene), grid, turn));
  scene.fluid->grid = turned(grid, turn);
  scene::Body& body = scene.bodies.front();
  for (Positions* vectors : {&body.network.rest, &body.network.vectors, &body.conditions.load,
                             &body.start.displacement, &body.start.velocity})
    *vectors = turned(*vectors, turn);
  const Vec3 place = body.place;
  for (std::size_t a = 0; a < 3; ++a) {
    const double from_there = static_cast<double>(grid.size[a] - 1) - place[column(a)];
    body.place[column(turn.to[a])] = turn.sign[a] > 0 ? place[column(a)] : from_there;
  }
  solid::Drive& drive = *body.conditions.drive;
  const auto axis = static_cast<std::size_t>(drive.axis);
  drive.amplitude *= turn.sign[axis];
  drive.axis = static_cast<int>(turn.to[axis]);
  return scene;
}

scene::State turned(scene::State state, const Grid& grid, const Turn& turn) {
  state.bodies.front().elastic->displacement = turned(displacement(state), turn);
  state.fluid->populations = turned(state.fluid->populations, grid, turn);
  return state;
}

/// The flow of every node moved along by whole nodes, across the edges of the box.
std::vector<fluid::Populations> moved(const std::vector<fluid::Populations>& flow, const Grid& grid,
                                      const std::array<std::int64_t, 3>& by) {
  std::vector<fluid::Populations> result(flow.size());
  for (std::size_t node = 0; node < flow.size(); ++node) {
    auto at = grid.node(static_cast<std::int64_t>(node));
    for (std::size_t a = 0; a < 3; ++a) at[a] = grid.wrap(at[a] + by[a], a);
    result[static_cast<std::size_t>(grid.index(at[0], at[1], at[2]))] = flow[node];
  }
  return result;
}

std::vector<std::int32_t> shuffled(std::size_t count, unsigned seed) {
  std::vector<std::int32_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(seed));
  return order;  // new place of each
}

Positions renumbered(const Positions& rows, const std::vector<std::int32_t>& place) {
  Positions result(rows.rows(), 3);
  for (std::size_t i = 0; i < place.size(); ++i)
    result.row(place[i]) = rows.row(static_cast<Eigen::Index>(i));
  return result;
}

}  // namespace

TEST_CASE(
    "A body whole boxes away is the same body: in one binade to the bit, else to the rounding of place") {
  const auto apart = [](const Setting& setting, const Vec3& place) {
    double worst = 0.0;
    const scene::State here = run(disordered(setting, place));
    for (int axis = 0; axis < 3; ++axis) {
      scene::Scene scene = disordered(setting, place);
      scene.bodies.front().place[axis] +=
          static_cast<double>(scene.fluid->grid.size[static_cast<std::size_t>(axis)]);
      worst = worse(worst, distance(run(scene), here));
    }
    return worst;
  };
  for (const Setting& setting : settings()) {
    INFO(words_of(setting));
    CHECK(apart(setting, somewhere + Vec3::Constant(32.0)) == 0.0);  // all places between 32 and 64
    CHECK(apart(setting, somewhere) < rounding_of_place);
  }
}

TEST_CASE("A body and its flow moved together by whole spacings: to the bit in populations") {
  // Moments add what several node forces send to a node in the order of the node numbers, which goes round
  // with the edge of the box.
  const std::array<std::int64_t, 3> by{3, -2, 5};
  const Vec3 place = somewhere + Vec3::Constant(32.0);
  for (const Setting& setting : settings()) {
    INFO(words_of(setting));
    scene::Scene scene = disordered(setting, place);
    const Grid grid = scene.fluid->grid;
    scene::State expected = run(scene);
    expected.fluid->populations = moved(expected.fluid->populations, grid, by);
    start_from(scene, moved(initial_flow(scene), grid, by));
    scene.bodies.front().place += Vec3(3.0, -2.0, 5.0);
    const double difference = distance(run(scene), expected);
    CHECK(difference < rounding_of_place);
    if (setting.relaxation_time != 1.0) CHECK(difference == 0.0);
  }
}

TEST_CASE("Where the support of a marker changes nodes, and the box its edge, nothing jumps") {
  // The first markers stand on node 0, or half-way before it, where the supports of these kernels change.
  const double shift = 1e-13;
  for (const Setting& setting : settings()) {
    for (const auto delta :
         {coupling::Delta::Cosine, coupling::Delta::ThreePoint, coupling::Delta::FourPoint}) {
      for (int axis = 0; axis < 3; ++axis) {
        INFO(words_of(setting) << ", kernel " << static_cast<int>(delta) << ", axis " << axis);
        scene::Scene scene = disordered(setting);
        scene::Body& body = scene.bodies.front();
        body.place[axis] = delta == coupling::Delta::ThreePoint ? -0.5 : 0.0;
        body.start.displacement.col(axis).setZero();
        body.coupling->delta = delta;
        const scene::State there = run(scene, 25);
        const double place = body.place[axis];
        for (const double side : {-shift, shift}) {
          body.place[axis] = place + side;
          CHECK(distance(run(scene, 25), there) < 0.1 * shift);  // a gradient of velocity times the shift
        }
      }
    }
  }
}

TEST_CASE("Turned and mirrored in all 48 ways of a cube, a body in its flow does the same, to round-off") {
  for (const Setting& setting : settings()) {
    const scene::Scene scene = disordered(setting);
    const scene::State state = run(scene, 25);
    for (const Turn& turn : cube_group()) {
      INFO(words_of(setting) << ", axes to " << turn.to[0] << turn.to[1] << turn.to[2] << ", signs "
                             << turn.sign[0] << turn.sign[1] << turn.sign[2]);
      CHECK(distance(run(turned(scene, turn), 25), turned(state, scene.fluid->grid, turn)) <
            rounding_of_place);
    }
  }
}

TEST_CASE("Other numbers for nodes, bonds and angles change a body in its flow by round-off") {
  for (const Setting& setting : settings()) {
    const scene::Scene scene = disordered(setting);
    const scene::State state = run(scene);
    for (const unsigned seed : {1U, 2U, 3U}) {
      INFO(words_of(setting) << ", seed " << seed);
      scene::Scene other = scene;
      scene::Body& body = other.bodies.front();
      const solid::Network& network = scene.bodies.front().network;
      const auto node = shuffled(static_cast<std::size_t>(network.node_count()), seed);
      const auto bond = shuffled(network.bonds.size(), seed);
      const auto angle = shuffled(network.angles.size(), seed);
      for (Positions* rows :
           {&body.network.rest, &body.conditions.load, &body.start.displacement, &body.start.velocity})
        *rows = renumbered(*rows, node);
      body.network.vectors = renumbered(network.vectors, bond);
      for (std::size_t b = 0; b < bond.size(); ++b) {
        const auto [first, second] = network.bonds[b];
        body.network.bonds[static_cast<std::size_t>(bond[b])] = {node[static_cast<std::size_t>(first)],
                                                                 node[static_cast<std::size_t>(second)]};
      }
      for (std::size_t a = 0; a < angle.size(); ++a) {
        solid::Angle renamed = network.angles[a];
        renamed.bond_a = bond[static_cast<std::size_t>(renamed.bond_a)];
        renamed.bond_b = bond[static_cast<std::size_t>(renamed.bond_b)];
        body.network.angles[static_cast<std::size_t>(angle[a])] = renamed;
      }
      for (std::int32_t& driven : body.conditions.drive->nodes)
        driven = node[static_cast<std::size_t>(driven)];
      scene::State expected = state;
      expected.bodies.front().elastic->displacement = renumbered(displacement(state), node);
      CHECK(distance(run(other), expected) < rounding_of_place);
    }
  }
}

namespace {

void carry(scene::Scene& scene, const Vec3& stream) {
  scene.initial_flow = [stream](std::int64_t) { return fluid::equilibrium(1.0, stream); };
  scene.bodies.front().start.velocity.rowwise() += stream.transpose();
}

/// Displacement of the bar in a stream along z, as seen by who goes with it: the mean over places between two
/// nodes, so that what a place between nodes does to the exchange goes out.
Positions seen_from_stream(const Setting& setting, double speed) {
  constexpr int places = 8, steps = 100;
  Positions mean = Positions::Zero(16, 3);
  for (int i = 0; i < places; ++i) {
    scene::Scene scene = in_fluid(setting, kicked_bar(setting, somewhere + Vec3(0.0, 0.0, i / 8.0)));
    carry(scene, {0.0, 0.0, speed});
    mean += displacement(run(scene, steps)) / places;
  }
  mean.col(2).array() -= steps * speed;
  return mean;
}

}  // namespace

TEST_CASE("A stream carries a body along, and leaves it at rest in itself") {
  for (const Setting& setting : settings()) {
    INFO(words_of(setting));
    scene::Body body = bar(setting, somewhere);
    body.conditions.drive.reset();
    scene::Scene scene = in_fluid(setting, body);
    const Vec3 stream(0.02, -0.05, 0.08);
    carry(scene, stream);
    const scene::State state = run(scene);
    const Positions expected = (100.0 * stream).transpose().replicate(16, 1);
    CHECK(distance(displacement(state), expected) < 100.0 * rounding_of_place);  // a sum of 100 speeds
    for (const fluid::Populations& h : state.fluid->populations)
      CHECK((fluid::momentum(h) - stream).norm() < 100.0 * rounding_of_place);
  }
}

TEST_CASE("Seen from a stream a moving body is another by an error of first order in the speed") {
  // The equilibrium's own error is of second order in the speed beside a small motion (of third in all, see
  // the cases galilean-*). A body's is larger, for a node force enters by 3 w c.g without its term of second
  // order: the reaction starts late, see the next test. With that term a third of the error is left: waves as
  // short as a marker is wide do not go quite with the stream.
  for (const Setting& setting : settings()) {
    INFO(words_of(setting));
    const Positions at_rest = seen_from_stream(setting, 0.0);
    const double slow = distance(seen_from_stream(setting, 0.04), at_rest);
    const double fast = distance(seen_from_stream(setting, 0.08), at_rest);
    CAPTURE(slow, fast, largest_magnitude(at_rest));
    CHECK(std::abs(std::log2(fast / slow) - 1.0) < 0.15);
    CHECK(fast < 0.2 * 0.08 * largest_magnitude(at_rest));
  }
}

TEST_CASE("On a stream the momentum of a node force starts tau steps late") {
  // Momentum g on a stream U goes with a flux of U g + g U. A node force has none of it, and the collision
  // puts 1/tau of what is missing right in a step.
  const double speed = 0.05, force = 1e-9;
  for (const double tau : {0.6, 0.8, 1.0, 1.5}) {
    for (const int along : {0, 2}) {
      const fluid::Spec spec{.grid = {{12, 12, 40}}, .relaxation_time = tau};
      const auto fluid = fluid::make_fluid(spec);
      const Vec3 stream(0.0, 0.0, speed);
      fluid->start([&](std::int64_t) { return fluid::equilibrium(1.0, stream); });
      const std::int64_t at = spec.grid.index(6, 6, 15);
      Positions g = Positions::Zero(1, 3);
      g(0, along) = force;
      fluid->collide_and_stream({{&at, 1}, &g});
      double late = 1.0, missing = 1.0;  // after one step, and of the next
      for (int step = 1; step <= 12; ++step) {
        double moment = 0.0;
        const fluid::State state = fluid->state();
        for (std::int64_t node = 0; node < spec.grid.count(); ++node) {
          const double z = static_cast<double>(spec.grid.node(node)[2] - 15);
          moment += z * (fluid::momentum(state.populations[static_cast<std::size_t>(node)]) - stream)[along];
        }
        CAPTURE(tau, along, step);
        const double flux = along == 2 ? 2.0 * speed : speed;
        CHECK(moment / force == Approx(flux * (step - late)).margin(1e-4));
        fluid->collide_and_stream();
        missing *= 1.0 - 1.0 / tau;
        late += missing;  // 1 + (1 - 1/tau) + ... -> tau
      }
    }
  }
}
