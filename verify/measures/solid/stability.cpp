#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/reduce.hpp"
#include "base/stop.hpp"
#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/for_all.hpp"
#include "measures/solid/noise.hpp"
#include "solid/leapfrog.hpp"
#include "solid/modes.hpp"

namespace veriflex::measures {

namespace {

using observe::Observations;
using observe::Record;

struct StabilityStudy {
  solid::Material material;
  scene::SolidSpec solid;
  std::vector<double> amplitudes;  // of the noise, each coordinate uniform in +-amplitude  [L]
  std::vector<double> prestrains;  // along z, end sections fixed there; 0 leaves the body free  [1]
  std::int64_t seeds;
  std::int64_t steps;
  double growth;      // failed when the energy departs by more than this times what the noise put in
  double resolution;  // of the boundary, relative
};

// One noisy body at one pre-strain.
struct Trial {
  double amplitude, prestrain;
  std::uint64_t seed;
};

struct Boundary {
  double dt;       // middle between the largest step that survived and the smallest that failed  [T]
  double limit;    // 2/omega_max of the pre-strained body  [T]
  double longest;  // r/r0 in the last run that survived
  double shortest;
  bool broke;  // the failing run broke (a bond at its limit, a degenerate angle, NaN) before its energy grew
};

enum class End { survived, grew, broke };

struct Run {
  End end;
  double longest, shortest;  // r/r0
};

class Body {
 public:
  Body(const StabilityStudy& study, const Trial& trial) : study_(study), network_(scene::build(study.solid)) {
    const auto nodes = network_.node_count();
    stretched_ = Positions::Zero(nodes, 3);
    stretched_.col(2) = trial.prestrain * network_.rest.col(2);
    if (trial.prestrain != 0.0) hold_ends();
    noisy_ = stretched_ + noise(nodes, trial.amplitude, trial.seed);
    if (held_.size() > 0) noisy_ = held_.select(stretched_, noisy_);
  }

  double linear_limit() const {
    const solid::FixedDofs nothing = solid::FixedDofs::Constant(network_.node_count(), 3, false);
    return 2.0 / solid::largest_frequency(study_.material, network_, stretched_,
                                          held_.size() > 0 ? held_ : nothing, 1.0);
  }

  Run run(double dt) const {
    Run run{End::survived, 1.0, 1.0};
    try {
      solid::Leapfrog motion(study_.material, network_, {.fixed = held_, .load = {}, .drive = {}}, dt, {},
                             noisy_, Positions::Zero(noisy_.rows(), 3));
      const double start = motion.potential_energy();
      const double put_in = start - resting_energy();
      track_lengths(motion.displacement(), run);
      for (std::int64_t step = 1; step <= study_.steps; ++step) {
        motion.step();
        if (step % 10 != 0 && step != study_.steps) continue;
        track_lengths(motion.displacement(), run);
        const double change = std::abs(motion.potential_energy() + motion.kinetic_energy() - start);
        if (!(change <= study_.growth * put_in)) {
          run.end = End::grew;
          return run;
        }
      }
    } catch (const NumericalFailure&) {
      if (stop::was_thrown()) throw;
      run.end = End::broke;
    }
    return run;
  }

 private:
  void hold_ends() {
    held_ = solid::FixedDofs::Constant(network_.node_count(), 3, false);
    const double last = network_.rest.col(2).maxCoeff();
    for (Eigen::Index i = 0; i < network_.node_count(); ++i) {
      const double z = network_.rest(i, 2);
      if (z == 0.0 || z == last) held_.row(i).setConstant(true);
    }
  }

  double resting_energy() const {
    return solid::Leapfrog(study_.material, network_, {}, 1.0, {}, stretched_,
                           Positions::Zero(noisy_.rows(), 3))
        .potential_energy();
  }

  void track_lengths(const Positions& u, Run& run) const {
    for (std::size_t b = 0; b < network_.bonds.size(); ++b) {
      const solid::Bond& bond = network_.bonds[b];
      const double r =
          (network_.vectors.row(static_cast<Eigen::Index>(b)) + (u.row(bond.second) - u.row(bond.first)))
              .norm() /
          network_.spacing;
      run.longest = worse(run.longest, r);
      run.shortest = lesser(run.shortest, r);
    }
  }

  const StabilityStudy& study_;
  solid::Network network_;
  Positions stretched_, noisy_;
  solid::FixedDofs held_;  // empty for a free body
};

// The first step size that fails, going upwards from a third of the linear limit, then refined by halving.
// (Survival is not monotonic: a step beyond a resonance may hold again. What a user needs is the first
// failure.)
Boundary first_failure(const StabilityStudy& study, const Trial& trial) {
  const Body body(study, trial);
  const double limit = body.linear_limit();
  constexpr double scan = 1.08;
  double good = 0.3 * limit;
  Run held = body.run(good);
  if (held.end != End::survived) {
    throw NumericalFailure(
        fmt::format("noise of {} fails already at 0.3 of the linear limit", trial.amplitude));
  }
  double bad = good;
  Run failed = held;
  while (failed.end == End::survived) {
    held = failed;
    good = bad;
    bad *= scan;
    if (bad > 3.0 * limit) throw NumericalFailure("no failure up to three times the linear limit");
    failed = body.run(bad);
  }
  while (bad - good > study.resolution * good) {
    const double middle = 0.5 * (good + bad);
    const Run run = body.run(middle);
    if (run.end == End::survived) {
      good = middle;
      held = run;
    } else {
      bad = middle;
      failed = run;
    }
  }
  return {0.5 * (good + bad), limit, held.longest, held.shortest, failed.end == End::broke};
}

double max_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), values.front(), worse);
}

double min_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), values.front(), lesser);
}

void run(const StabilityStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  std::vector<Trial> trials;
  for (const double amplitude : study.amplitudes) {
    for (const double prestrain : study.prestrains) {
      for (std::int64_t seed = 1; seed <= study.seeds; ++seed) {
        trials.push_back({amplitude, prestrain, static_cast<std::uint64_t>(seed)});
      }
    }
  }
  std::vector<Boundary> found(trials.size());
  seen.records.push_back(
      {"boundary",
       "First time step that fails",
       {{"amplitude", "", "L", "noise on each coordinate, uniform in +- amplitude", {}},
        {"prestrain", "", "1", "strain along z at which the ends are fixed; 0: free", {}},
        {"dt",
         "",
         "T",
         "middle of the last step that survived and the first that failed, median of the seeds",
         {}},
        {"dt_min", "", "T", "least of the seeds", {}},
        {"dt_max", "", "T", "largest of the seeds", {}},
        {"linear_limit", "2/omega_max", "T", "of the pre-strained body", {}},
        {"ratio", "", "1", "dt over the linear limit", {}},
        {"longest", "", "1", "r/r0 just below the boundary, worst of the seeds, seen every tenth step", {}},
        {"shortest", "", "1", "r/r0 just below the boundary, worst of the seeds, seen every tenth step", {}},
        {"broke", "", "1", "part of the seeds whose failing run broke instead of gaining energy", {}}}});
  Record& record = seen.records.back();
  const auto seeds = static_cast<std::size_t>(study.seeds);
  const auto add_row = [&](std::size_t first) {
    std::vector<double> dt;
    double longest = 0.0;
    double shortest = bond::infinity;
    double broke = 0.0;
    for (std::size_t i = first; i < first + seeds; ++i) {
      dt.push_back(found[i].dt);
      longest = worse(longest, found[i].longest);
      shortest = lesser(shortest, found[i].shortest);
      broke += found[i].broke ? 1.0 / static_cast<double>(seeds) : 0.0;
    }
    std::sort(dt.begin(), dt.end());
    const double median = 0.5 * (dt[(seeds - 1) / 2] + dt[seeds / 2]);
    record.append({trials[first].amplitude, trials[first].prestrain, median, dt.front(), dt.back(),
                   found[first].limit, median / found[first].limit, longest, shortest, broke});
  };
  for_all(
      trials.size(), "runs", progress, [&](std::size_t i) { found[i] = first_failure(study, trials[i]); },
      [&, whole = std::size_t{0}](std::size_t i) mutable {  // a row is the median of all its seeds
        whole = i % seeds == 0 ? 1 : whole + 1;
        if ((i + 1) % seeds == 0 && whole == seeds) add_row(i + 1 - seeds);
      });
  cost.finish("runs");
  const std::vector<double>& ratio = record.find("ratio")->values;
  const std::vector<double>& longest = record.find("longest")->values;
  const std::vector<double>& shortest = record.find("shortest")->values;
  seen.metrics = {
      {"min_ratio", min_of(ratio), "1", "smallest boundary over its linear limit"},
      {"max_ratio", max_of(ratio), "1", "largest boundary over its linear limit"},
      {"linear_limit", record.find("linear_limit")->values.front(), "T", "2/omega_max of the first row"},
      {"longest", max_of(longest), "1", "largest r/r0 in runs that counted as stable, seen every tenth step"},
      {"shortest", min_of(shortest), "1",
       "least r/r0 in runs that counted as stable, seen every tenth step"}};
}

}  // namespace

engine::Study read_stability(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const bond::Derivation derivation = engine::read_derivation(top, law);
  const scene::SolidSpec solid = engine::read_solid(top, law, derivation.rest_length);
  const double spacing = std::visit([](const auto& shape) { return shape.spacing; }, solid.shape);
  // Parameters that are rounded to four digits or so leave that much.
  if (!(std::abs(spacing / derivation.rest_length - 1.0) <= 1e-4)) {
    top.table("solid").fail(
        "spacing", fmt::format("'spacing' is {}", spacing),
        fmt::format("a free body would swing by itself; the rest length is {}", derivation.rest_length),
        "Leave it out, and use 'prestrains' for a strained body");
  }
  const io::Table t = top.table("stability");
  StabilityStudy study{.material = {law, solid.angle_stiffness},
                       .solid = solid,
                       .amplitudes = t.numbers("amplitudes"),
                       .prestrains = t.has("prestrains") ? t.numbers("prestrains") : std::vector<double>{0.0},
                       .seeds = t.integer("seeds", 1, 1000),
                       .steps = t.integer("steps", 10, 10'000'000),
                       .growth = t.number("growth"),
                       .resolution = t.number("resolution")};
  for (const double amplitude : study.amplitudes) {
    if (!(amplitude > 0.0))
      t.fail("amplitudes", fmt::format("amplitude {}", amplitude), "noise must put energy in",
             "Give positive lengths");
  }
  if (study.amplitudes.empty() || study.prestrains.empty()) {
    t.fail("amplitudes", "no amplitude or no prestrain", "each pair is one row", "Give at least one of each");
  }
  for (const double prestrain : study.prestrains) {
    if (bond::domain(law).contains(spacing * (1.0 + prestrain))) continue;
    t.fail("prestrains", fmt::format("prestrain {}", prestrain), "the bond law is not defined there",
           "Leave it out");
  }
  if (!(study.growth > 0.0))
    t.fail("growth", "'growth' is not positive", "it bounds the energy error", "Use 5");
  if (!(study.resolution > 1e-6) || study.resolution > 0.08) {
    t.fail("resolution", fmt::format("'resolution' is {}", study.resolution),
           "it lies between 1e-6, as each halving is a run, and 0.08, the step of the first search",
           "Use 0.005");
  }
  const bool is_free = std::all_of(study.prestrains.begin(), study.prestrains.end(),
                                   [](double strain) { return strain == 0.0; });
  return {.plan = engine::read_plan(
              top,
              {.law = law,
               .solid = solid,
               .method = is_free ? "leap-frog without sub-steps; no drag, no drive, no load"
                                 : "leap-frog without sub-steps, fixed at both ends where strained; no drag, "
                                   "no drive, no load",
               .moves = true,
               .is_free = is_free}),
          .measures = {"min_ratio", "max_ratio", "linear_limit", "longest", "shortest", "boundary.amplitude",
                       "boundary.prestrain", "boundary.dt", "boundary.ratio", "boundary.linear_limit"},
          .run = [study](Observations& seen, Progress& progress, engine::Cost& cost) {
            run(study, seen, progress, cost);
          }};
}

}  // namespace veriflex::measures
