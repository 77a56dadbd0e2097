#include "engine/convergence.hpp"

#include <cmath>

#include "catch.hpp"

using namespace veriflex::engine;

namespace {

const std::vector<double> halved{0.4, 0.2, 0.1, 0.05};
const std::vector<double> uneven{0.5, 0.3, 0.2, 0.05};

std::vector<double> power(const std::vector<double>& h, double limit, double factor, double order) {
  std::vector<double> value;
  for (const double spacing : h) value.push_back(limit + factor * std::pow(spacing, order));
  return value;
}

}  // namespace

TEST_CASE("A pure power gives its order, its limit and 1.25 of its error, on any grids") {
  for (const std::vector<double>& h : {halved, uneven}) {
    for (const double order : {0.5, 1.0, 2.0, 4.0}) {
      for (const double factor : {3.0, -0.7}) {
        CAPTURE(order, factor, h[1]);
        const std::vector<double> value = power(h, 7.0, factor, order);
        const Convergence found = converge(h, value);
        REQUIRE(found.order.size() == 2);
        for (const double p : found.order) CHECK(p == Approx(order).epsilon(1e-7));
        CHECK(found.richardson == Approx(7.0).epsilon(1e-12));
        CHECK(found.gci == Approx(1.25 * std::abs(value.back() - 7.0)).epsilon(1e-7));
        CHECK(gci(h, value, order) == Approx(3.0 * std::abs(value.back() - 7.0)).epsilon(1e-7));
        std::vector<double> error;
        for (const double v : value) error.push_back(std::abs(v - 7.0));
        // The smallest errors have lost ten digits to the limit.
        for (const double p : orders(h, error)) CHECK(p == Approx(order).epsilon(1e-9));
      }
    }
  }
}

TEST_CASE("Two terms: the order comes near with each grid, and the limit lies within the convergence index") {
  std::vector<double> value;
  for (const double h : halved) value.push_back(1.0 + h * h + 0.5 * h * h * h);
  const Convergence found = converge(halved, value);
  CHECK(found.order[1] == Approx(2.0).margin(0.1));
  CHECK(std::abs(found.order[1] - 2.0) < std::abs(found.order[0] - 2.0));
  CHECK(std::abs(found.richardson - 1.0) < std::abs(value.back() - 1.0));
  CHECK(std::abs(value.back() - 1.0) < found.gci);
}

TEST_CASE("Where grids do not converge monotonically there is no order, and nothing that follows from one") {
  for (const std::vector<double>& value :
       {std::vector<double>{1.0, 2.0, 1.5}, {1.0, 2.0, 3.5}, {1.0, 1.0, 1.0}, {2.0, 1.0, 1.0}}) {
    const Convergence found = converge({0.4, 0.2, 0.1}, value);
    CHECK(std::isnan(found.order.back()));
    CHECK(std::isnan(found.richardson));
    CHECK(std::isnan(found.gci));
  }
  CHECK(std::isnan(orders({0.2, 0.1}, {1.0, 0.0}).back()));
}

TEST_CASE("A power law is recovered from its points") {
  const PowerLaw law = power_law(uneven, power(uneven, 0.0, 3.0, 2.5));
  CHECK(law.exponent == Approx(2.5).epsilon(1e-13));
  CHECK(law.factor == Approx(3.0).epsilon(1e-13));
}
