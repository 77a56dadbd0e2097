#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <random>

#include "base/reduce.hpp"
#include "engine/read_scene.hpp"
#include "measures/at_once.hpp"
#include "measures/drivers.hpp"
#include "measures/fluid/run_fluid.hpp"
#include "measures/for_all.hpp"

// A disordered but smooth start, and what must not change of it: mass, momentum beyond what the force gave,
// and the staggered momentum, which D3Q15 conserves too because every moving population flips the parity of x
// + y + z.

namespace veriflex::measures {

namespace {

using fluid::Scheme;
using fluid::Storage;
using fluid::Totals;
using observe::Observations;
using observe::Record;

struct Conservation {
  fluid::Spec fluid;
  std::int64_t steps;
  double velocity;   // of each wave of the start; its density waves are as strong  [L T^-1]
  double staggered;  // checkerboard velocity of the runs that start with one  [L T^-1]
  observe::MonitorSpec monitor;

  /// Walls and obstacles take up momentum: there only the mass stays.
  bool periodic() const {
    return fluid.obstacle.empty() && !fluid.walls[0] && !fluid.walls[1] && !fluid.walls[2];
  }
};

constexpr int samples = 20;
constexpr int waves = 8;

struct Wave {
  std::array<double, 3> k;  // radians per node
  double phase;
  Vec3 velocity;   // of unit size
  double density;  // -1 to 1
};

/// Waves of one or two lengths along each axis, from a generator whose numbers are the same everywhere.
std::vector<Wave> disorder(const Grid& grid) {
  std::mt19937 random(1);
  const auto number = [&random] { return 2.0 * static_cast<double>(random()) / 4294967296.0 - 1.0; };
  std::vector<Wave> all;
  for (int i = 0; i < waves; ++i) {
    Wave wave{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      wave.k[axis] =
          2.0 * std::numbers::pi * std::round(2.0 * number()) / static_cast<double>(grid.size[axis]);
    }
    wave.phase = std::numbers::pi * number();
    for (int axis = 0; axis < 3; ++axis) wave.velocity[axis] = number();
    wave.velocity.normalize();
    wave.density = number();
    all.push_back(wave);
  }
  return all;
}

struct Piece {
  Storage storage;
  Scheme scheme;
  bool staggered;  // starts with a checkerboard
};

std::string name_of(const Piece& piece) {
  return fmt::format("{}_{}", row_of(fluid::storages, piece.storage).id,
                     piece.staggered ? "staggered" : row_of(fluid::schemes, piece.scheme).id);
}

void start(fluid::Fluid& fluid, const Conservation& study, const Piece& piece) {
  const std::vector<Wave> all = disorder(fluid.spec().grid);
  fluid.start([&](std::int64_t node) {
    const auto [x, y, z] = fluid.spec().grid.node(node);
    double rho = 1.0;
    Vec3 u = Vec3::Zero();
    for (const Wave& wave : all) {
      const double angle = wave.k[0] * static_cast<double>(x) + wave.k[1] * static_cast<double>(y) +
                           wave.k[2] * static_cast<double>(z) + wave.phase;
      rho += study.velocity * wave.density * std::cos(angle);
      u += study.velocity * wave.velocity * std::cos(angle);
    }
    if (piece.staggered) u[0] += (x + y + z) % 2 == 0 ? study.staggered : -study.staggered;
    return fluid::equilibrium(rho, u);
  });
}

/// Changes since the start, per node.
struct Drift {
  std::vector<double> mass, momentum, staggered;
};

fluid::Spec spec_of(const Conservation& study, const Piece& piece) {
  fluid::Spec spec = study.fluid;
  spec.storage = piece.storage;
  spec.scheme = piece.scheme;
  return spec;
}

Drift drift_of(const Conservation& study, const Piece& piece) {
  const fluid::Spec spec = spec_of(study, piece);
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(spec);
  start(*fluid, study, piece);
  const Totals before = fluid->totals();
  const auto volume = static_cast<double>(spec.grid.count());
  Drift drift;
  observe::Monitor monitor(*fluid, study.monitor);
  for (int i = 1; i <= samples; ++i) {
    run_steps(study.steps * i / samples - fluid->steps(), monitor);
    const Totals now = fluid->totals();
    const Vec3 given = static_cast<double>(fluid->steps()) * volume * spec.body_force;
    drift.mass.push_back(std::abs(now.mass_deviation - before.mass_deviation) / volume);
    drift.momentum.push_back((now.momentum - before.momentum - given).norm() / volume);
    drift.staggered.push_back((now.staggered_momentum - before.staggered_momentum).norm() / volume);
  }
  monitor.at_end();
  return drift;
}

double largest(const std::vector<double>& values) {
  double worst = 0.0;
  for (const double value : values) worst = worse(worst, value);
  return worst;
}

std::vector<Piece> pieces_of(const Conservation& study) {
  std::vector<Piece> pieces;
  for (const Named<Storage>& row : fluid::storages) {
    const Storage storage = row.value;
    for (const Named<Scheme>& scheme : fluid::schemes) pieces.push_back({storage, scheme.value, false});
    if (study.periodic()) pieces.push_back({storage, Scheme::FirstOrder, true});
  }
  return pieces;
}

/// What is recorded of each run: one record per quantity, one column per run, and its largest as a metric.
struct Quantity {
  const char* record;
  const char* title;
  const char* metric;
  const char* dimension;
  const char* meaning;
  std::vector<double> Drift::*values;
};

std::vector<Quantity> quantities(const Conservation& study) {
  std::vector<Quantity> all{{"drift_of_mass", "Departure of the mass, per node", "mass_", "M L^-3",
                             "largest departure, per node", &Drift::mass}};
  if (!study.periodic()) return all;
  all.push_back({"drift_of_momentum", "Departure of the momentum from that at the start plus n g V, per node",
                 "momentum_", "M L^-2 T^-1", "largest departure from the start plus n g V, per node",
                 &Drift::momentum});
  all.push_back({"drift_of_staggered_momentum", "Departure of the staggered momentum, per node",
                 "staggered_momentum_", "M L^-2 T^-1", "largest departure, per node", &Drift::staggered});
  return all;
}

Record steps_record(const Conservation& study, const Quantity& quantity) {
  Record record{quantity.record, quantity.title, {{"step", "t", "T", "", {}}}};
  for (int i = 1; i <= samples; ++i) {
    record.columns.front().values.push_back(static_cast<double>(study.steps * i / samples));
  }
  return record;
}

void run(const Conservation& study, Observations& seen, Progress& progress) {
  const std::vector<Piece> pieces = pieces_of(study);
  const std::vector<Quantity> wanted = quantities(study);
  for (const Quantity& quantity : wanted) seen.records.push_back(steps_record(study, quantity));
  std::vector<Drift> drifts(pieces.size());
  for_all(
      pieces.size(), "runs", progress, [&](std::size_t i) { drifts[i] = drift_of(study, pieces[i]); },
      [&](std::size_t i) {
        for (std::size_t k = 0; k < wanted.size(); ++k) {
          const std::vector<double>& values = drifts[i].*wanted[k].values;
          seen.records[k].columns.push_back(
              {name_of(pieces[i]), "", wanted[k].dimension, "storage and force scheme", values});
          seen.metrics.push_back({wanted[k].metric + name_of(pieces[i]), largest(values), wanted[k].dimension,
                                  wanted[k].meaning});
        }
      });
}

std::vector<std::string> measures_of(const Conservation& study) {
  std::vector<std::string> measures;
  for (const Piece& piece : pieces_of(study)) {
    for (const Quantity& quantity : quantities(study)) measures.push_back(quantity.metric + name_of(piece));
  }
  return measures;
}

}  // namespace

engine::Study read_conservation(const io::Table& top) {
  const io::Table table = top.table("fluid");
  const io::Table t = top.table("conservation");
  Conservation study{.fluid = engine::read_fluid(top),
                     .steps = t.integer("steps", samples, 1'000'000'000),
                     .velocity = t.number("velocity"),
                     .staggered = 0.0,
                     .monitor = engine::read_monitor(top)};
  for (const char* key : {"storage", "force_scheme"}) {
    if (table.has(key)) {
      table.fail(key, fmt::format("'{}' is set", key), "both storages and both schemes are run",
                 "Leave it out");
    }
  }
  if (study.periodic()) {
    study.staggered = t.number("staggered_velocity");
    for (const std::int64_t n : study.fluid.grid.size) {
      if (n % 2 != 0) {
        table.fail("nodes", "an odd number of nodes along a periodic axis",
                   "a checkerboard does not fit, and the staggered momentum is not conserved",
                   "Use even numbers");
      }
    }
  }
  std::vector<fluid::Spec> runs;
  for (const Piece& piece : pieces_of(study)) runs.push_back(spec_of(study, piece));
  return {
      .plan = plan_at_once(top, runs),
      .measures = measures_of(study),
      .run = [study](Observations& seen, Progress& progress, engine::Cost&) { run(study, seen, progress); }};
}

}  // namespace veriflex::measures
