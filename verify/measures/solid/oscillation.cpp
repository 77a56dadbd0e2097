#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "base/quadrature.hpp"
#include "base/root.hpp"
#include "bond/derive.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "solid/leapfrog.hpp"

namespace veriflex::measures {

namespace {

using observe::Observations;
using observe::Record;

constexpr double max_steps = 1e9;  // of a run

struct OscillationStudy {
  bond::AnyLaw law;
  double rest_length;
  double exact = 0.0;                  // period  [T]
  std::int64_t nodes;                  // 2: a pair; more: the first mode of a free chain of harmonic bonds
  double strain;                       // of the (first) bond at the start
  std::vector<std::int64_t> steps;     // per period, rising
  std::vector<std::int64_t> substeps;  // of an outer step of 1, as in a coupled run, rising; may be empty
  int periods;                         // over which the period is measured
};

// Integral of f from 0 to `way`, smooth piece by smooth piece between the breaks.
double integral_by_pieces(const Function& f, double way, std::vector<double> breaks) {
  std::erase_if(breaks, [&](double at) { return !(0.0 < at && at < way); });
  breaks.push_back(way);
  std::sort(breaks.begin(), breaks.end());
  double sum = 0.0;
  double from = 0.0;
  for (const double to : breaks) {
    sum += integral(f, from, to);
    from = to;
  }
  return sum;
}

// A pair let go at rest: lengths are counted from the rest length, so that a small strain keeps all its
// digits.
struct Pair {
  const bond::AnyLaw& law;
  double rest;                // [L]
  std::vector<double> kinks;  // where the stiffness jumps, rising  [L]

  // The tension at x, of which rest + x would keep too few digits.
  double tension(double x) const {
    const double r = rest + x;
    return bond::tension(law, r) + bond::stiffness(law, r) * (x - (r - rest));
  }

  // The energy that is free after a start at rest at `end` and a way `inwards` (1 or -1) of this length.
  double freed(double end, double inwards, double way) const {
    std::vector<double> breaks;
    for (const double kink : kinks) breaks.push_back(inwards * (kink - end));
    return integral_by_pieces([&](double y) { return -inwards * tension(end + inwards * y); }, way, breaks);
  }
};

// The other end of the motion that starts at rest at x = start. Throws NumericalFailure when there is none.
double turning_point(const Pair& pair, double start) {
  const Interval domain = bond::domain(pair.law);
  const double limit = (start > 0.0 ? domain.lo : domain.hi) - pair.rest;
  const double inwards = start > 0.0 ? -1.0 : 1.0;
  const auto freed = [&](double x) { return pair.freed(start, inwards, std::abs(start - x)); };
  double inside = 0.0;
  double outside = std::abs(limit) <= std::abs(start) ? 0.5 * limit : -start;
  constexpr int max_tries = 40;  // each twice as far, or half as far from the limit
  for (int step = 0; step < max_tries && domain.contains(pair.rest + outside); ++step) {
    if (freed(outside) <= 0.0) {
      return bracketed_root(freed, std::min(inside, outside), std::max(inside, outside));
    }
    inside = outside;
    outside = std::abs(2.0 * outside) < std::abs(limit) ? 2.0 * outside : 0.5 * (outside + limit);
  }
  throw NumericalFailure(fmt::format(
      "a pair let go at a strain of {} does not come back: on the other side of rest nothing stops it "
      "up to a strain of {}",
      start / pair.rest, inside / pair.rest));
}

// The period of a pair of unit masses let go at rest at this strain: 2 integral dr / sqrt(2 (E - U)/mu)
// between the turning points, mu = 1/2, with r = centre + half sin(phi), which takes the square-root ends
// away. E - U is the tension's integral from the nearer end, so that nothing cancels at small strains.
double pair_period(const OscillationStudy& study) {
  const bond::Derivation derivation = bond::derive(study.law);
  Pair pair{study.law, study.rest_length, {}};
  for (const bond::Kink& kink : derivation.kinks) pair.kinks.push_back(kink.length - pair.rest);
  const double start = study.rest_length * study.strain;
  const double turn = turning_point(pair, start);
  const double half = 0.5 * std::abs(start - turn);
  const double inwards = start > turn ? -1.0 : 1.0;  // from the start
  // From one end to the middle, over the angle pi/2 - |phi|: the way from the end is taken by half of it.
  const auto quarter = [&](double end, double towards) {
    std::vector<double> breaks;  // angles at which a kink is passed
    for (const double kink : pair.kinks) {
      const double way = towards * (kink - end);
      if (0.0 < way && way < half) breaks.push_back(2.0 * std::asin(std::sqrt(0.5 * way / half)));
    }
    const auto time_per_angle = [&](double angle) {
      const double way = 2.0 * half * std::pow(std::sin(0.5 * angle), 2);
      const double kinetic = pair.freed(end, towards, way);
      if (!(kinetic > 0.0)) {
        throw NumericalFailure(
            fmt::format("a pair let go at a strain of {} turns at {}, before it is at rest length",
                        study.strain, (end + towards * way) / pair.rest));
      }
      return half * std::sin(angle) / std::sqrt(4.0 * kinetic);
    };
    return integral_by_pieces(time_per_angle, 0.5 * std::numbers::pi, breaks);
  };
  return 2.0 * (quarter(start, inwards) + quarter(turn, -inwards));
}

double exact_period(const OscillationStudy& study) {
  if (study.nodes == 2) return pair_period(study);
  const double k = bond::stiffness(study.law, study.rest_length);
  return std::numbers::pi /
         (std::sqrt(k) * std::sin(0.5 * std::numbers::pi / static_cast<double>(study.nodes)));
}

// Shape of the motion along the axis: for a pair the change of length, for a chain its first mode.
Eigen::VectorXd shape_of(const OscillationStudy& study) {
  Eigen::VectorXd shape(study.nodes);
  for (Eigen::Index i = 0; i < shape.size(); ++i) {
    shape[i] =
        -std::cos(std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(study.nodes));
  }
  return shape / (shape[1] - shape[0]);  // unit extension of the first bond
}

// Amount and rate of the motion at one time.
struct Sample {
  double time, amount, rate;
};

// When the cubic through both samples passes through zero.
double passage_between(const Sample& before, const Sample& after) {
  const double dt = after.time - before.time;
  const auto amount_at = [&](double s) {
    const double r = 1.0 - s;
    return r * r * (1.0 + 2.0 * s) * before.amount + s * s * (1.0 + 2.0 * r) * after.amount +
           s * r * dt * (r * before.rate - s * after.rate);
  };
  return before.time + dt * bracketed_root(amount_at, 0.0, 1.0);
}

// Mean period over `periods` upward passages through rest, by leap-frog with steps of dt, each of `substeps`.
double measured_period(const OscillationStudy& study, double exact, double dt, int substeps) {
  const solid::Network network = solid::cubic_lattice({{1, 1, study.nodes}, study.rest_length});
  const Eigen::VectorXd shape = shape_of(study);
  Positions u = Positions::Zero(study.nodes, 3);
  u.col(2) = study.strain * study.rest_length * shape;
  solid::Leapfrog motion({study.law, 0.0}, network, {}, dt, {substeps, 0.0}, u,
                         Positions::Zero(study.nodes, 3));
  // Velocities are known half a sub-step before.
  const auto sample = [&] {
    return Sample{motion.time(), shape.dot(motion.displacement().col(2)),
                  shape.dot(motion.half_velocity().col(2))};
  };
  Sample before = sample();
  double first = -1.0;
  int passages = 0;
  while (motion.time() < 2.0 * (study.periods + 2) * exact) {
    motion.step();
    const Sample now = sample();
    if (before.amount < 0.0 && now.amount >= 0.0) {
      const double to_step = 0.5 * (now.rate - before.rate) / substeps;
      const double passage = passage_between({before.time, before.amount, before.rate + to_step},
                                             {now.time, now.amount, now.rate + to_step});
      if (passages == 0) first = passage;
      if (passages == study.periods) return (passage - first) / study.periods;
      ++passages;
    }
    before = now;
  }
  throw NumericalFailure(
      fmt::format("steps of {}: the motion passes through rest only {} times in {} periods", dt / substeps,
                  passages, 2 * (study.periods + 2)));
}

// Order of convergence from the last two rows of a record.
double last_order(const Record& record) {
  const std::vector<double>& steps = record.find("steps_per_period")->values;
  const std::vector<double>& error = record.find("error")->values;
  const std::size_t n = error.size();
  return std::log(error[n - 2] / error[n - 1]) / std::log(steps[n - 1] / steps[n - 2]);
}

void run(const OscillationStudy& study, Observations& seen, Progress& progress, engine::Cost& cost) {
  const double exact = study.exact;
  const double k = bond::stiffness(study.law, study.rest_length);
  const double limit = 2.0 / std::sqrt(study.nodes == 2 ? 2.0 * k : 4.0 * k);
  const std::vector<observe::Column> columns{
      {"steps_per_period", "", "1", "leap-frog (sub-)steps per exact period", {}},
      {"period", "T", "T", "mean over the measured periods", {}},
      {"error", "", "1", "relative departure from the exact period", {}},
      {"dt_over_limit", "", "1", "(sub-)step over the linear limit 2/omega_max at rest", {}}};
  // Row by row, so that a run that ends early keeps what it has measured.
  const std::size_t first = seen.records.size();
  seen.records.push_back({"work_precision", "Error of the period against the work done", columns});
  if (!study.substeps.empty()) {
    seen.records.push_back({"substeps", "Error of the period with sub-steps of an outer step of 1", columns});
    seen.records.back().columns.insert(seen.records.back().columns.begin(),
                                       {"substeps", "", "1", "of an outer step of 1", {}});
  }
  Record& plain = seen.records[first];
  Record& divided = seen.records.back();
  const std::size_t rows = study.steps.size() + study.substeps.size();
  // The run time of row i is that of the phase <record>/i.
  for (std::size_t i = 0; i < study.steps.size(); ++i) {
    progress.show("sweep", i, rows);
    const auto steps = static_cast<double>(study.steps[i]);
    const double period = measured_period(study, exact, exact / steps, 1);
    plain.append({steps, period, std::abs(period / exact - 1.0), exact / steps / limit});
    cost.finish(fmt::format("work_precision/{}", i));
  }
  for (std::size_t i = 0; i < study.substeps.size(); ++i) {
    progress.show("sweep", study.steps.size() + i, rows);
    const auto substeps = static_cast<double>(study.substeps[i]);
    const double period = measured_period(study, exact, 1.0, static_cast<int>(study.substeps[i]));
    divided.append(
        {substeps, exact * substeps, period, std::abs(period / exact - 1.0), 1.0 / substeps / limit});
    cost.finish(fmt::format("substeps/{}", i));
  }
  seen.metrics = {{"exact_period", exact, "T",
                   study.nodes == 2 ? "quadrature between the turning points (GSL)"
                                    : "pi/(sqrt(k/m) sin(pi/2n)) of the chain's first mode"},
                  {"period_error", plain.find("error")->values.back(), "1", "of the finest step"},
                  {"order", last_order(plain), "1", "order in the step, last two rows"},
                  {"dt_over_limit", plain.find("dt_over_limit")->values.front(), "1",
                   "coarsest time step over the linear limit 2/omega_max at rest"},
                  {"period_over_harmonic", exact * std::sqrt(2.0 * k) / (2.0 * std::numbers::pi), "1",
                   "exact period over that of a harmonic pair of the same stiffness"}};
  if (study.nodes != 2) seen.metrics.pop_back();
  if (!study.substeps.empty()) {
    seen.metrics.push_back(
        {"substep_error", divided.find("error")->values.back(), "1", "with the most sub-steps"});
    seen.metrics.push_back(
        {"substep_order", last_order(divided), "1", "order in the sub-step, last two rows"});
  }
}

}  // namespace

engine::Study read_oscillation(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const bond::Derivation derivation = engine::read_derivation(top, law);
  const io::Table t = top.table("oscillation");
  const scene::SolidSpec solid = engine::read_solid_at_rest(top, law, derivation.rest_length);
  const auto* block = std::get_if<solid::Block>(&solid.shape);
  const bool is_line =
      block != nullptr && block->nodes[0] == 1 && block->nodes[1] == 1 && solid.angle_stiffness == 0.0;
  if (!is_line || (block->nodes[2] > 2 && bond::name_of(law) != "harmonic")) {
    top.table("solid").fail("shape", "the oscillation driver moves a pair, or a chain of harmonic bonds",
                            "only these have an exact period", "Use shape = \"pair\"");
  }
  OscillationStudy study{.law = law,
                         .rest_length = derivation.rest_length,
                         .nodes = block->nodes[2],
                         .strain = t.number("strain"),
                         .steps = t.integers("steps_per_period"),
                         .substeps = t.has("substeps") ? t.integers("substeps") : std::vector<std::int64_t>{},
                         .periods = static_cast<int>(t.integer("periods", 1, 10000))};
  if (study.strain == 0.0 || !bond::domain(law).contains(derivation.rest_length * (1.0 + study.strain))) {
    t.fail("strain", fmt::format("'strain' is {}", study.strain),
           "it must be nonzero and inside the law's domain", "Use about 0.1");
  }
  // The middle bonds of a chain are strained most, by 1/sin(pi/n) times the first.
  if (study.nodes > 2 &&
      !(std::abs(study.strain) < std::sin(std::numbers::pi / static_cast<double>(study.nodes)))) {
    t.fail("strain", fmt::format("'strain' is {}", study.strain),
           fmt::format(
               "with the first bond of {} nodes strained so, the middle ones would be pressed to no length",
               study.nodes),
           "Use a smaller strain");
  }
  if (study.steps.size() < 2 || study.steps.front() < 4 || study.steps.back() > 1'000'000) {
    t.fail("steps_per_period", "fewer than two rows, or a number outside 4 to 1000000",
           "an order needs two, leap-frog more than pi", "Give for example [20, 40, 80]");
  }
  const bool one_row = study.substeps.size() == 1;
  const bool out_of_range =
      !study.substeps.empty() && (study.substeps.front() < 1 || study.substeps.back() > 1'000'000);
  if (one_row || out_of_range) {
    t.fail("substeps", "fewer than two rows, or a number outside 1 to 1000000",
           "an order needs two; an outer step of 1 is divided", "Give for example [1, 2, 4, 8]");
  }
  const auto need_rising = [&](const std::string& key, const std::vector<std::int64_t>& values) {
    if (std::adjacent_find(values.begin(), values.end(), std::greater_equal<>{}) != values.end())
      t.fail(key, "they do not rise", "the order is taken between neighbours", "Sort them");
  };
  need_rising("steps_per_period", study.steps);
  need_rising("substeps", study.substeps);
  try {
    study.exact = exact_period(study);
  } catch (const NumericalFailure& failure) {
    t.fail("strain", "the motion has no period", failure.what(), "Use a smaller strain");
  }
  const auto refuse_endless = [&](const char* key, double steps) {
    if (steps * study.periods <= max_steps) return;
    t.fail(key, fmt::format("{} periods take {:.3g} steps", study.periods, steps * study.periods),
           fmt::format("a period lasts {:.6g}; {:.0e} steps are the limit", study.exact, max_steps),
           "Use fewer steps or periods, or another unit of time");
  };
  refuse_endless("steps_per_period", static_cast<double>(study.steps.back()));
  if (!study.substeps.empty())
    refuse_endless("substeps", study.exact * static_cast<double>(study.substeps.back()));
  return {.plan = engine::read_plan(
              top,
              {.law = law, .solid = solid, .method = "leap-frog, from rest", .moves = true, .is_free = true}),
          .measures = {"exact_period", "period_error", "order", "dt_over_limit", "period_over_harmonic",
                       "substep_error", "substep_order", "work_precision.steps_per_period",
                       "work_precision.period", "work_precision.error", "substeps.substeps",
                       "substeps.period", "substeps.error"},
          .run = [study](Observations& seen, Progress& progress, engine::Cost& cost) {
            run(study, seen, progress, cost);
          }};
}

}  // namespace veriflex::measures
