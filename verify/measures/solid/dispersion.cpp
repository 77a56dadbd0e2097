#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "base/reduce.hpp"
#include "bond/derive.hpp"
#include "engine/check_place.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/solid/beam_section.hpp"
#include "solid/leapfrog.hpp"
#include "solid/modes.hpp"

// Standing plane waves u_i = A sin(pi j i/n) between two fixed end sections, n spacings apart; nodes move
// along one axis only. With s = sin(pi j/2n), unit node mass, N nodes and N_x bonds along x per section,
//   longitudinal  omega^2 = 4 k s^2
//   transverse    omega^2 = 4 s^2 (4 k_a N_x/N + 4 k_a s^2 + T r0)/r0^2
// with T the bonds' tension at the spacing, zero at the rest length; and leap-frog swings with w, sin(w dt/2)
// = omega dt/2. All of this is exact for small amplitude: the fixed ends continue the lattice as its mirror
// image, so that no angle is missing.
namespace veriflex::measures {

namespace {

using observe::Observations;

struct WavesStudy {
  solid::Material material;
  scene::SolidSpec solid;
  double rest_length;  // of the law; another spacing means pre-stress  [L]
  bool longitudinal;
  std::int64_t mode;  // j: half waves between the ends
  double amplitude;   // [L]
  double fraction;    // time step over the linear limit
  int periods;        // over which the wave is followed
};

Observations dispersion_observations() {
  return {
      .records = {},
      .metrics = {{"wave_number", {}, "L^-1", "pi j over the length"},
                  {"omega", {}, "T^-1", "angular frequency, measured by dynamics"},
                  {"omega_leapfrog", {}, "T^-1", "of the lattice in leap-frog's steps"},
                  {"omega_lattice", {}, "T^-1", "of the lattice"},
                  {"omega_continuum", {}, "T^-1", "of long waves"},
                  {"frequency_error", {}, "1", "departure from leap-frog's own frequency"},
                  {"motion_error",
                   {},
                   "1",
                   "largest distance of a node from leap-frog's exact motion over the amplitude, any time"},
                  {"continuum_error", {}, "1", "departure from the continuum's frequency"},
                  {"dt_over_limit", {}, "1", "time step over the linear limit 2/omega_max"}}};
}

struct Mode {
  double wave_number;  // k = pi j/(n r0)  [L^-1]
  double lattice;      // omega of the lattice  [T^-1]
  double leapfrog;     // w of leap-frog on the lattice  [T^-1]
  double continuum;    // of long waves  [T^-1]
};

struct Seen {
  double omega;      // measured  [T^-1]
  double departure;  // largest distance of any node from leap-frog's exact motion, over the amplitude
};

class Body {
 public:
  explicit Body(const WavesStudy& study)
      : study_(study),
        network_(scene::build(study.solid)),
        section_(section_of(study.material, study.solid, network_.spacing)),
        spacings_(network_.node_count() / static_cast<Eigen::Index>(section_.nodes) - 1),
        held_(solid::FixedDofs::Constant(network_.node_count(), 3, true)) {
    const auto per_section = static_cast<Eigen::Index>(section_.nodes);
    held_.col(axis()).segment(per_section, network_.node_count() - 2 * per_section).setConstant(false);
  }

  double linear_limit() const {
    const Positions rest = Positions::Zero(network_.node_count(), 3);
    return 2.0 / solid::largest_frequency(study_.material, network_, rest, held_, 1.0);
  }

  Mode mode(double dt) const {
    const std::int64_t j = study_.mode;
    const double r0 = network_.spacing;
    const double phase = std::numbers::pi * static_cast<double>(j) / static_cast<double>(spacings_);
    const double s2 = 4.0 * std::pow(std::sin(0.5 * phase), 2);
    const double right = section_.shear / (section_.nodes * r0);
    const double straight = study_.material.angle_stiffness / (r0 * r0);
    const double k = bond::stiffness(study_.material.law, r0);
    const double stretched = r0 == study_.rest_length ? 0.0 : bond::tension(study_.material.law, r0) / r0;
    const double sideways = right + stretched;
    const double squared = study_.longitudinal ? k * s2 : s2 * (sideways + straight * s2);
    if (!(squared > 0.0)) {
      throw NumericalFailure(fmt::format(
          "mode {} does not swing: under its pre-stress the body gives way, omega^2 is {}", j, squared));
    }
    const double omega = std::sqrt(squared);
    const double long_wave = study_.longitudinal ? k : sideways != 0.0 ? sideways : straight * phase * phase;
    return {phase / r0, omega, 2.0 / dt * std::asin(0.5 * omega * dt), phase * std::sqrt(long_wave)};
  }

  Seen follow(const Mode& mode, double dt) const {
    Positions u = Positions::Zero(network_.node_count(), 3);
    u.col(axis()) = study_.amplitude * shape();
    const Positions start = u;
    solid::Leapfrog motion(study_.material, network_, {.fixed = held_, .load = {}, .drive = {}}, dt, {}, u,
                           Positions::Zero(u.rows(), 3));
    const auto project = [&] {
      return motion.displacement().cwiseProduct(start).sum() / start.squaredNorm();
    };
    const double needed = std::ceil(2.0 * std::numbers::pi * study_.periods / (mode.leapfrog * dt));
    if (!(needed <= engine::max_steps)) {
      throw NumericalFailure(fmt::format("{} periods of mode {} take {} steps, more than {}", study_.periods,
                                         study_.mode, needed, engine::max_steps));
    }
    const auto steps = static_cast<std::int64_t>(needed);
    struct Passage {
      std::int64_t step;
      double before, after;
    };
    std::vector<Passage> passages;
    double departure = 0.0;
    double before = 1.0;
    for (std::int64_t step = 1; step <= steps; ++step) {
      motion.step();
      const double exact = std::cos(mode.leapfrog * static_cast<double>(step) * dt);
      departure = worse(departure, largest_magnitude(motion.displacement() - exact * start));
      const double now = project();
      if ((before > 0.0) != (now > 0.0)) passages.push_back({step - 1, before, now});
      before = now;
    }
    if (passages.size() < 2)
      throw NumericalFailure(fmt::format("mode {} does not pass through rest twice", study_.mode));
    // Between two steps the motion is a sine of the frequency that is sought: a few iterations find it.
    double angle = mode.lattice * dt;
    for (int iteration = 0; iteration < 20; ++iteration) {
      const auto time = [&](const Passage& p) {
        return static_cast<double>(p.step) +
               std::atan2(p.before * std::sin(angle), p.before * std::cos(angle) - p.after) / angle;
      };
      const auto swing = [&](const Passage& p) {  // the same seen from above
        return Passage{p.step, std::abs(p.before), p.before > 0.0 ? p.after : -p.after};
      };
      angle = std::numbers::pi * static_cast<double>(passages.size() - 1) /
              (time(swing(passages.back())) - time(swing(passages.front())));
    }
    return {angle / dt, departure / study_.amplitude};
  }

 private:
  int axis() const { return study_.longitudinal ? 2 : 0; }

  Eigen::VectorXd shape() const {
    const double k = std::numbers::pi * static_cast<double>(study_.mode) / static_cast<double>(spacings_);
    Eigen::VectorXd sine = (k / network_.spacing * network_.rest.col(2).array()).sin();
    return held_.col(axis()).select(0.0, sine);
  }

  const WavesStudy& study_;
  solid::Network network_;
  BeamSection section_;
  std::int64_t spacings_;
  solid::FixedDofs held_;
};

void run_dispersion(const WavesStudy& study, Observations& seen, engine::Cost& cost) {
  const Body body(study);
  const double limit = body.linear_limit();
  const double dt = study.fraction * limit;
  cost.finish("linear limit");
  const Mode mode = body.mode(dt);
  const Seen found = body.follow(mode, dt);
  cost.finish("motion");
  seen.set("wave_number", mode.wave_number);
  seen.set("omega", found.omega);
  seen.set("omega_leapfrog", mode.leapfrog);
  seen.set("omega_lattice", mode.lattice);
  seen.set("omega_continuum", mode.continuum);
  seen.set("frequency_error", std::abs(found.omega / mode.leapfrog - 1.0));
  seen.set("motion_error", found.departure);
  seen.set("continuum_error", std::abs(found.omega / mode.continuum - 1.0));
  seen.set("dt_over_limit", dt / limit);
}

}  // namespace

engine::Study read_dispersion(const io::Table& top) {
  const bond::AnyLaw law = engine::read_law(top);
  const double rest_length = engine::read_derivation(top, law).rest_length;
  const scene::SolidSpec solid = engine::read_solid(top, law, rest_length);
  const io::Table t = top.table("dispersion");
  const WavesStudy study{
      .material = {law, solid.angle_stiffness},
      .solid = solid,
      .rest_length = rest_length,
      .longitudinal = t.choice("polarisation", {"longitudinal", "transverse"}) == "longitudinal",
      .mode = t.integer("mode", 1, 1'000'000'000),
      .amplitude = t.number("amplitude"),
      .fraction = t.number("step_over_limit"),
      .periods = static_cast<int>(t.integer("periods", 1, 10000))};
  if (!study.longitudinal && !(solid.angle_stiffness > 0.0)) {
    t.fail("polarisation", "a transverse wave of bonds alone", "without angles nothing drives it back",
           "Add [angle] stiffness");
  }
  const auto* block = std::get_if<solid::Block>(&solid.shape);
  if (!study.longitudinal && (block == nullptr || block->nodes[0] > 2)) {
    top.table("solid").fail(
        "shape", "a transverse wave in a body more than two nodes across",
        "its inner nodes have more right angles than its outer ones, and it does not stay plane",
        "Use a chain, or a bar with nodes = [2, ...]");
  }
  const std::int64_t sections = std::visit(
      [](const auto& shape) {
        if constexpr (std::is_same_v<std::decay_t<decltype(shape)>, solid::Rod>)
          return shape.sections;
        else
          return shape.nodes[2];
      },
      solid.shape);
  if (study.mode > sections - 2) {
    t.fail("mode", fmt::format("'mode' is {}", study.mode),
           fmt::format("mode j has j half waves between the ends, and {} sections are free", sections - 2),
           "Use a smaller one, or a longer body");
  }
  if (!(study.amplitude >= 1e-12 * rest_length) || study.amplitude > 0.1 * rest_length) {
    t.fail("amplitude", fmt::format("'amplitude' is {}", study.amplitude),
           "it must be small against the spacing and large against its rounding", "Use 1e-6");
  }
  if (!(study.fraction >= 1e-6) || !(study.fraction < 1.0)) {
    t.fail("step_over_limit", fmt::format("'step_over_limit' is {}", study.fraction),
           "leap-frog is unstable from 1, and below 1e-6 a period takes millions of steps", "Use 0.5");
  }
  return {.plan = engine::read_plan(top, {.law = law,
                                          .solid = solid,
                                          .method = "leap-frog, end sections fixed",
                                          .by = {parts::Kind::LeapFrog, parts::Kind::Constraints}}),
          .declares = dispersion_observations(),
          .run = [study](Observations& seen, Progress&, engine::Cost& cost) {
            run_dispersion(study, seen, cost);
          }};
}

}  // namespace veriflex::measures
