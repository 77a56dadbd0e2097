#include "analytic/exact_solid.hpp"

#include <cmath>
#include <numbers>

#include "base/quadrature.hpp"
#include "catch.hpp"

using namespace veriflex;
using analytic::elastica_tip;

TEST_CASE("The elastica's tip has the published five digits") {
  struct Row {
    double load, deflection, shortening, slope;
  };
  // Mattiasson 1981, cantilever with an end load.
  for (const Row& row : {Row{1.0, 0.30172, 0.05643, 0.46135}, Row{2.0, 0.49346, 0.16064, 0.78175},
                         Row{5.0, 0.71379, 0.38763, 1.21537}, Row{10.0, 0.81061, 0.55500, 1.43029}}) {
    const analytic::ElasticaTip tip = elastica_tip(row.load);
    CHECK(std::abs(tip.deflection - row.deflection) < 0.6e-5);
    CHECK(std::abs(1.0 - tip.reach - row.shortening) < 0.6e-5);
    CHECK(std::abs(tip.slope - row.slope) < 0.6e-5);
  }
}

TEST_CASE("The elastica has its length: the quadrature of ds over the slope is 1") {
  // 1/2 (dphi/ds)^2 = load (sin slope - sin phi), with phi = slope sin^2(t) the end at the tip is smooth.
  for (const double load : {0.01, 0.5, 3.0, 20.0}) {
    const analytic::ElasticaTip tip = elastica_tip(load);
    const auto along = [&](auto weight) {
      return integral(
          [&](double t) {
            const double phi = tip.slope * std::sin(t) * std::sin(t);
            // sin slope - sin phi without cancellation
            const double fall = 2.0 * std::cos(0.5 * (tip.slope + phi)) *
                                std::sin(0.5 * tip.slope * std::cos(t) * std::cos(t));
            return weight(phi) * tip.slope * std::sin(2.0 * t) / std::sqrt(2.0 * load * fall);
          },
          0.0, 0.5 * std::numbers::pi);
    };
    CHECK(along([](double) { return 1.0; }) == Approx(1.0).epsilon(1e-9));
    CHECK(along([](double phi) { return std::sin(phi); }) == Approx(tip.deflection).epsilon(1e-9));
    CHECK(along([](double phi) { return std::cos(phi); }) == Approx(tip.reach).epsilon(1e-9));
  }
}

TEST_CASE("Under a small load the elastica is the cantilever of linear theory, load/3") {
  CHECK(elastica_tip(1e-4).deflection == Approx(1e-4 / 3.0).epsilon(1e-7));
  CHECK(elastica_tip(0.0).reach == 1.0);
}

TEST_CASE("The torsion constant of a square is the one of tables, 0.1406") {
  CHECK(analytic::torsion_constant_of_square() == Approx(0.1405770).epsilon(1e-6));
}

TEST_CASE("A small load bends the elastica as a linear beam, with all digits") {
  CHECK(analytic::elastica_tip(0.0).reach == 1.0);
  for (const double load : {1e-300, 1e-12, 1e-5}) {
    CHECK(analytic::elastica_tip(load).deflection == Approx(load / 3.0).epsilon(1e-10));
    CHECK(analytic::elastica_tip(load).slope == Approx(load / 2.0).epsilon(1e-10));
  }
  // Where series and integrals meet.
  const analytic::ElasticaTip below = analytic::elastica_tip(std::nextafter(1e-3, 0.0));
  const analytic::ElasticaTip above = analytic::elastica_tip(1e-3);
  CHECK(below.deflection == Approx(above.deflection).epsilon(1e-9));
  CHECK(below.slope == Approx(above.slope).epsilon(1e-9));
  CHECK(below.reach == Approx(above.reach).epsilon(1e-12));
}
