// Many steps of a fluid at once are the same as one after the other, bit by bit, whatever is made of them.
#include "fluid/blocking.hpp"

#include <fmt/format.h>
#include <omp.h>
#include <signal.h>

#include <numeric>
#include <random>

#include "base/memory.hpp"
#include "base/stop.hpp"
#include "catch.hpp"
#include "fluid/fluid.hpp"
#include "observe/run.hpp"
#include "plain_fluid.hpp"
#include "row_order.hpp"
#include "scene/simulation.hpp"
#include "thread_count.hpp"

using namespace veriflex;
using namespace veriflex::fluid;
using unit::any;

namespace {

using Random = std::mt19937;

std::vector<Populations> populations_of(const Fluid& fluid) {
  std::vector<std::int64_t> nodes(static_cast<std::size_t>(fluid.spec().grid.count()));
  std::iota(nodes.begin(), nodes.end(), 0);
  std::vector<Populations> h(nodes.size());
  fluid.populations(nodes, h);
  return h;
}

/// Any box with any walls, body force and storage; now and then with an obstacle or openings, which are not
/// blocked.
Spec any_box(Random& random) {
  const std::array<std::int64_t, 7> lengths{1, 2, 3, 5, 8, 16, 32};
  Spec spec{.grid = {{lengths[static_cast<std::size_t>(any(random, 0, 6))], any(random, 1, 24),
                      any(random, 1, 24)}},
            .relaxation_time = 0.8,
            .storage = any(random, 0, 1) == 0 ? Storage::Double : Storage::Float};
  if (any(random, 0, 1) == 0) spec.body_force = {1e-3, -2e-3, 5e-4};
  if (any(random, 0, 1) == 0) spec.scheme = Scheme::Guo;
  for (auto& walls : spec.walls) {
    const std::int64_t kind = any(random, 0, 3);
    if (kind == 0) walls = Walls{};
    if (kind == 1) walls = sliding();
  }
  if (any(random, 0, 9) == 0) spec.obstacle = {any(random, 0, spec.grid.count() - 1)};
  if (any(random, 0, 9) == 0) spec.walls[2] = passage();
  return spec;
}

}  // namespace

TEST_CASE("Many steps at once are single steps bit by bit in any box") {
  Random random(20261127);
  for (int trial = 0; trial < 120; ++trial) {
    Spec spec = any_box(random);
    const std::int64_t before = any(random, 0, 3), steps = any(random, 1, 23);
    const std::unique_ptr<Fluid> single = make_fluid(spec);
    single->start(disorder(0.1));
    for (std::int64_t step = 0; step < before + steps; ++step) single->collide_and_stream();

    spec.blocking = Blocking{any(random, 1, 12), any(random, 1, 30)};
    const unit::Threads threads(static_cast<int>(any(random, 1, 3)));
    CAPTURE(trial, spec.grid.size, spec.blocking->steps, spec.blocking->rows, before, steps,
            omp_get_max_threads());
    const std::unique_ptr<Fluid> blocked = make_fluid(spec);
    blocked->start(disorder(0.1));
    for (std::int64_t step = 0; step < before; ++step) blocked->collide_and_stream();
    blocked->advance(steps);
    CHECK(blocked->steps() == single->steps());
    CHECK(populations_of(*blocked) == populations_of(*single));
  }
}

TEST_CASE("Every row makes every step once and after the rows beside it") {
  Random random(7);
  for (int trial = 0; trial < 300; ++trial) {
    const RowGrid grid{any(random, 1, 40), any(random, 1, 40)};
    const Blocking blocking{any(random, 1, 16), any(random, 1, 50)};
    const std::int64_t steps = any(random, 1, 40);
    const int threads = static_cast<int>(any(random, 1, 4));
    unit::RowOrder order(grid);
    make_steps(grid, steps, blocking, threads,
               [&](std::int64_t step, std::int64_t z, std::int64_t y_begin, std::int64_t y_end) {
                 order.make(step, z, y_begin, y_end);
               });
    CAPTURE(trial, grid.rows, grid.planes, blocking.steps, blocking.rows, steps, threads);
    CHECK(order.out_of_order() == 0);
    CHECK(order.all_have_made(steps));
  }
}

TEST_CASE("Blocking follows from the caches and is left out where it gains nothing") {
  const Cache cache = largest_cache();
  CHECK(cache.bytes >= 1 << 20);
  CHECK(cache.processors >= 1);
  CHECK(blocking_for({8, 8}, 64 * 15 * 8, 2).steps == 1);  // held by the cache
  const std::int64_t many = cache.bytes / 7680;
  CHECK(blocking_for({many, 3}, 7680, 2).steps == 1);  // too thin to be divided
  for (const int threads : {1, 2, 3, 16}) {
    const RowGrid grid{many, 100};
    const Blocking blocking = blocking_for(grid, 7680, threads);
    CHECK(blocking.steps > 1);
    CHECK(blocking.rows >= blocking.steps);
    CHECK(2 * (blocking.steps - 1) * threads <= grid.planes);
    CHECK(blocking.steps * blocking.rows * 7680 * std::min(threads, cache.processors) <= cache.bytes);
  }
}

TEST_CASE("A fluid says whether it makes many steps at once") {
  Spec spec{.grid = {{8, 6, 6}}, .relaxation_time = 0.8, .blocking = Blocking{4, 8}};
  CHECK(make_fluid(spec)->steps_at_once() == 4);
  spec.walls[1] = sliding();
  CHECK(make_fluid(spec)->steps_at_once() == 4);
  Spec other = spec;
  other.obstacle = {9};
  CHECK(make_fluid(other)->steps_at_once() == 1);
  other = spec;
  other.walls[2] = passage();
  CHECK(make_fluid(other)->steps_at_once() == 1);
  other = spec;
  other.relaxation_time = 1.0;  // of moments
  CHECK(make_fluid(other)->steps_at_once() == 1);
}

TEST_CASE("A stop is seen in the midst of many steps") {
  const Spec spec{.grid = {{8, 20, 20}}, .relaxation_time = 0.8, .blocking = Blocking{5, 12}};
  int made = 0;
  make_steps({20, 20}, 100, {5, 12}, 1, [&](std::int64_t, std::int64_t, std::int64_t, std::int64_t) {
    if (++made == 70) stop::signal = SIGTERM;
  });
  CHECK(made < 80);
  const std::unique_ptr<Fluid> fluid = [&] {
    stop::signal = 0;
    return make_fluid(spec);
  }();
  stop::signal = SIGTERM;
  CHECK_THROWS_AS(fluid->advance(10), Stopped);
  stop::signal = 0;
  stop::forget();
}

TEST_CASE("A run of a fluid is the same with many steps at once and looks at the same steps") {
  const auto seen = [](std::optional<Blocking> blocking) {
    Spec spec{.grid = {{8, 12, 12}}, .relaxation_time = 0.8, .blocking = blocking};
    scene::Simulation simulation({.fluid = spec, .initial_flow = disorder(0.05)});
    Progress progress("");
    std::vector<std::int64_t> looked;
    std::vector<Vec3> momenta;
    const observe::Observer observer{{7.5}, [&](const scene::Simulation& scene) {
                                       looked.push_back(scene.steps());
                                       momenta.push_back(scene.fluid().totals().staggered_momentum);
                                     }};
    observe::Run run(simulation, {.every = 10}, {observer}, "", progress);
    run.advance(13, 50);
    run.advance(37, 50);
    run.finish();
    return std::tuple(looked, momenta, populations_of(simulation.fluid()), run.state().checked);
  };
  const auto plain = seen(Blocking{1, 12});
  CHECK(std::get<0>(plain) == std::vector<std::int64_t>{0, 8, 15, 23, 30, 38, 45, 50});
  CHECK(seen(Blocking{4, 6}) == plain);
  CHECK(seen(Blocking{100, 6}) == plain);
}
