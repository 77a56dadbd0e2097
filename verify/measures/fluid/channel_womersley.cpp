#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "analytic/channel.hpp"
#include "measures/fluid/channel.hpp"
#include "measures/for_all.hpp"
#include "observe/field.hpp"

// An oscillating uniform force enters as a force on every node, of first order: g(t) is added after the
// collision of step t, and the velocity at time t is sum f c + g(t)/2, half of it before and half after.

namespace veriflex::measures::channel {

namespace {

using observe::Observations;
using observe::Record;

constexpr int phases = 8;  // shown, of a period
constexpr int shown = 4;   // the other half is the same with the sign changed
constexpr double max_steps = 1e9;

struct Womersley {
  Common common;
  double velocity;       // that the force alone would reach, g/omega, at the first resolution  [L T^-1]
  std::int64_t period;   // at the first resolution  [T]
  std::int64_t periods;  // until it is periodic; the last one is measured
};

struct Piece {
  std::size_t normal;
  std::int64_t nodes;
};

/// Grows as nodes^2, so that Womersley's number stays exactly.
std::int64_t period_of(const Womersley& study, std::int64_t nodes) {
  const std::int64_t first = study.common.resolutions.front();
  return study.period * (nodes * nodes) / (first * first);
}

double omega_of(const Womersley& study, std::int64_t nodes) {
  return 2.0 * std::numbers::pi / static_cast<double>(period_of(study, nodes));
}

double velocity_scale(const Womersley& study, std::int64_t nodes) {
  return study.velocity * static_cast<double>(study.common.resolutions.front()) / static_cast<double>(nodes);
}

struct Period {
  std::vector<double> velocity, exact;  // over g/omega; all nodes of a step, then the next step
};

Period last_period(const Womersley& study, const Piece& piece) {
  const std::unique_ptr<fluid::Fluid> fluid =
      fluid::make_fluid(gap(study.common.fluid, piece.normal, piece.nodes));
  const std::vector<std::int64_t> across = observe::line(fluid->spec().grid, piece.normal, {0, 0, 0});
  const auto axis = static_cast<Eigen::Index>(along(piece.normal));
  std::vector<std::int64_t> everywhere(static_cast<std::size_t>(fluid->spec().grid.count()));
  std::iota(everywhere.begin(), everywhere.end(), std::int64_t{0});
  Positions force = Positions::Zero(fluid->spec().grid.count(), 3);

  const double nu = fluid::viscosity(study.common.fluid.relaxation_time);
  const double omega = omega_of(study, piece.nodes);
  const double scale = velocity_scale(study, piece.nodes);
  const std::int64_t period = period_of(study, piece.nodes);
  std::vector<std::complex<double>> amplitude;
  for (std::int64_t j = 0; j < piece.nodes; ++j) {
    amplitude.push_back(
        omega * analytic::oscillating_poiseuille(from_wall(j), static_cast<double>(piece.nodes), omega, nu));
  }
  Period seen;
  observe::Monitor monitor(*fluid, study.common.monitor);
  for (std::int64_t step = 0; step < study.periods * period; ++step) {
    const double angle = omega * static_cast<double>(step % period);
    const double g = scale * omega * std::cos(angle);
    if (step >= (study.periods - 1) * period) {
      const Positions u = velocities_of(*fluid, across);
      for (std::size_t j = 0; j < amplitude.size(); ++j) {
        seen.velocity.push_back((u(static_cast<Eigen::Index>(j), axis) + 0.5 * g) / scale);
        seen.exact.push_back((amplitude[j] * std::polar(1.0, angle)).real());
      }
    }
    force.col(axis).setConstant(g);
    monitor.step({everywhere, &force});
  }
  monitor.at_end();
  return seen;
}

double largest_difference(const Period& a, const Period& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.velocity.size(); ++i) {
    worst = worse(worst, std::abs(a.velocity[i] - b.velocity[i]));
  }
  return worst;
}

Record profile_record(const Period& period, std::int64_t nodes) {
  Record profile{"profile",
                 "Velocity across the gap at the finest resolution, in eighths of a period",
                 {{"position", "y/H", "1", "from wall to wall", {}}}};
  const std::size_t count = period.velocity.size() / static_cast<std::size_t>(nodes);
  for (std::size_t k = 0; k < shown; ++k) {
    const auto from = static_cast<std::ptrdiff_t>(k * count / phases * static_cast<std::size_t>(nodes));
    const auto to = from + static_cast<std::ptrdiff_t>(nodes);
    const std::string name = "phase_" + std::to_string(k);
    profile.columns.push_back({name,
                               "",
                               "1",
                               "over g/omega, so many eighths of a period after the largest force",
                               {period.velocity.begin() + from, period.velocity.begin() + to}});
    profile.columns.push_back(
        {name + "_exact", "", "1", "exact", {period.exact.begin() + from, period.exact.begin() + to}});
  }
  for (std::int64_t j = 0; j < nodes; ++j) {
    profile.columns.front().values.push_back(from_wall(j) / static_cast<double>(nodes));
  }
  return profile;
}

std::vector<Piece> pieces_of(const Womersley& study) {
  const std::vector<std::int64_t>& resolutions = study.common.resolutions;
  std::vector<Piece> pieces;  // the finest first: it takes longest
  for (auto nodes = resolutions.rbegin(); nodes != resolutions.rend(); ++nodes) pieces.push_back({1, *nodes});
  for (const std::size_t normal : {0U, 2U}) pieces.push_back({normal, resolutions.front()});
  return pieces;
}

void run(const Womersley& study, Observations& seen, Progress& progress) {
  const std::vector<std::int64_t>& resolutions = study.common.resolutions;
  const std::size_t coarsest = resolutions.size() - 1;
  const std::vector<Piece> pieces = pieces_of(study);
  std::vector<Period> found(pieces.size());
  for_all(
      pieces.size(), "gaps", progress, [&](std::size_t i) { found[i] = last_period(study, pieces[i]); },
      [&](std::size_t i) {
        if (i == 0) seen.records.push_back(profile_record(found[i], pieces[i].nodes));
        if (i <= coarsest) add_errors(seen, pieces[i].nodes, error_norms(found[i].velocity, found[i].exact));
        if (i < coarsest) found[i] = {};  // only the first resolution is held against other axes
      });
  add_convergence(seen);
  seen.metrics.push_back({"axis_difference",
                          worse(largest_difference(found[coarsest + 1], found[coarsest]),
                                largest_difference(found[coarsest + 2], found[coarsest])),
                          "1", "walls across x or z against y, over g/omega, first resolution"});
  const std::int64_t nodes = resolutions.front();
  seen.metrics.push_back(
      {"womersley_number",
       0.5 * static_cast<double>(nodes) *
           std::sqrt(omega_of(study, nodes) / fluid::viscosity(study.common.fluid.relaxation_time)),
       "1", "half the gap over the thickness sqrt(nu/omega)"});
}

/// Measured and exact velocities of a period, and the list of nodes with their force  [bytes].
double beside_of(const Womersley& study, const fluid::Spec& spec) {
  const std::int64_t nodes = *std::max_element(spec.grid.size.begin(), spec.grid.size.end());
  return 2.0 * sizeof(double) * static_cast<double>(nodes) * static_cast<double>(period_of(study, nodes)) +
         (sizeof(std::int64_t) + 3.0 * sizeof(double)) * static_cast<double>(spec.grid.count());
}

}  // namespace

engine::Study read_womersley(const io::Table& top) {
  const io::Table t = top.table("channel");
  const Common common = read_common(top);
  const Womersley study{.common = common,
                        .velocity = read_velocity(t, common),
                        .period = t.integer("period", 8, 1'000'000'000),
                        .periods = t.integer("periods", 1, 10000)};
  for (const std::int64_t nodes : study.common.resolutions) {
    const std::int64_t first = study.common.resolutions.front();
    if (study.period * nodes * nodes % (phases * first * first) != 0) {
      t.fail("period", "a period is not a multiple of 8 steps at each resolution",
             "it grows with the square of the resolution, and eighths of it are shown",
             "Let resolutions be multiples of the first, and the period a multiple of 8");
    }
  }
  const double steps =
      static_cast<double>(study.periods) * static_cast<double>(period_of(study, common.resolutions.back()));
  if (steps > max_steps) {
    t.fail("period", fmt::format("the finest resolution would take {:.3g} steps", steps),
           fmt::format("{:.1g} is the most", max_steps), "Use a shorter period or fewer of them");
  }
  std::vector<std::string> measures = convergence_measures();
  measures.insert(measures.end(), {"axis_difference", "womersley_number"});
  for (int k = 0; k < shown; ++k) measures.push_back(fmt::format("profile.phase_{}", k));
  std::vector<fluid::Spec> runs;
  for (const Piece& piece : pieces_of(study)) runs.push_back(gap(common.fluid, piece.normal, piece.nodes));
  return {
      .plan = plan_at_once(top, runs, [&](const fluid::Spec& spec) { return beside_of(study, spec); }),
      .measures = measures,
      .run = [study](Observations& seen, Progress& progress, engine::Cost&) { run(study, seen, progress); }};
}

}  // namespace veriflex::measures::channel
