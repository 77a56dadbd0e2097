// What the drivers of beams, bars and motion refuse, and what they measure where the answer is known by hand.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "catch.hpp"
#include "engine/case.hpp"
#include "io/document.hpp"
#include "measures/drivers.hpp"

using namespace veriflex;

namespace {

const std::string harmonic = "[bond]\nlaw = \"harmonic\"\nbond_stiffness = 0.26\nrest_length = 1.0\n";
const std::string angles = "[angle]\nstiffness = 0.025\n";
const std::string chain = "[solid]\nshape = \"chain\"\nnodes = 9\n";
const std::string wide = "[solid]\nshape = \"bar\"\nnodes = [3, 1, 9]\n";

using Read = engine::Study (*)(const io::Table&);

void refuses(Read read, const std::string& text, const std::string& message) {
  CHECK_THROWS_WITH(read(io::parse_document(text, "bad.toml")), ContainsSubstring(message));
}

observe::Observations seen_by(Read read, const std::string& text) {
  const engine::Study study = read(io::parse_document(text, "case.toml"));
  Progress progress("test");
  engine::Cost cost;
  observe::Observations seen = engine::begin(study);
  study.run(seen, progress, cost);
  return seen;
}

double measured(Read read, const std::string& text, const std::string& metric) {
  const observe::Observations seen = seen_by(read, text);
  REQUIRE(seen.metric(metric) != nullptr);
  return seen.metric(metric)->value;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

}  // namespace

TEST_CASE("The drivers of beams, bars and motion refuse what they cannot answer, and say what to do") {
  const std::string elastica = "[elastica]\nclamped = 2\nlength = 10\n";
  refuses(measures::read_elastica, harmonic + chain + elastica + "loads = [1]", "Add [angle] stiffness");
  refuses(measures::read_elastica, harmonic + angles + chain + elastica + "loads = [2, 1]",
          "loads do not rise");
  refuses(measures::read_elastica, harmonic + angles + chain + elastica + "loads = [1000]",
          "between 0 and 100");
  refuses(measures::read_elastica,
          harmonic + angles + chain + "[elastica]\nclamped = 1\nlength = 10\nloads = [1]", "Use 2");
  refuses(measures::read_buckling, harmonic + angles + chain + "[buckling]\nlength = 15", "even");
  refuses(measures::read_torsion, harmonic + angles + "[torsion]\nside = 1", "'side'");
  refuses(measures::read_shear, harmonic + angles + "[solid]\nshape = \"bar\"\nnodes = [1, 1, 9]\n",
          "1 nodes along x");
  const std::string waves = "[dispersion]\npolarisation = \"transverse\"\namplitude = 1e-6\nperiods = 2\n";
  refuses(measures::read_dispersion, harmonic + chain + waves + "mode = 1\nstep_over_limit = 0.5",
          "Add [angle]");
  refuses(measures::read_dispersion, harmonic + angles + wide + waves + "mode = 1\nstep_over_limit = 0.5",
          "more than two nodes across");
  refuses(measures::read_dispersion, harmonic + angles + chain + waves + "mode = 8\nstep_over_limit = 0.5",
          "7 sections are free");
  refuses(measures::read_dispersion, harmonic + angles + chain + waves + "mode = 1\nstep_over_limit = 1.0",
          "unstable from 1");
  refuses(measures::read_integrator,
          harmonic + chain + "[integrator]\nnoise = 0\nspeed = 1\nduration = 1\nsteps = 1", "'noise' is 0");
  refuses(measures::read_invariance,
          harmonic + chain + "[invariance]\nnoise = 1\ntranslation = -1\ntime_step = 1\nsteps = 1",
          "'translation' is -1");
}

TEST_CASE(
    "A wrong bending stiffness would show: a chain with half the angles buckles at half of Euler's load") {
  // The study's own closed form holds for any k_a; the load is proportional to it.
  const std::string study = chain + "[buckling]\nlength = 8";
  const auto strain = [&](const std::string& stiffness) {
    return -measured(measures::read_buckling, harmonic + "[angle]\nstiffness = " + stiffness + "\n" + study,
                     "strain");
  };
  // P a = 4 k_a sin^2(pi/16) with P = k e, a = 1 - e.
  const double quarter = 4.0 * std::pow(std::sin(std::numbers::pi / 16.0), 2) / 0.26;
  for (const auto& [text, k_a] : {std::pair(std::string("0.025"), 0.025), {std::string("0.0125"), 0.0125}}) {
    CHECK(strain(text) == Approx(0.5 * (1.0 - std::sqrt(1.0 - 4.0 * quarter * k_a))).epsilon(1e-9));
  }
}

TEST_CASE("Theories of a body at rest refuse another spacing than the rest length") {
  const std::string stretched = chain + "spacing = 1.05\n";
  const std::string message =
      "'spacing' is 1.05 (the theory is that of a body at rest, and the rest length is 1)";
  refuses(measures::read_beam, harmonic + angles + stretched + "[beam]\nlength = 10\nclamped = 2", message);
  refuses(measures::read_buckling, harmonic + angles + stretched + "[buckling]\nlength = 8", message);
  refuses(measures::read_elastica,
          harmonic + angles + stretched + "[elastica]\nclamped = 2\nlength = 10\nloads = [1]", message);
  refuses(measures::read_shear, harmonic + angles + wide + "spacing = 1.05\n", message);
  refuses(measures::read_integrator,
          harmonic + stretched + "[integrator]\nnoise = 0.01\nspeed = 0.01\nduration = 1\nsteps = 1",
          message);
  refuses(measures::read_oscillation,
          harmonic + "[solid]\nshape = \"pair\"\nspacing = 1.05\n" +
              "[oscillation]\nstrain = 0.1\nperiods = 3\nsteps_per_period = 100",
          message);
}

TEST_CASE("A stretched chain waves like a string: omega^2 = 4 s^2 (4 k_a s^2 + T r0)/r0^2") {
  const std::string law = "[bond]\nlaw = \"harmonic\"\nbond_stiffness = 100.0\nrest_length = 1.0\n";
  const std::string study =
      law + "[angle]\nstiffness = 1.0\n[solid]\nshape = \"chain\"\nnodes = 21\nspacing = 1.01\n" +
      "[dispersion]\npolarisation = \"transverse\"\nmode = 1\namplitude = 1e-6\nstep_over_limit = "
      "0.3\nperiods = 3\n";
  CHECK(measured(measures::read_dispersion, study, "omega_lattice") == Approx(0.158031).margin(1e-6));
  CHECK(measured(measures::read_dispersion, study, "frequency_error") < 1e-5);
  // Compressed beyond what its angles hold, it gives way instead.
  CHECK_THROWS_WITH(measured(measures::read_dispersion, replaced(study, "1.01", "0.95"), "frequency_error"),
                    ContainsSubstring("mode 1 does not swing"));
}

TEST_CASE("A time step beyond the linear limit is refused by its name") {
  const std::string study =
      harmonic + chain + "[integrator]\nnoise = 0.01\nspeed = 0.01\nduration = 2000\nsteps = 400";
  CHECK_THROWS_WITH(measured(measures::read_integrator, study, "energy_error"),
                    ContainsSubstring("leap-frog is unstable: the time step 5 is"));
  CHECK_THROWS_WITH(
      measured(measures::read_invariance,
               harmonic + chain + "[invariance]\nnoise = 0.01\ntranslation = 1\ntime_step = 5\nsteps = 10",
               "scaling_error"),
      ContainsSubstring("leap-frog is unstable"));
}

namespace {

std::string pair_of(const std::string& bond, double strain) {
  return bond + "[solid]\nshape = \"pair\"\n[oscillation]\nstrain = " + fmt::format("{:.17g}", strain) +
         "\nperiods = 3\nsteps_per_period = 100";
}

double over_harmonic(const std::string& bond, double strain) {
  return measured(measures::read_oscillation, pair_of(bond, strain), "period_over_harmonic");
}

}  // namespace

TEST_CASE("The exact period of a pair keeps its digits at any strain, across kinks and near limits") {
  const std::string fene = "[bond]\nlaw = \"fene-lj\"\nepsilon = 1.0\nsigma = 1.0\n";
  const std::string shifted = "[bond]\nlaw = \"shifted-fene\"\nbond_stiffness = 100.0\nrest_length = 1.0\n";
  CHECK(over_harmonic(fene, 1e-4) == Approx(1.0000000464).epsilon(1e-10));
  CHECK(over_harmonic(fene, 1e-3) == Approx(1.00000462353).epsilon(1e-11));
  for (const double strain : {1e-9, 1e-6, -1e-6, 0.3, -0.9})
    CHECK(std::abs(over_harmonic(harmonic, strain) - 1.0) < 1e-12);
  // The law is even about its rest length.
  for (const double strain : {0.1, 0.474})
    CHECK(over_harmonic(shifted, strain) == Approx(over_harmonic(shifted, -strain)).epsilon(1e-12));
  // Between the ends of one motion: let go at either end the period is the same, and it passes the cut-off.
  CHECK(over_harmonic(fene, 0.3) > 1.05);
}

TEST_CASE("A step beyond the linear limit is an unstable step, not a period") {
  const std::string ten =
      "[solid]\nshape = \"chain\"\nnodes = 10\n[oscillation]\nstrain = 1e-3\nperiods = 5\n";
  CHECK_THROWS_WITH(measured(measures::read_oscillation, harmonic + ten + "steps_per_period = 15", "period"),
                    ContainsSubstring("are unstable"));
  CHECK(measured(measures::read_oscillation, harmonic + ten + "steps_per_period = 40", "period_error") <
        2e-3);
  CHECK(measured(measures::read_oscillation,
                 harmonic + ten + "steps_per_period = 15\nintegrator = \"implicit-midpoint\"",
                 "period_error") < 2e-2);
}

TEST_CASE(
    "Leap-frog under a held drag is late by half a step and by half a sub-step under one that follows") {
  // x'' + g x'(t - delay) + omega^2 x = 0: the delay takes g delay off the mass.
  const auto error = [](const std::string& drag_at, const std::string& more) {
    return measured(measures::read_oscillation,
                    harmonic +
                        "[solid]\nshape = \"pair\"\n[oscillation]\nstrain = 0.01\nperiods = 3\ndrag = "
                        "0.02\ntime_step = 0.04\nsubsteps = 4\ndrag_at = \"" +
                        drag_at + "\"" + more,
                    "period_error");
  };
  const double g = 0.02, step = 0.04, substep = 0.01;
  const double swing = 2.0 * 0.26 * substep * substep / 24.0;  // of leap-frog
  CHECK(error("step", "") == Approx(0.25 * g * step + swing).epsilon(0.01));
  CHECK(error("sub-step", "") == Approx(0.25 * g * substep + swing).epsilon(0.01));
  CHECK(error("middle", "") == Approx(swing).epsilon(0.01));
}

TEST_CASE("The exact motion under drag is what an embedded Runge-Kutta method finds") {
  const std::string study = harmonic + chain +
                            "[oscillation]\nstrain = 1e-3\nperiods = 3\ndrag = 0.1\nintegrator = "
                            "\"runge-kutta\"\ntolerance = 1e-13\n";
  const observe::Observations seen = seen_by(measures::read_oscillation, study);
  CHECK(seen.metric("motion_error")->value < 1e-10);
  CHECK(std::abs(seen.metric("amplitude_drift")->value) < 1e-10);
  CHECK(seen.metric("period_error")->value < 1e-11);
  // The period is longer by the drag: omega = 2 sqrt(k) sin(pi/18).
  const double omega = 2.0 * std::sqrt(0.26) * std::sin(std::numbers::pi / 18.0);
  CHECK(seen.metric("exact_period")->value ==
        Approx(2.0 * std::numbers::pi / std::sqrt(omega * omega - 0.0025)).epsilon(1e-12));
}

TEST_CASE("A drag that the driver cannot answer for is refused") {
  const std::string study =
      harmonic + "[solid]\nshape = \"pair\"\n[oscillation]\nstrain = 0.1\nperiods = 3\n";
  const std::string steps = "steps_per_period = 100\n";
  refuses(measures::read_oscillation, study + steps + "drag = -0.1", "'drag' is -0.1");
  refuses(measures::read_oscillation, study + steps + "drag = 2.0", "nothing swings any more");
  refuses(measures::read_oscillation,
          pair_of("[bond]\nlaw = \"fene-lj\"\nepsilon = 1.0\nsigma = 1.0\n", 0.1) + "\ndrag = 0.1",
          "only a linear motion has an exact period");
  refuses(measures::read_oscillation,
          study + "tolerance = 1e-8\nintegrator = \"runge-kutta\"\ndrag = 0.1\ndrag_at = \"step\"",
          "only leap-frog has the choice");
  refuses(measures::read_oscillation, study + steps + "order = 4", "only multirate has a choice of orders");
  refuses(measures::read_oscillation, study + steps + "integrator = \"multirate\"\norder = 5", "order");
}

TEST_CASE("A pair that does not come back has no period") {
  refuses(measures::read_oscillation, pair_of(harmonic, 1.0),
          "a pair let go at a strain of 1 does not come back");
  refuses(
      measures::read_oscillation,
      pair_of("[bond]\nlaw = \"shifted-fene\"\nbond_stiffness = 100.0\nrest_length = 1.0\nextension = 2.0\n",
              1.0),
      "does not come back");
  CHECK(over_harmonic(harmonic, 0.999) == Approx(1.0).epsilon(1e-12));
  refuses(measures::read_oscillation,
          harmonic + chain + "[oscillation]\nstrain = 0.35\nperiods = 3\nsteps_per_period = 100",
          "the middle ones would be pressed to no length");
  refuses(measures::read_oscillation,
          "[bond]\nlaw = \"harmonic\"\nbond_stiffness = 1e-30\nrest_length = 1.0\n[solid]\nshape = \"pair\"\n"
          "[oscillation]\nstrain = 0.1\nperiods = 3\ntime_step = 1.0",
          "of them are the limit");
}

TEST_CASE("A stiff column buckles at a large strain, or never") {
  const auto column = [](const std::string& bond, const std::string& stiffness) {
    return bond + "[angle]\nstiffness = " + stiffness +
           "\n[solid]\nshape = \"chain\"\nnodes = 5\n[buckling]\nlength = 4";
  };
  // e (1 - e) = 4 sin^2(pi/8) k_a/k.
  CHECK(measured(measures::read_buckling, column(harmonic, "0.108"), "strain") ==
        Approx(-0.41830957272223324).epsilon(1e-9));
  CHECK_THROWS_WITH(measured(measures::read_buckling, column(harmonic, "0.112"), "strain"),
                    ContainsSubstring("the column of 4 spacings never buckles"));
  // That of harmonic bonds beside it may have no load.
  const auto seen =
      seen_by(measures::read_buckling,
              column("[bond]\nlaw = \"shifted-fene\"\nbond_stiffness = 0.26\nrest_length = 1.0\n", "0.15"));
  CHECK(seen.metric("strain")->value == Approx(-0.30519).margin(1e-5));
  CHECK(seen.metric("engesser_error")->value < 1e-6);
  CHECK(std::isnan(seen.metric("over_harmonic")->value));
}

TEST_CASE("Elastic constants are those at rest however narrow the law is") {
  const std::string narrow =
      "[bond]\nlaw = \"shifted-fene\"\nbond_stiffness = 0.26\nrest_length = 1.0\nextension = 1e-5\n";
  CHECK(measured(measures::read_elasticity, narrow, "c11") == Approx(0.26).epsilon(1e-4));
}

TEST_CASE("Numbers without sense in the keys of these drivers are refused, not run") {
  refuses(measures::read_beam,
          harmonic + angles + chain + "[beam]\nlength = 9223372036854775807\nclamped = 2", "100000");
  refuses(measures::read_beam, harmonic + angles + chain + "[beam]\nlength = 3\nclamped = 1\nfrequencies = 9",
          "'frequencies' is 9");
  const std::string waves = "[dispersion]\npolarisation = \"longitudinal\"\nmode = 1\nperiods = 2\n";
  refuses(measures::read_dispersion, harmonic + chain + waves + "amplitude = 1e-308\nstep_over_limit = 0.5",
          "'amplitude' is 1e-308");
  refuses(measures::read_dispersion, harmonic + chain + waves + "amplitude = 1e-6\nstep_over_limit = 1e-308",
          "'step_over_limit' is 1e-308");
  refuses(measures::read_oscillation,
          harmonic + "[solid]\nshape = \"pair\"\n[oscillation]\nstrain = 0.1\nperiods = 3\n" +
              "steps_per_period = 1e300",
          "a period has from 1 to 1000000 steps");
}

TEST_CASE("A 2 x 2 bar twists with J = r0^4: four bonds at half a spacing from the axis") {
  const std::string study = "[torsion]\nslenderness = 10\nside = 2";
  CHECK(measured(measures::read_torsion, harmonic + angles + study, "series_error") < 1e-12);
  CHECK(measured(measures::read_torsion, harmonic + angles + study, "bar") == Approx(1.0 / 16.0));
}

TEST_CASE("Filaments of markers are refused where their theory is another") {
  const std::string box = "[fluid]\nnodes = [16, 16, 16]\nrelaxation_time = 1.0\n";
  const std::string markers = "[coupling]\ndelta = \"4-point\"\nmarker_volume = 8.0\n";
  const std::string stiff = "[bond]\nlaw = \"harmonic\"\nbond_stiffness = 10.0\nrest_length = 1.0\n";
  const std::string chain =
      "nodes = 9\nnode_mass = 20.0\nsubsteps = 8\nelastoviscous = 2.0\namplitude = 0.01\n";
  const std::string thrust = stiff + box + markers + "[filament_thrust]\n" + chain +
                             "drive = \"hinged\"\nreynolds = 2.0\nperiods = 2\n";
  const std::string buckling =
      stiff + box + markers + "[buckling_filament]\n" + chain + "reynolds = 0.5\nstrain = 0.5\n";
  const auto refused = [&](const std::string& from, const std::string& to, const std::string& message) {
    refuses(measures::read_filament_thrust, replaced(thrust, from, to), message);
    refuses(measures::read_buckling_filament, replaced(buckling, from, to), message);
  };
  refused("rest_length = 1.0", "rest_length = 1.1", "does not rest at 1");
  refused("relaxation_time = 1.0\n", "relaxation_time = 1.0\nwalls_z = {}\n", "the box is not empty");
  refused("relaxation_time = 1.0\n", "relaxation_time = 1.0\nbody_force = [1e-6, 0, 0]\n",
          "the box is not empty");
  refused("4-point", "cosine", "4-point kernel");
  refused("marker_volume = 8.0\n", "marker_volume = 8.0\nnodes = [0, 1]\n", "not every node is coupled");
  refused("nodes = 9", "nodes = 5", "'nodes'");
  refused("nodes = 9", "nodes = 15", "image");
  refused("elastoviscous = 2.0", "elastoviscous = 0.0", "'elastoviscous'");
  refuses(measures::read_buckling_filament, replaced(buckling, "nodes = 9", "nodes = 10"), "odd");
  refuses(measures::read_filament_thrust, replaced(thrust, "hinged", "pulled"), "clamped");
  refuses(measures::read_filament_thrust, replaced(thrust, "periods = 2", "periods = 1"), "'periods'");
  refuses(measures::read_filament_thrust, replaced(thrust, "reynolds = 2.0", "reynolds = 1e6"),
          "a period takes");
}
