#include "measures/solid/beam_section.hpp"

#include "catch.hpp"

using namespace veriflex;
using namespace veriflex::measures;

namespace {

scene::SolidSpec strip(std::int64_t n, std::int64_t m) { return {solid::Block{{n, m, 4}, 1.0}, 0.025}; }
const solid::Material material{bond::Harmonic{0.26, 1.0}, 0.025};

}  // namespace

TEST_CASE("The filament's section: 34 E, 21 k_a, 16 k_a and GA = 64 k_a") {
  const BeamSection section = section_of(material, {solid::Rod{2.5, 51, 1.0}, 0.025}, 1.0);
  CHECK(section.nodes == 21.0);
  CHECK(section.spring_bending == Approx(34.0 * 0.26));
  CHECK(section.straight_bending == Approx(21.0 * 0.025));
  CHECK(section.right_bending == Approx(16.0 * 0.025));
  CHECK(section.shear == Approx(64.0 * 0.025));
}

TEST_CASE("Up to three nodes across, a section in shear stays plane") {
  for (const scene::SolidSpec& spec : {strip(2, 1), strip(2, 5), strip(3, 1), strip(3, 4)}) {
    CHECK(shear_factor(spec) == Approx(1.0).epsilon(1e-13));
  }
}

TEST_CASE("Four nodes across, by hand: 175/177") {
  // Potentials (-a, -b, b, a) with 5/4 a - 7/4 b = 3/2 and -7/4 a + 21/4 b = 1/2: a = 5/2, b = 13/14,
  // x.p = 59/7.
  CHECK(shear_factor(strip(4, 1)) == Approx(175.0 / 177.0).epsilon(1e-13));
}

TEST_CASE("A thick strip has the 5/6 of a parabolic shear flow, with n - 1 bonds across for n nodes") {
  CHECK(shear_factor(strip(40, 1)) * 39.0 / 40.0 == Approx(5.0 / 6.0).epsilon(1e-4));
}
