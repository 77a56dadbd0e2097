#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "base/named.hpp"
#include "base/quadrature.hpp"
#include "base/root.hpp"
#include "bond/derive.hpp"
#include "engine/check_place.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/solid/runge_kutta.hpp"
#include "solid/implicit_midpoint.hpp"
#include "solid/leapfrog.hpp"
#ifdef VERIFLEX_SUNDIALS
#include "measures/solid/multirate.hpp"
#endif

namespace veriflex::measures {

namespace {

using observe::Observations;

constexpr double unbounded = 100.0;  // times the start, which no bounded motion reaches

enum class Integrator { LeapFrog, ImplicitMidpoint, RungeKutta, Multirate };

constexpr std::array integrators{
    Named<Integrator>{Integrator::LeapFrog, "leap-frog", "leap_frog", "leap-frog"},
    Named<Integrator>{Integrator::ImplicitMidpoint, "implicit-midpoint", "implicit_midpoint",
                      "the implicit midpoint rule, by Newton's method"},
    Named<Integrator>{Integrator::RungeKutta, "runge-kutta", "runge_kutta",
                      "Prince and Dormand's embedded Runge-Kutta method of order 8, by GSL"},
    Named<Integrator>{Integrator::Multirate, "multirate", "multirate",
                      "a multirate infinitesimal method, by SUNDIALS"}};

// When leap-frog takes the velocity that a drag follows.
enum class DragAt { Step, Substep, Middle };

constexpr std::array drags{
    Named<DragAt>{DragAt::Step, "step", "step", "at the start of a step, and held over it"},
    Named<DragAt>{DragAt::Substep, "sub-step", "substep", "as it is carried, half a sub-step old"},
    Named<DragAt>{DragAt::Middle, "middle", "middle", "in the middle of each sub-step"}};

// What an integrator is made of.
std::vector<parts::Kind> parts_of(Integrator integrator) {
  using parts::Kind;
  switch (integrator) {
    case Integrator::LeapFrog:
      return {Kind::LeapFrog};
    case Integrator::ImplicitMidpoint:
      return {Kind::Midpoint, Kind::Statics};
    case Integrator::RungeKutta:
    case Integrator::Multirate:
      return {Kind::RungeKutta};
  }
  throw std::logic_error("no integrator");
}

struct Oscillation {
  bond::AnyLaw law;
  double rest_length;
  double exact = 0.0;  // period  [T]
  std::int64_t nodes;  // 2: a pair; more: the first mode of a free chain of harmonic bonds
  double strain;       // of the (first) bond at the start
  Integrator integrator;
  double time_step = 0.0;  // [T]; none where the step follows from
  double tolerance = 0.0;  // of a step's error, over the amplitude
  int substeps;            // of a step
  int periods;             // over which the period is measured
  double drag = 0.0;       // force per velocity and node, of unit mass  [M T^-1]
  DragAt drag_at = DragAt::Step;
  int order = 3;  // of the multirate method

  double substep() const { return time_step / substeps; }
  bool is_linear() const { return bond::name_of(law) == "harmonic"; }
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
struct FreePair {
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
double turning_point(const FreePair& pair, double start) {
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
double pair_period(const Oscillation& study) {
  const bond::Derivation derivation = bond::derive(study.law);
  FreePair pair{study.law, study.rest_length, {}};
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

double undamped_period(const Oscillation& study) {
  if (study.nodes == 2) return pair_period(study);
  const double k = bond::stiffness(study.law, study.rest_length);
  return std::numbers::pi /
         (std::sqrt(k) * std::sin(0.5 * std::numbers::pi / static_cast<double>(study.nodes)));
}

// Of a linear motion under drag: x'' + drag x' + omega^2 x = 0. Throws NumericalFailure when it does not
// swing.
double exact_period(const Oscillation& study) {
  const double period = undamped_period(study);
  const double damping = 0.5 * study.drag * period / (2.0 * std::numbers::pi);
  if (!(damping < 1.0))
    throw NumericalFailure(
        fmt::format("the drag is {:.3g} of that at which nothing swings any more", damping));
  return period / std::sqrt(1.0 - damping * damping);
}

// Shape of the motion along the axis: for a pair the change of length, for a chain its first mode.
Eigen::VectorXd shape_of(const Oscillation& study) {
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

// Where a linear motion is on the circle, shrinking under drag, that it turns on with time.
std::complex<double> place_of(const Oscillation& study, const Sample& sample) {
  const double omega = 2.0 * std::numbers::pi / study.exact;
  return {sample.amount, -(sample.rate + 0.5 * study.drag * sample.amount) / omega};
}

std::complex<double> exact_place(const Oscillation& study, const Sample& start, double time) {
  const double omega = 2.0 * std::numbers::pi / study.exact;
  return place_of(study, start) * std::exp(std::complex(-0.5 * study.drag, omega) * (time - start.time));
}

// When the cubic through both samples passes through zero.
double passage_between(const Sample& before, const Sample& after) {
  const double dt = after.time - before.time;
  const auto amount_at = [&](double s) {
    const double r = 1.0 - s;
    return r * r * (1.0 + 2.0 * s) * before.amount + s * s * (1.0 + 2.0 * r) * after.amount +
           (planted(Mutant::passage_without_rates) ? 0.0 : 1.0) * s * r * dt *
               (r * before.rate - s * after.rate);
  };
  return before.time + dt * bracketed_root(amount_at, 0.0, 1.0);
}

// What was measured of a motion.
struct Swing {
  double period;   // [T]
  double substep;  // mean length of a (sub-)step  [T]
  Sample start, end;
  std::int64_t drag_evaluations;
};

// How often a drag was evaluated, for all nodes at once.
template <class Motion>
std::int64_t drag_evaluations(const Oscillation& study, const Motion& motion) {
  if constexpr (requires { motion.drag_evaluations(); }) {
    return motion.drag_evaluations();
  } else {
    return motion.steps() * (study.drag_at == DragAt::Step ? 1 : study.substeps);
  }
}

constexpr auto plainly = [](auto& motion) { motion.step(); };

// Mean period over `periods` upward passages through rest of a motion from rest.
template <class Motion, class Step>
Swing measure(const Oscillation& study, const Eigen::VectorXd& shape, Motion motion, Step step) {
  const auto sample = [&] {
    return Sample{motion.time(), shape.dot(motion.displacement().col(2)),
                  shape.dot(motion.velocity().col(2))};
  };
  const auto mean_substep = [&] {
    return motion.time() / static_cast<double>(motion.steps()) / study.substeps;
  };
  const Sample start = sample();
  Sample before = start;
  double first = -1.0;
  int passages = 0;
  while (motion.time() < 2.0 * (study.periods + 2) * study.exact) {
    step(motion);
    const Sample now = sample();
    if (!(std::abs(now.amount) < unbounded * std::abs(start.amount))) {
      throw NumericalFailure(
          fmt::format("step {}: the motion has grown to {} times its start: steps of {} are "
                      "unstable",
                      motion.steps(), unbounded, mean_substep()),
          FailureMode::TimeStep);
    }
    if (before.amount < 0.0 && now.amount >= 0.0) {
      if (passages == 0 || passages == study.periods) {
        double passage = 0.0;
        if constexpr (requires { motion.passage(shape); }) {
          passage = motion.passage(shape);
        } else {
          passage = passage_between(before, now);
        }
        if (passages == study.periods)
          return {(passage - first) / study.periods, mean_substep(), start, now,
                  drag_evaluations(study, motion)};
        first = passage;
      }
      ++passages;
    }
    before = now;
  }
  throw NumericalFailure(
      fmt::format("steps of {}: the motion passes through rest only {} times in {} periods", mean_substep(),
                  passages, 2 * (study.periods + 2)),
      FailureMode::TimeStep);
}

Swing measure(const Oscillation& study) {
  const solid::Network network = solid::cubic_lattice({{1, 1, study.nodes}, study.rest_length});
  const solid::Material material{study.law, 0.0};
  const Eigen::VectorXd shape = shape_of(study);
  const Positions rest = Positions::Zero(study.nodes, 3);
  Positions u = rest;
  u.col(2) = study.strain * study.rest_length * shape;
  const solid::Substeps substeps{study.substeps, 0.0};
  solid::Conditions in_the_middle;
  in_the_middle.drag = study.drag;
  switch (study.integrator) {
    case Integrator::LeapFrog: {
      if (study.drag == 0.0 || study.drag_at == DragAt::Middle)
        return measure(study, shape,
                       solid::Leapfrog(material, network, in_the_middle, study.time_step, substeps, u, rest),
                       plainly);
      // As a fluid at rest would pull at every node.
      std::vector<std::int32_t> nodes(static_cast<std::size_t>(study.nodes));
      std::iota(nodes.begin(), nodes.end(), 0);
      const solid::VelocityCoupling still{nodes, rest, study.drag, study.drag_at == DragAt::Substep};
      Positions mean;
      return measure(study, shape, solid::Leapfrog(material, network, {}, study.time_step, substeps, u, rest),
                     [&](solid::Leapfrog& motion) { motion.step(still, mean); });
    }
    case Integrator::ImplicitMidpoint:
      return measure(study, shape,
                     solid::ImplicitMidpoint(material, network, in_the_middle, study.time_step, u, rest),
                     plainly);
    case Integrator::RungeKutta:
      return measure(study, shape,
                     RungeKutta(material, network, 1.0, study.drag, study.tolerance,
                                2.0 * std::numbers::pi / study.exact, u, rest),
                     plainly);
    case Integrator::Multirate:
#ifdef VERIFLEX_SUNDIALS
      return measure(study, shape,
                     Multirate(material, network, 1.0, study.drag, study.order, study.time_step,
                               study.substeps, u, rest),
                     plainly);
#else
      break;  // Study::lacks
#endif
  }
  throw std::logic_error("no integrator");
}

Observations oscillation_observations(const Oscillation& study) {
  Observations all;
  all.metrics = {{"exact_period",
                  {},
                  "T",
                  std::string(study.nodes == 2 ? "quadrature between the turning points (GSL)"
                                               : "pi/(sqrt(k/m) sin(pi/2n)) of the chain's first mode") +
                      (study.drag > 0.0 ? ", longer by the drag" : "")},
                 {"substeps_per_period", {}, "1", "(sub-)steps per exact period, of varying ones the mean"},
                 {"dt_over_limit",
                  {},
                  "1",
                  "(sub-)step, of varying ones the mean, over leap-frog's linear limit 2/omega_max at rest"},
                 {"period", {}, "T", "mean over the measured periods"},
                 {"period_error", {}, "1", "relative departure from the exact period"}};
  if (study.nodes == 2) {
    all.metrics.push_back(
        {"period_over_harmonic", {}, "1", "exact period over that of a harmonic pair of the same stiffness"});
  }
  if (study.is_linear()) {
    all.metrics.push_back(
        {"motion_error",
         {},
         "1",
         "distance from the exact motion in its phase plane after the measured periods, over "
         "the amplitude that is left then"});
    all.metrics.push_back(
        {"amplitude_drift", {}, "1", "amplitude over the exact one after the measured periods, less 1"});
  }
  if (study.drag > 0.0)
    all.metrics.push_back(
        {"drag_evaluations_per_period", {}, "1", "of all nodes at once, in an exact period"});
  return all;
}

void run_oscillation(const Oscillation& study, Observations& seen) {
  const double k = bond::stiffness(study.law, study.rest_length);
  const double limit = 2.0 / std::sqrt(study.nodes == 2 ? 2.0 * k : 4.0 * k);
  seen.set("exact_period", study.exact);
  if (study.nodes == 2)
    seen.set("period_over_harmonic", study.exact * std::sqrt(2.0 * k) / (2.0 * std::numbers::pi));
  const auto tell_steps = [&](double substep) {
    seen.set("substeps_per_period", study.exact / substep);
    seen.set("dt_over_limit", substep / limit);
  };
  const bool is_adaptive = study.integrator == Integrator::RungeKutta;
  if (!is_adaptive) tell_steps(study.substep());  // before the run: it may fail
  const Swing measured = measure(study);
  if (is_adaptive) tell_steps(measured.substep);
  seen.set("period", measured.period);
  seen.set("period_error", std::abs(measured.period / study.exact - 1.0));
  if (study.is_linear()) {
    const std::complex<double> end = place_of(study, measured.end);
    const std::complex<double> exact = exact_place(study, measured.start, measured.end.time);
    seen.set("motion_error", std::abs(end - exact) / std::abs(exact));
    seen.set("amplitude_drift", std::abs(end) / std::abs(exact) - 1.0);
  }
  if (study.drag > 0.0)
    seen.set("drag_evaluations_per_period",
             static_cast<double>(measured.drag_evaluations) * study.exact / measured.end.time);
}

double read_tolerance(const io::Table& t) {
  for (const char* key : {"time_step", "steps_per_period"}) {
    if (t.has(key))
      t.fail(key, fmt::format("'{}' is set", key), "the steps of runge-kutta follow from its tolerance",
             "Give 'tolerance' instead");
  }
  const double tolerance = t.number("tolerance");
  if (!(tolerance >= 1e-15 && tolerance <= 0.1)) {
    t.fail("tolerance", fmt::format("'tolerance' is {}", tolerance),
           "a step's error over the amplitude lies between 1e-15 and 0.1", "Use about 1e-8");
  }
  return tolerance;
}

// The step, given as a length or as a part of the exact period.
double read_time_step(const io::Table& t, double exact) {
  if (t.has("time_step") == t.has("steps_per_period")) {
    t.fail("steps_per_period", "both 'steps_per_period' and 'time_step' stand here, or neither does",
           "each gives the step", "Give one of them");
  }
  if (t.has("steps_per_period")) {
    const double steps = t.number("steps_per_period");
    if (!(steps >= 1.0 && steps <= 1e6)) {
      t.fail("steps_per_period", fmt::format("it is {}", steps), "a period has from 1 to 1000000 steps",
             "Use about 100");
    }
    return exact / steps;
  }
  const double step = t.number("time_step");
  if (!(step > 0.0))
    t.fail("time_step", fmt::format("it is {}", step), "a step is positive", "Use for example 1.0");
  return step;
}

void read_drag(const io::Table& t, Oscillation& study) {
  study.drag = t.has("drag") ? t.number("drag") : 0.0;
  if (!(study.drag >= 0.0)) {
    t.fail("drag", fmt::format("'drag' is {}", study.drag), "a drag takes energy away",
           "Use for example 0.02, or leave it out");
  }
  if (study.drag > 0.0 && !study.is_linear()) {
    t.fail("drag", fmt::format("the bonds are {}", bond::name_of(study.law)),
           "under drag only a linear motion has an exact period", "Use harmonic bonds, or leave it out");
  }
  if (!t.has("drag_at")) return;
  if (study.integrator != Integrator::LeapFrog) {
    t.fail("drag_at", "'drag_at' is set",
           "only leap-frog has the choice; the others take a drag at their stages", "Leave it out");
  }
  study.drag_at = row_named(drags, t.choice("drag_at", names_of(drags))).value;
}

#ifdef VERIFLEX_SUNDIALS
constexpr const char* without_sundials = "";
#else
constexpr const char* without_sundials =
    "this program was built without SUNDIALS, whose methods the integrator 'multirate' runs. Install it "
    "(apt-get install libsundials-dev), configure again (cmake --preset release) and build";
#endif

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
  Oscillation study{
      .law = law,
      .rest_length = derivation.rest_length,
      .nodes = block->nodes[2],
      .strain = t.number("strain"),
      .integrator = t.has("integrator")
                        ? row_named(integrators, t.choice("integrator", names_of(integrators))).value
                        : Integrator::LeapFrog,
      .substeps = t.has("substeps") ? static_cast<int>(t.integer("substeps", 1, 1'000'000)) : 1,
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
  const bool is_multirate = study.integrator == Integrator::Multirate;
  if (study.substeps > 1 && study.integrator != Integrator::LeapFrog && !is_multirate) {
    t.fail("substeps", fmt::format("'substeps' is {}", study.substeps),
           "only leap-frog and multirate divide their steps here", "Use more steps");
  }
  if (t.has("order")) {
    if (!is_multirate)
      t.fail("order", "'order' is set", "only multirate has a choice of orders", "Leave it out");
    study.order = static_cast<int>(t.integer("order", 3, 4));
  }
  read_drag(t, study);
  try {
    study.exact = exact_period(study);
  } catch (const NumericalFailure& failure) {
    t.fail("strain", "the motion has no period", failure.what(), "Use a smaller strain");
  }
  if (study.integrator == Integrator::RungeKutta) {
    study.tolerance = read_tolerance(t);
  } else {
    study.time_step = read_time_step(t, study.exact);
    const double steps = study.periods * study.exact / study.substep();
    if (!(steps <= engine::max_steps)) {
      t.fail(
          "periods", fmt::format("{} periods take {:.3g} (sub-)steps", study.periods, steps),
          fmt::format("a period lasts {:.6g}; {:.0e} of them are the limit", study.exact, engine::max_steps),
          "Use fewer steps or periods, or another unit of time");
    }
  }
  const Named<Integrator>& integrator = row_of(integrators, study.integrator);
  return {.plan = engine::read_plan(top, {.law = law,
                                          .solid = solid,
                                          .method = fmt::format("{}, from rest", integrator.text),
                                          .by = parts_of(study.integrator)}),
          .declares = oscillation_observations(study),
          .run =
              [study](Observations& seen, Progress&, engine::Cost& cost) {
                run_oscillation(study, seen);
                cost.finish("motion");
              },
          .lacks = is_multirate ? without_sundials : ""};
}

}  // namespace veriflex::measures
