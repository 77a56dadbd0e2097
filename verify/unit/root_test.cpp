#include "base/root.hpp"

#include <cmath>

#include "base/error.hpp"
#include "catch.hpp"

using namespace veriflex;

TEST_CASE("A bracketed root is found to the last bit") {
  const double root = bracketed_root([](double x) { return x * x - 2.0; }, 0.0, 2.0);
  CHECK(std::abs(root - std::sqrt(2.0)) <= 2.3e-16);
  CHECK(bracketed_root([](double x) { return x; }, -1.0, 3.0) == Approx(0.0).margin(1e-300));
}

TEST_CASE("A root at an end of the bracket counts") {
  CHECK(bracketed_root([](double x) { return x - 1.0; }, 1.0, 2.0) == 1.0);
  CHECK(bracketed_root([](double x) { return x - 2.0; }, 1.0, 2.0) == 2.0);
}

TEST_CASE("A first step that bisects is not taken for a search that stalls") {
  // Values of one size at both ends: Brent's first step is the middle, where the search stood before, and
  // moves one end of the bracket only.
  CHECK(bracketed_root([](double x) { return x * x - 2.5; }, 1.0, 2.0) ==
        Approx(std::sqrt(2.5)).epsilon(1e-15));
}

TEST_CASE("A bracket without a change of sign is refused") {
  CHECK_THROWS_AS(bracketed_root([](double x) { return x * x + 1.0; }, -1.0, 1.0), NumericalFailure);
}

TEST_CASE("A minimum is found to the square root of the precision") {
  CHECK(bracketed_minimum([](double x) { return std::cosh(x - 0.3); }, -1.0, 0.0, 1.0) ==
        Approx(0.3).margin(1e-7));
}

TEST_CASE("A bracket that holds no minimum is refused, and a level one is none that failed") {
  CHECK_THROWS_AS(bracketed_minimum([](double x) { return x; }, -1.0, 0.0, 1.0), NumericalFailure);
  CHECK_THROWS_AS(bracketed_minimum([](double) { return NAN; }, -1.0, 0.0, 1.0), NumericalFailure);
}

TEST_CASE("The central derivative estimates its own error") {
  const Derivative d = central_derivative([](double x) { return std::sin(x); }, 1.0, 1e-3);
  CHECK(std::abs(d.value - std::cos(1.0)) <= d.error);
  CHECK(d.error < 1e-9);
}
