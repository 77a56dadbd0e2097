#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "base/quadrature.hpp"
#include "base/root.hpp"
#include "bond/derive.hpp"
#include "drivers/drivers.hpp"
#include "engine/read_scene.hpp"
#include "solid/leapfrog.hpp"

namespace veriflex::drivers {

namespace {

using observe::Observations;
using observe::Record;

struct OscillationStudy {
  bond::AnyLaw law;
  double rest_length;
  std::int64_t nodes;               // 2: a pair; more: the first mode of a free chain of harmonic bonds
  double strain;                    // of the (first) bond at the start
  std::vector<std::int64_t> steps;  // per period, rising
  int periods;                      // over which the period is measured
};

// The period of a pair of unit masses let go at rest at this strain: 2 integral dr / sqrt(2 (E - U)/mu)
// between the turning points, mu = 1/2, with r = centre + half sin(phi), which takes the square-root ends
// away.
double pair_period(const OscillationStudy& study) {
  const double start = study.rest_length * (1.0 + study.strain);
  const double energy = bond::energy(study.law, start);
  const auto excess = [&](double r) { return bond::energy(study.law, r) - energy; };
  double outside = study.rest_length;  // on the other side of rest, where the energy is larger
  const Interval domain = bond::domain(study.law);
  do {
    outside = study.strain > 0.0 ? 0.5 * (outside + (domain.lo + 0.05 * outside))
                                 : 0.5 * (outside + std::min(domain.hi, 3.0 * outside));
  } while (!(excess(outside) > 0.0));
  const double turn =
      bracketed_root(excess, std::min(outside, study.rest_length), std::max(outside, study.rest_length));
  const double centre = 0.5 * (start + turn);
  const double half = 0.5 * std::abs(start - turn);
  return 2.0 * integral(
                   [&](double phi) {
                     const double kinetic = -excess(centre + half * std::sin(phi));
                     return half * std::cos(phi) / std::sqrt(4.0 * kinetic);
                   },
                   -0.5 * std::numbers::pi, 0.5 * std::numbers::pi);
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

// Mean period over `periods` upward passages through rest, by leap-frog with `steps` steps per exact period.
// At rest the force vanishes, so that a straight line between two steps finds the passage to third order.
double measured_period(const OscillationStudy& study, double exact, std::int64_t steps) {
  const solid::Network network = solid::cubic_lattice({{1, 1, study.nodes}, study.rest_length});
  const Eigen::VectorXd shape = shape_of(study);
  Positions u = Positions::Zero(study.nodes, 3);
  u.col(2) = study.strain * study.rest_length * shape;
  const double dt = exact / static_cast<double>(steps);
  solid::Leapfrog motion({study.law, 0.0}, network, {}, dt, {}, u, Positions::Zero(study.nodes, 3));
  double before = shape.dot(u.col(2));
  double first = -1.0;
  int passages = 0;
  while (motion.time() < 2.0 * (study.periods + 2) * exact) {
    motion.step();
    const double now = shape.dot(motion.displacement().col(2));
    if (before < 0.0 && now >= 0.0) {
      const double passage = motion.time() - dt * now / (now - before);
      if (passages == 0) first = passage;
      if (passages == study.periods) return (passage - first) / study.periods;
      ++passages;
    }
    before = now;
  }
  throw NumericalFailure(
      fmt::format("{} steps per period: the motion passes through rest only {} times in {} periods", steps,
                  passages, 2 * (study.periods + 2)));
}

Observations run(const OscillationStudy& study, Progress& progress, engine::Cost& cost) {
  const double exact = exact_period(study);
  cost.finish("exact period");
  Record record{"work_precision",
                "Error of the period against the work done",
                {{"steps_per_period", "", "1", "leap-frog steps per exact period", {}},
                 {"period", "T", "T", "mean over the measured periods", {}},
                 {"error", "", "1", "relative departure from the exact period", {}},
                 {"dt_over_limit", "", "1", "time step over the linear limit 2/omega_max at rest", {}}}};
  const double k = bond::stiffness(study.law, study.rest_length);
  const double limit = 2.0 / std::sqrt(study.nodes == 2 ? 2.0 * k : 4.0 * k);
  for (std::size_t i = 0; i < study.steps.size(); ++i) {
    progress.show("sweep", i, study.steps.size());
    const double period = measured_period(study, exact, study.steps[i]);
    const auto steps = static_cast<double>(study.steps[i]);
    record.append({steps, period, std::abs(period / exact - 1.0), exact / steps / limit});
    cost.finish(fmt::format("work_precision/{}", i));  // the run time of this row
  }
  const std::vector<double>& error = record.find("error")->values;
  const std::size_t n = error.size();
  Observations seen;
  seen.metrics = {{"exact_period", exact, "T",
                   study.nodes == 2 ? "quadrature between the turning points (GSL)"
                                    : "pi/(sqrt(k/m) sin(pi/2n)) of the chain's first mode"},
                  {"period_error", error.back(), "1", "of the finest step"},
                  {"order",
                   std::log(error[n - 2] / error[n - 1]) / std::log(static_cast<double>(study.steps[n - 1]) /
                                                                    static_cast<double>(study.steps[n - 2])),
                   "1", "order in the step, last two rows"},
                  {"dt_over_limit", record.find("dt_over_limit")->values.front(), "1",
                   "coarsest time step over the linear limit 2/omega_max at rest"},
                  {"period_over_harmonic", exact * std::sqrt(2.0 * k) / (2.0 * std::numbers::pi), "1",
                   "exact period over that of a harmonic pair of the same stiffness"}};
  if (study.nodes != 2) seen.metrics.pop_back();
  seen.records = {record};
  return seen;
}

}  // namespace

engine::Study read_oscillation(const io::Section& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const bond::Derivation derivation = engine::read_derivation(top, law);
  const io::Section t = top.table("oscillation");
  const scene::SolidSpec solid = engine::read_solid(top, law, derivation.rest_length);
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
                         .periods = static_cast<int>(t.integer("periods", 1, 10000))};
  if (study.strain == 0.0 || !bond::domain(law).contains(derivation.rest_length * (1.0 + study.strain))) {
    t.fail("strain", fmt::format("'strain' is {}", study.strain),
           "it must be nonzero and inside the law's domain", "Use about 0.1");
  }
  if (study.steps.size() < 2 || study.steps.front() < 4) {
    t.fail("steps_per_period", "fewer than two rows, or fewer than 4 steps",
           "an order needs two, leap-frog more than pi", "Give for example [20, 40, 80]");
  }
  for (std::size_t i = 1; i < study.steps.size(); ++i) {
    if (study.steps[i] <= study.steps[i - 1])
      t.fail("steps_per_period", "they do not rise", "the order is taken between neighbours", "Sort them");
  }
  return {.plan = engine::read_plan(
              top, {.law = law, .solid = solid, .method = "leap-frog, free, from rest", .moves = true}),
          .measures = {"exact_period", "period_error", "order", "dt_over_limit", "period_over_harmonic"},
          .run = [study](Progress& progress, engine::Cost& cost) { return run(study, progress, cost); }};
}

}  // namespace veriflex::drivers
