// What the drivers of beams, bars and motion refuse, and what they measure where the answer is known by hand.
#include <cmath>
#include <numbers>

#include "catch.hpp"
#include "drivers/drivers.hpp"
#include "engine/case.hpp"
#include "io/document.hpp"

using namespace veriflex;

namespace {

const std::string harmonic = "[bond]\nlaw = \"harmonic\"\nbond_stiffness = 0.26\nrest_length = 1.0\n";
const std::string angles = "[angle]\nstiffness = 0.025\n";
const std::string chain = "[solid]\nshape = \"chain\"\nnodes = 9\n";
const std::string wide = "[solid]\nshape = \"bar\"\nnodes = [3, 1, 9]\n";

using Read = engine::Study (*)(const io::Section&);

void refuses(Read read, const std::string& text, const std::string& message) {
  CHECK_THROWS_WITH(read(io::parse_document(text, "bad.toml")), ContainsSubstring(message));
}

double measured(Read read, const std::string& text, const std::string& metric) {
  const engine::Study study = read(io::parse_document(text, "case.toml"));
  Progress progress("test");
  engine::Cost cost;
  observe::Observations seen;
  study.run(seen, progress, cost);
  REQUIRE(seen.metric(metric) != nullptr);
  return seen.metric(metric)->value;
}

}  // namespace

TEST_CASE("The drivers of beams, bars and motion refuse what they cannot answer, and say what to do") {
  const std::string elastica = "[elastica]\nclamped = 2\nlengths = [10, 20]\n";
  refuses(drivers::read_elastica, harmonic + chain + elastica + "loads = [1]", "Add [angle] stiffness");
  refuses(drivers::read_elastica, harmonic + angles + chain + elastica + "loads = [2, 1]",
          "loads do not rise");
  refuses(drivers::read_elastica, harmonic + angles + chain + elastica + "loads = [1000]",
          "between 0 and 100");
  refuses(drivers::read_elastica,
          harmonic + angles + chain + "[elastica]\nclamped = 1\nlengths = [10, 20]\nloads = [1]", "Use 2");
  refuses(drivers::read_buckling, harmonic + angles + chain + "[buckling]\nlengths = [8, 15]", "even");
  refuses(drivers::read_torsion,
          harmonic + angles + "[torsion]\nslenderness = 4\nsides = [3]\nsections = [8, 16]", "'sides'");
  refuses(drivers::read_shear, harmonic + angles + wide + "[shear]\nwidths = [8]", "rising");
  const std::string waves = "[waves]\npolarisation = \"transverse\"\namplitude = 1e-6\nperiods = 2\n";
  refuses(drivers::read_waves, harmonic + chain + waves + "modes = [1, 2]\nstep_over_limit = 0.5",
          "Add [angle]");
  refuses(drivers::read_waves, harmonic + angles + wide + waves + "modes = [1, 2]\nstep_over_limit = 0.5",
          "more than two nodes across");
  refuses(drivers::read_waves, harmonic + angles + chain + waves + "modes = [1, 8]\nstep_over_limit = 0.5",
          "free sections");
  refuses(drivers::read_waves, harmonic + angles + chain + waves + "modes = [1, 2]\nstep_over_limit = 1.0",
          "unstable from 1");
  refuses(drivers::read_motion,
          harmonic + chain + "[motion]\nnoise = 0\nspeed = 1\nduration = 1\nsteps = [1, 2]", "'noise' is 0");
  refuses(drivers::read_invariance,
          harmonic + chain + "[invariance]\nnoise = 1\ntranslation = -1\ntime_step = 1\nsteps = 1",
          "'translation' is -1");
}

TEST_CASE(
    "A wrong bending stiffness would show: a chain with half the angles buckles at half of Euler's load") {
  // The study's own closed form holds for any k_a; the load is proportional to it.
  const std::string study = chain + "[buckling]\nlengths = [8, 16]";
  const auto strain = [&](const std::string& stiffness) {
    return measured(drivers::read_buckling, harmonic + "[angle]\nstiffness = " + stiffness + "\n" + study,
                    "largest_strain");
  };
  // P a = 4 k_a sin^2(pi/16) with P = k e, a = 1 - e.
  const double quarter = 4.0 * std::pow(std::sin(std::numbers::pi / 16.0), 2) / 0.26;
  for (const auto& [text, k_a] : {std::pair(std::string("0.025"), 0.025), {std::string("0.0125"), 0.0125}}) {
    CHECK(strain(text) == Approx(0.5 * (1.0 - std::sqrt(1.0 - 4.0 * quarter * k_a))).epsilon(1e-9));
  }
}

TEST_CASE("A 2 x 2 bar twists with J = r0^4: four bonds at half a spacing from the axis") {
  const std::string study = "[torsion]\nslenderness = 10\nsides = [2, 3]\nsections = [2, 3]";
  CHECK(measured(drivers::read_torsion, harmonic + angles + study, "series_error") < 1e-12);
}
