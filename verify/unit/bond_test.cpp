#include <cmath>

#include "base/error.hpp"
#include "bond/derive.hpp"
#include "catch.hpp"

using namespace veriflex;
using namespace veriflex::bond;

namespace {

AnyLaw fene_lj(double epsilon, double sigma, std::optional<double> fene_k = {},
               std::optional<double> r_max = {}, std::optional<double> cutoff = {}) {
  return make_law("fene-lj", [=](const std::string& name) -> std::optional<double> {
    if (name == "epsilon") return epsilon;
    if (name == "sigma") return sigma;
    if (name == "fene_k") return fene_k;
    if (name == "r_max") return r_max;
    return name == "cutoff" ? cutoff : std::nullopt;
  });
}

std::vector<AnyLaw> examples() {
  return {Harmonic{2.5, 0.8}, ShiftedFene{2.5, 0.8, 0.3}, fene_lj(1.0, 1.0),
          fene_lj(0.3, 1.7, 9.0, 2.2, infinity), fene_lj(1.0, 1.0, 30.0, 1.5, 1.3)};
}

// Lengths all over the domain, away from its ends and the kinks.
std::vector<double> lengths(const AnyLaw& law) {
  const double rest = derive(law).rest_length;
  const Interval d = domain(law);
  const double lo = std::max(d.lo, 0.7 * rest);
  const double hi = std::min(d.hi, 2.0 * rest);
  std::vector<double> all;
  for (int i = 1; i < 20; ++i) all.push_back(lo + (hi - lo) * (0.05 * i + 0.003));
  return all;
}

bool same_bits(double a, double b) { return a == b && std::signbit(a) == std::signbit(b); }

}  // namespace

TEST_CASE("Tension is the derivative of the energy, stiffness that of the tension") {
  for (const AnyLaw& law : examples()) {
    for (const double r : lengths(law)) {
      INFO(name_of(law) << " at r = " << r);
      const double width = 1e-4 * r;
      const Derivative t = central_derivative([&](double x) { return energy(law, x); }, r, width);
      const Derivative k = central_derivative([&](double x) { return tension(law, x); }, r, width);
      const double scale = stiffness(law, derive(law).rest_length);
      CHECK(std::abs(t.value - tension(law, r)) <= 10.0 * t.error + 1e-9 * scale * r);
      CHECK(std::abs(k.value - stiffness(law, r)) <= 10.0 * k.error + 1e-9 * scale);
    }
  }
}

TEST_CASE("A law is defined inside its domain and nowhere else") {
  const FeneLj fene = std::get<FeneLj>(fene_lj(1.0, 1.0));
  CHECK(admits(fene, std::nextafter(1.5, 0.0)));
  CHECK_FALSE(admits(fene, 1.5));
  CHECK_FALSE(admits(fene, 0.0));
  CHECK_FALSE(admits(fene, std::nan("")));
  CHECK(admits(Harmonic{1.0, 1.0}, 1e300));
  CHECK_FALSE(admits(Harmonic{1.0, 1.0}, 0.0));
  CHECK_FALSE(admits(ShiftedFene{1.0, 1.0, 0.5}, 0.5));
  CHECK_FALSE(admits(ShiftedFene{1.0, 1.0, 2.0}, 0.0));  // D > r0: a length is still positive
}

TEST_CASE(
    "The energy of the FENE-LJ bond is continuous at the cut-off, and zero with the paper's default there") {
  const FeneLj b = std::get<FeneLj>(fene_lj(1.0, 1.0));
  CHECK(b.energy(std::nextafter(b.cutoff, 0.0)) == Approx(b.energy(b.cutoff)).epsilon(1e-14));
  const double fene_alone = -0.5 * 30.0 * 2.25 * std::log(1.0 - b.cutoff * b.cutoff / 2.25);
  CHECK(b.energy(b.cutoff) == Approx(fene_alone).epsilon(1e-14));
}

TEST_CASE("The rest state of the paper's bond has the exact values") {
  const Derivation d = derive(fene_lj(1.0, 1.0));
  CHECK(d.rest_length == Approx(0.960897198959255419480617).epsilon(1e-14));
  CHECK(d.stiffness == Approx(981.255051955136331316).epsilon(1e-14));
  CHECK(d.force_per_strain == Approx(942.885230888308949149).epsilon(1e-14));
  CHECK(d.young_modulus == Approx(1021.186296534041763399).epsilon(1e-14));
  CHECK(*d.stiffness_over_fene_k == Approx(32.7085).epsilon(1e-6));
  CHECK(*d.strain_at_r_max == Approx(0.561041).epsilon(1e-6));
  REQUIRE(d.kinks.size() == 1);
  CHECK(std::abs(d.kinks[0].tension_jump) < 1e-12);
  CHECK(d.kinks[0].tangent_below == Approx(0.30455).epsilon(1e-4));
  CHECK(d.kinks[0].tangent_above == Approx(0.24631).epsilon(1e-4));  // of FENE alone
  CHECK(d.min_tangent_ratio == Approx(0.24631).epsilon(1e-5));
  CHECK(d.min_tangent_strain == Approx(0.16814).epsilon(1e-5));
  const Derivation tight = derive(fene_lj(1.0, 1.0, 40.0, 1.35));
  CHECK(tight.rest_length == Approx(0.938137323331196937928462).epsilon(1e-14));
}

TEST_CASE("The search for the rest length ends there, each of its last steps with far fewer wrong digits") {
  for (const AnyLaw& law : examples()) {
    const double rest = derive(law).rest_length;
    std::vector<double> errors;
    for (const double r : rest_length_search(law)) {
      const double error = std::abs(r / rest - 1.0);
      if (errors.empty() || error < errors.back()) errors.push_back(error);
    }
    CHECK(errors.back() == 0.0);
    CHECK(errors.size() < 20);
    for (std::size_t i = 1; i < errors.size(); ++i)
      if (errors[i - 1] < 1e-3) CHECK(errors[i] < std::max(1e-15, 0.05 * errors[i - 1]));
  }
}

TEST_CASE("At any length a bond has the modulus and the force per strain of its stiffness there") {
  const AnyLaw law = fene_lj(1.0, 1.0);
  const double length = 1.2, k = stiffness(law, length);
  CHECK(derive_at(law, length).force_per_strain == Approx(k * length).epsilon(1e-14));
  CHECK(derive_at(law, length).young_modulus == Approx(k / length).epsilon(1e-14));
}

TEST_CASE("At the rest length no double is nearer to zero tension") {
  for (const AnyLaw& law : examples()) {
    const double r = derive(law).rest_length;
    CHECK(std::abs(tension(law, r)) <= std::abs(tension(law, std::nextafter(r, 0.0))));
    CHECK(std::abs(tension(law, r)) <= std::abs(tension(law, std::nextafter(r, 2.0 * r))));
  }
}

TEST_CASE("Scaling eta and sigma by powers of two changes no dimensionless result by a bit") {
  const Derivation unit = derive(fene_lj(1.0, 1.0));
  for (const int energy_power : {-40, -3, 0, 1, 39}) {
    for (const int length_power : {-20, 0, 7}) {
      const double eta = std::ldexp(1.0, energy_power);
      const double sigma = std::ldexp(1.0, length_power);
      const Derivation d = derive(fene_lj(eta, sigma));
      INFO("eta = " << eta << ", sigma = " << sigma);
      CHECK(same_bits(d.rest_length / sigma, unit.rest_length));
      CHECK(same_bits(d.stiffness * sigma * sigma / eta, unit.stiffness));
      CHECK(same_bits(d.young_modulus * sigma * sigma * sigma / eta, unit.young_modulus));
      CHECK(same_bits(*d.stiffness_over_fene_k, *unit.stiffness_over_fene_k));
      CHECK(same_bits(*d.strain_at_r_max, *unit.strain_at_r_max));
      CHECK(same_bits(d.min_tangent_ratio, unit.min_tangent_ratio));
      CHECK(same_bits(d.min_tangent_strain, unit.min_tangent_strain));
      for (std::size_t i = 0; i < d.validity.size(); ++i) {
        CHECK(same_bits(d.validity[i].secant.lo, unit.validity[i].secant.lo));
        CHECK(same_bits(d.validity[i].secant.hi, unit.validity[i].secant.hi));
        CHECK(same_bits(d.validity[i].tangent.lo, unit.validity[i].tangent.lo));
        CHECK(same_bits(d.validity[i].tangent.hi, unit.validity[i].tangent.hi));
      }
    }
  }
}

TEST_CASE("The derivation holds for any size of eta and sigma") {
  const Derivation unit = derive(fene_lj(1.0, 1.0));
  for (const double eta : {1e-30, 1e-12, 3.7e-5, 0.000287, 1.9, 1e12, 1e30}) {
    for (const double sigma : {1e-6, 1.0407, 3e5}) {
      const Derivation d = derive(fene_lj(eta, sigma));
      CHECK(d.rest_length / sigma == Approx(unit.rest_length).epsilon(1e-15));
      CHECK(d.young_modulus / eta * sigma * sigma * sigma == Approx(unit.young_modulus).epsilon(1e-14));
    }
  }
}

TEST_CASE("Calibration inverts derivation for every law") {
  for (const AnyLaw& prototype : examples()) {
    for (const double young : {1e-9, 0.26, 1021.0, 1e8}) {
      for (const double spacing : {0.01, 1.0, 12.5}) {
        const Calibration c = calibrate(prototype, young, spacing, 0.3);
        const Derivation d = derive(c.law);
        CHECK(std::abs(d.young_modulus / young - 1.0) <= 1e-13);
        CHECK(std::abs(d.rest_length / spacing - 1.0) <= 1e-14);
        CHECK(c.angle_stiffness == Approx(young * spacing * spacing * spacing / 10.4).epsilon(1e-14));
        CHECK(d.validity[0].secant.hi == Approx(derive(prototype).validity[0].secant.hi).epsilon(1e-10));
      }
    }
  }
}

TEST_CASE("The paper's filament, calibrated: sigma, eta and k_a for E = 0.26, nu = 0.3 at spacing 1") {
  const Calibration c = calibrate(fene_lj(1.0, 1.0), 0.26, 1.0, 0.3);
  CHECK(std::get<FeneLj>(c.law).sigma == Approx(1.040694052478347).epsilon(1e-14));
  CHECK(std::get<FeneLj>(c.law).epsilon == Approx(2.86970720062559e-4).epsilon(1e-13));
  CHECK(c.angle_stiffness == Approx(0.025).epsilon(1e-15));
}

TEST_CASE("Differences of the tension agree with U'' however near a kink or a limit stands") {
  // A rest length just below R0, one just below the cut-off, a law that is defined in a millionth of its
  // length.
  const AnyLaw near_limits[]{fene_lj(1.0, 1.0, {}, 0.5), fene_lj(1.0, 1.0, 1e-3),
                             ShiftedFene{100.0, 1.0, 1e-6}, fene_lj(1.0, 1.0)};
  for (const AnyLaw& law : near_limits) {
    const Derivation d = derive(law);
    INFO(name_of(law) << " at rest at " << d.rest_length << ", smooth over " << d.smooth_radius);
    CHECK(std::abs(d.stiffness_by_differences.value / d.stiffness - 1.0) < 1e-4);
  }
  CHECK(derive(fene_lj(1.0, 1.0)).smooth_radius ==
        Approx(1.122462048309373 - 0.960897198959255).epsilon(1e-12));
  CHECK(derive(Harmonic{0.26, 2.0}).smooth_radius == 2.0);
  // Where only a few doubles lie between rest and limit there is no difference to take.
  CHECK(std::isnan(derive(fene_lj(1.0, 1.0, {}, 0.1)).stiffness_by_differences.value));
}

TEST_CASE("A calibration that leaves double precision is refused, not rounded to nothing") {
  const auto refused = [](double young, double spacing) -> std::string {
    try {
      calibrate(fene_lj(1.0, 1.0), young, spacing, 0.3);
    } catch (const BadParameter& bad) {
      return bad.parameter;
    }
    return "";
  };
  CHECK(refused(2e11, 1e-110) == "spacing");
  CHECK(refused(1e-300, 1e-5) == "spacing");
  CHECK(refused(1e300, 1e10) == "spacing");
  CHECK(refused(2e11, 1e-90).empty());
}

TEST_CASE("Poisson's ratio may be anything above -1, where the shear modulus has no end") {
  for (const double poisson : std::vector<double>{-1.0, -1.005, -2.0, -INFINITY, INFINITY, NAN}) {
    INFO(poisson);
    try {
      calibrate(fene_lj(1.0, 1.0), 0.26, 1.0, poisson);
      FAIL("accepted");
    } catch (const BadParameter& bad) {
      CHECK(bad.parameter == "poisson");
    }
  }
  const double nearly = calibrate(fene_lj(1.0, 1.0), 0.26, 1.0, -0.999).angle_stiffness;
  CHECK(nearly == Approx(0.26 / (8.0 * 0.001)).epsilon(1e-10));
}

TEST_CASE("Validity ranges: every strain inside keeps the tolerance, the next outside does not") {
  for (const AnyLaw& law : examples()) {
    const Derivation d = derive(law);
    for (const Validity& v : d.validity) {
      const auto secant_error = [&](double strain) {
        return std::abs(tension(law, d.rest_length * (1.0 + strain)) / (d.force_per_strain * strain) - 1.0);
      };
      const auto tangent_error = [&](double strain) {
        return std::abs(stiffness(law, d.rest_length * (1.0 + strain)) / d.stiffness - 1.0);
      };
      INFO(name_of(law) << ", tolerance " << v.tolerance);
      for (const double end : {v.secant.lo, v.secant.hi}) {
        if (!std::isfinite(end) || end == -1.0) continue;
        for (const double part : {0.1, 0.5, 0.9, 0.999}) CHECK(secant_error(part * end) < v.tolerance);
        CHECK(secant_error(1.001 * end) > v.tolerance);
      }
      for (const double end : {v.tangent.lo, v.tangent.hi}) {
        if (!std::isfinite(end) || end == -1.0) continue;
        for (const double part : {0.1, 0.5, 0.9, 0.999}) CHECK(tangent_error(part * end) < v.tolerance);
        CHECK(tangent_error(1.001 * end) > v.tolerance);
      }
    }
  }
}

TEST_CASE("A validity range ends at the first departure, also of a law whose ratio comes back") {
  // Lennard-Jones softens these bonds, FENE stiffens them again: the tangent, or the secant, comes back into
  // its tolerance before it leaves it for good.
  for (const AnyLaw& law : {fene_lj(1.0, 1.0, 25.0, 1.18, infinity), fene_lj(1.0, 1.0, 58.0, 2.45, infinity),
                            fene_lj(1.0, 1.0, 1.0, 1.16, infinity), fene_lj(1.0, 1.0, 27.0, 2.22, 1.27)}) {
    const Derivation d = derive(law);
    int come_back = 0;
    for (const Validity& v : d.validity) {
      const auto secant_error = [&](double strain) {
        return std::abs(tension(law, d.rest_length * (1.0 + strain)) / (d.force_per_strain * strain) - 1.0);
      };
      const auto tangent_error = [&](double strain) {
        return std::abs(stiffness(law, d.rest_length * (1.0 + strain)) / d.stiffness - 1.0);
      };
      INFO("fene_k " << parameters_of(law)[2].value << ", tolerance " << v.tolerance);
      const auto inside = [&](const Interval& range, const Function& error) {
        CHECK(range.lo > -1.0);
        CHECK(range.hi < *d.strain_at_r_max);
        for (const double end : {range.lo, range.hi}) {
          double largest = 0.0;
          for (int i = 1; i < 1000; ++i) largest = std::max(largest, error(0.001 * i * end));
          CHECK(largest < v.tolerance);
        }
        bool left = false, back = false;
        for (double strain = range.hi; strain < *d.strain_at_r_max; strain += 1e-3) {
          left = left || error(strain) > v.tolerance;
          back = back || (left && error(strain) < v.tolerance);
        }
        come_back += back ? 1 : 0;
      };
      inside(v.secant, secant_error);
      inside(v.tangent, tangent_error);
    }
    CHECK(come_back > 0);
  }
}

TEST_CASE("A harmonic bond is linear without limit, its lower end a bond of no length") {
  const Derivation d = derive(Harmonic{0.26, 1.0});
  CHECK(d.rest_length == 1.0);
  CHECK(d.young_modulus == 0.26);
  CHECK_FALSE(d.strain_at_r_max.has_value());
  CHECK_FALSE(d.stiffness_over_fene_k.has_value());
  CHECK(d.validity[0].secant.lo == -1.0);
  CHECK(std::isinf(d.validity[0].secant.hi));
}

TEST_CASE("Secant ratios of the FENE-LJ bond at the strains usually quoted") {
  const AnyLaw law = fene_lj(1.0, 1.0);
  const Derivation d = derive(law);
  const auto secant = [&](double strain) {
    return tension(law, d.rest_length * (1.0 + strain)) / (d.force_per_strain * strain);
  };
  for (const auto& [strain, ratio] : {std::pair{-0.01, 1.070},
                                      {0.01, 0.937},
                                      {0.05, 0.744},
                                      {0.10, 0.593},
                                      {0.30, 0.432},
                                      {-0.05, 1.445},
                                      {-0.10, 2.248}}) {
    CHECK(secant(strain) == Approx(ratio).margin(5e-4));
  }
}

TEST_CASE("Laws without sense are refused by the name of the parameter") {
  const auto parameter_of = [](const auto& make) -> std::string {
    try {
      derive(make());
    } catch (const BadParameter& bad) {
      return bad.parameter;
    }
    return "";
  };
  CHECK(parameter_of([] { return fene_lj(-1.0, 1.0); }) == "epsilon");
  CHECK(parameter_of([] { return fene_lj(1.0, 0.0); }) == "sigma");
  CHECK(parameter_of([] { return fene_lj(1.0, 1.0, std::nan("")); }) == "fene_k");
  CHECK(parameter_of([] { return fene_lj(1.0, 1.0, 30.0, infinity); }) == "r_max");
  CHECK(parameter_of([] { return fene_lj(1.0, 1.0, 30.0, 1.5, 0.5); }) == "cutoff");
  CHECK(parameter_of([] { return make_law("fene", [](const std::string&) { return 1.0; }); }) == "law");
  CHECK(parameter_of([] { return make_law("harmonic", [](const std::string&) { return std::nullopt; }); }) ==
        "bond_stiffness");
}

TEST_CASE("Dimensions are written in mass, length and time") {
  CHECK(to_string(Dimension{1, 0}) == "M L^2 T^-2");
  CHECK(to_string(Dimension{1, -2}) == "M T^-2");
  CHECK(to_string(Dimension{0, 1}) == "L");
  CHECK(to_string(Dimension{0, 0}) == "1");
}
