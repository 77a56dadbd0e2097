#include <fmt/format.h>

#include <cmath>

#include "analytic/lattice_wave.hpp"
#include "base/error.hpp"
#include "base/reduce.hpp"
#include "engine/convergence.hpp"
#include "measures/drivers.hpp"
#include "measures/fluid/periodic_fluid.hpp"
#include "measures/fluid/run_fluid.hpp"
#include "measures/for_all.hpp"

namespace veriflex::measures {

namespace {

using analytic::Complex;
using analytic::LatticeWave;
using observe::Observations;
using observe::Record;

// Populations are deviations from rest, so that a small wave keeps all its digits, and what the equilibrium's
// squares add to it is of the order of its square.
constexpr double amplitude = 1e-8;

struct WaveStudy {
  fluid::Spec fluid;  // the box and tau are set per row
  bool sound;         // or shear
  Vec3 direction;     // of k, components -1, 0 or 1
  Vec3 polarization;  // of shear, across k
  std::vector<double> relaxation_times;
  std::vector<std::int64_t> nodes;  // along each side that k has a component along
  std::int64_t steps;
};

struct Row {
  double relaxation_time;
  std::int64_t nodes;
  double wavenumber;  // |k|
  LatticeWave exact;
  Complex measured;  // factor per step
  double departure;  // of ln(factor), relative

  double continuum_decay() const { return fluid::viscosity(relaxation_time) * wavenumber * wavenumber; }
  double continuum_frequency() const { return wavenumber * std::sqrt(fluid::sound_speed_squared); }
};

// What is measured and must become 1 as waves get long.
struct Quantity {
  std::string name;
  double (*value)(const Row&);
};

std::vector<Quantity> quantities(bool sound) {
  const auto damping = [](const Row& row) {
    return -std::log(std::abs(row.measured)) / row.continuum_decay();
  };
  const auto speed = [](const Row& row) { return -std::arg(row.measured) / row.continuum_frequency(); };
  if (sound) return {{"speed", speed}, {"attenuation", damping}};
  return {{"viscosity", damping}};
}

// The share of this wave in the fluid.
Complex share(const fluid::Fluid& fluid, const Vec3& k, const LatticeWave& wave) {
  const Grid& grid = fluid.spec().grid;
  Complex sum = 0.0;
  in_parts(grid, [&](std::span<const std::int64_t> nodes) {
    std::vector<fluid::Populations> h(nodes.size());
    fluid.populations(nodes, h);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      Complex here = 0.0;
      for (std::size_t q = 0; q < fluid::Q; ++q) here += wave.projection[static_cast<int>(q)] * h[i][q];
      sum += here * std::polar(1.0, -k.dot(position(grid, nodes[i])));
    }
  });
  return sum / static_cast<double>(grid.count());
}

// Steps until a wave is a ten-thousandth of itself at the most: what rounding leaves behind decays slower
// than a strongly damped wave.
std::int64_t steps_of(const WaveStudy& study, const LatticeWave& wave) {
  const double most = std::log(1e4) / wave.decay_rate();
  if (!(most < static_cast<double>(study.steps))) return study.steps;
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(most));
}

fluid::Spec spec_of(const WaveStudy& study, double relaxation_time, std::int64_t n) {
  fluid::Spec spec = study.fluid;
  spec.relaxation_time = relaxation_time;
  for (int axis = 0; axis < 3; ++axis)
    spec.grid.size[static_cast<std::size_t>(axis)] = study.direction[axis] == 0.0 ? 1 : n;
  return spec;
}

Row measure(const WaveStudy& study, double relaxation_time, std::int64_t n) {
  const fluid::Spec spec = spec_of(study, relaxation_time, n);
  const Vec3 k = wavenumber(n) * study.direction;
  const analytic::ContinuumWave like =
      study.sound ? analytic::ContinuumWave{1.0, std::sqrt(fluid::sound_speed_squared) * k.normalized()}
                  : analytic::ContinuumWave{0.0, study.polarization.normalized()};
  const LatticeWave wave = lattice_wave(k, relaxation_time, like);
  // At tau = 1 some short waves are gone after one step: their factor is 0, of which rounding leaves 1e-16.
  if (std::abs(wave.factor) < 1e-12) {
    throw NumericalFailure(
        fmt::format("tau = {}, {} nodes: the wave is gone after one step and has no decay rate. Leave this "
                    "resolution out",
                    relaxation_time, n));
  }

  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(spec);
  fluid->start([&](std::int64_t node) {
    const Complex phase = amplitude * std::polar(1.0, k.dot(position(spec.grid, node)));
    fluid::Populations h;
    for (std::size_t q = 0; q < fluid::Q; ++q) h[q] = (phase * wave.shape[static_cast<int>(q)]).real();
    return h;
  });
  const Complex before = share(*fluid, k, wave);
  const std::int64_t steps = steps_of(study, wave);
  run_steps(*fluid, steps, observe::MonitorSpec{});
  // Over the exact factor, so that no whole turns of the phase are lost.
  const Complex ratio = share(*fluid, k, wave) / (before * std::pow(wave.factor, static_cast<double>(steps)));
  const Complex difference = std::log(ratio) / static_cast<double>(steps);
  return {.relaxation_time = relaxation_time,
          .nodes = n,
          .wavenumber = k.norm(),
          .exact = wave,
          .measured = wave.factor * std::exp(difference),
          .departure = std::abs(difference) / std::abs(std::log(wave.factor))};
}

Record dispersion_record(bool sound) {
  Record record{"dispersion",
                "Waves in the fluid against eigenvalues of the collide-and-stream matrix",
                {{"relaxation_time", "tau", "T", "relaxation time", {}},
                 {"nodes", "N", "1", "nodes along a side of the box, which holds one wave", {}},
                 {"wavenumber", "|k|", "L^-1", "2 pi over the wave length", {}},
                 {"decay_rate", "", "T^-1", "measured", {}},
                 {"decay_rate_exact", "", "T^-1", "-ln|eigenvalue|", {}},
                 {"decay_rate_continuum", "nu k^2", "T^-1", "of long waves", {}},
                 {"departure", "", "1", "of ln(factor per step) from the eigenvalue's, relative", {}}}};
  if (sound) {
    record.columns.push_back({"frequency", "", "T^-1", "angular, measured", {}});
    record.columns.push_back({"frequency_exact", "", "T^-1", "minus the eigenvalue's argument", {}});
    record.columns.push_back({"frequency_continuum", "|k|/sqrt(3)", "T^-1", "of long waves", {}});
  }
  return record;
}

std::vector<double> dispersion_row(const Row& row, bool sound) {
  std::vector<double> values{row.relaxation_time,    static_cast<double>(row.nodes),
                             row.wavenumber,         -std::log(std::abs(row.measured)),
                             row.exact.decay_rate(), row.continuum_decay(),
                             row.departure};
  if (sound)
    values.insert(values.end(),
                  {-std::arg(row.measured), row.exact.angular_frequency(), row.continuum_frequency()});
  return values;
}

// C of value - 1 = C k^2 + O(k^4), from the two finest grids.
double constant(const std::vector<double>& k, const std::vector<double>& value) {
  const std::size_t n = k.size();
  const double fine = k[n - 1] * k[n - 1], coarse = k[n - 2] * k[n - 2];
  return ((value[n - 1] - 1.0) / fine * coarse - (value[n - 2] - 1.0) / coarse * fine) / (coarse - fine);
}

void run(const WaveStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  const std::size_t resolutions = study.nodes.size();
  std::vector<Row> rows(study.relaxation_times.size() * resolutions);
  seen.records.push_back(dispersion_record(study.sound));
  for_all(
      rows.size(), "waves", progress,
      [&](std::size_t i) {
        rows[i] = measure(study, study.relaxation_times[i / resolutions], study.nodes[i % resolutions]);
      },
      [&](std::size_t i) { seen.records.front().append(dispersion_row(rows[i], study.sound)); });
  cost.finish("waves");

  double worst = 0.0;
  for (const Row& row : rows) worst = worse(worst, row.departure);
  seen.metrics.push_back({"worst_departure", worst, "1",
                          "largest relative departure of ln(factor per step) from the eigenvalue's"});

  Record convergence{"convergence",
                     "Error of long waves' constants",
                     {{"wavenumber", "|k|", "L^-1", "2 pi over the wave length in nodes", {}}}};
  for (std::size_t i = 0; i < resolutions; ++i) convergence.columns[0].values.push_back(rows[i].wavenumber);
  const std::vector<double> k = convergence.columns[0].values;
  Record constants{"constants",
                   "Leading error C of value/continuum = 1 + C k^2, and the extrapolated limit",
                   {{"relaxation_time", "tau", "T", "relaxation time", study.relaxation_times}}};
  for (const Quantity& quantity : quantities(study.sound)) {
    observe::Column leading{"constant_" + quantity.name, "C", "L^2", "from the two finest grids", {}};
    observe::Column limit{
        "extrapolated_" + quantity.name, "", "1", "Richardson, three finest grids, over the continuum's", {}};
    observe::Column index{"gci_" + quantity.name, "", "1", "grid convergence index of the finest grid", {}};
    for (std::size_t t = 0; t < study.relaxation_times.size(); ++t) {
      std::vector<double> value, error;
      for (std::size_t i = 0; i < resolutions; ++i) {
        value.push_back(quantity.value(rows[t * resolutions + i]));
        error.push_back(std::abs(value.back() - 1.0));
      }
      const std::string name = fmt::format("{}_tau_{}", quantity.name, study.relaxation_times[t]);
      convergence.columns.push_back({"error_" + name, "", "1", "relative to the continuum's", error});
      seen.metrics.push_back(
          {"order_" + name, engine::orders(k, error).back(), "1", "between the two finest grids"});
      const engine::Convergence found = engine::converge(k, value);
      leading.values.push_back(constant(k, value));
      limit.values.push_back(found.richardson);
      index.values.push_back(found.gci);
    }
    constants.columns.insert(constants.columns.end(), {leading, limit, index});
  }
  seen.records.insert(seen.records.begin(), convergence);
  seen.records.push_back(constants);
}

Vec3 read_direction(const io::Table& table, const std::string& key) {
  const std::vector<std::int64_t> given = table.integers(key);
  Vec3 direction = Vec3::Zero();
  for (std::size_t i = 0; i < given.size() && i < 3; ++i)
    direction[static_cast<int>(i)] = static_cast<double>(given[i]);
  if (given.size() != 3 || direction.isZero(0.0) || direction.cwiseAbs().maxCoeff() > 1.0) {
    table.fail(key, fmt::format("'{}' is no direction", key),
               "it has three numbers -1, 0 or 1 that are not all 0", "Write for example [0, 1, 1]");
  }
  return direction;
}

std::vector<std::string> measured_names(const WaveStudy& study) {
  std::vector<std::string> names{"worst_departure"};
  for (const Quantity& quantity : quantities(study.sound)) {
    for (const double tau : study.relaxation_times)
      names.push_back(fmt::format("order_{}_tau_{}", quantity.name, tau));
    for (const char* column : {"constant_", "extrapolated_", "gci_"})
      names.push_back("constants." + (column + quantity.name));
  }
  return names;
}

}  // namespace

engine::Study read_plane_wave(const io::Table& top) {
  const io::Table t = top.table("plane_wave");
  WaveStudy study{.fluid = read_periodic_fluid(top, engine::Varied::NodesAndRelaxationTime),
                  .sound = t.choice("kind", {"shear", "sound"}) == "sound",
                  .direction = read_direction(t, "direction"),
                  .polarization = Vec3::Zero(),
                  .relaxation_times = t.numbers("relaxation_times"),
                  .nodes = read_resolutions(t, 3, 3),
                  .steps = t.integer("steps", 1, 10'000'000)};
  if (!study.sound) {
    study.polarization = read_direction(t, "polarization");
    if (study.polarization.dot(study.direction) != 0.0) {
      t.fail("polarization", "it is not across 'direction'", "a shear wave moves across its wave vector",
             "Choose one whose scalar product with 'direction' is 0");
    }
  }
  if (study.relaxation_times.empty())
    t.fail("relaxation_times", "there are none", "each gives a row of waves", "Give for example [0.6, 1.0]");
  for (const double tau : study.relaxation_times) {
    if (!(tau > 0.5)) {
      t.fail("relaxation_times", fmt::format("'relaxation_times' holds {}", tau),
             "the viscosity (tau - 1/2)/3 must be positive", "Use more than 0.5");
    }
  }
  std::vector<fluid::Spec> runs;
  for (const double tau : study.relaxation_times) {
    for (const std::int64_t n : study.nodes) runs.push_back(spec_of(study, tau, n));
  }
  return {.plan = plan_at_once(top, runs),
          .measures = measured_names(study),
          .run = [study](Observations& seen, Progress& progress, engine::Cost& cost) {
            run(study, seen, progress, cost);
          }};
}

}  // namespace veriflex::measures
