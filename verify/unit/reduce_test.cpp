// Reductions of measured numbers: none loses what is no number.
#include "base/reduce.hpp"

#include "catch.hpp"

using namespace veriflex;

TEST_CASE("The larger and the smaller of two numbers are no number where one of them is none") {
  CHECK(worse(1.0, 2.0) == 2.0);
  CHECK(worse(2.0, 1.0) == 2.0);
  CHECK(lesser(1.0, 2.0) == 1.0);
  CHECK(lesser(2.0, 1.0) == 1.0);
  for (double (*of_two)(double, double) : {worse, lesser}) {
    CHECK(std::isnan(of_two(NAN, 1.0)));
    CHECK(std::isnan(of_two(1.0, NAN)));
    CHECK(std::isnan(of_two(NAN, NAN)));
    CHECK(std::isnan(of_two(INFINITY, NAN)));
  }
}

TEST_CASE("Extremes of an array are no number where one of its numbers is none, wherever it stands") {
  Eigen::VectorXd x(17);  // longer than a register
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = i % 2 == 0 ? 0.5 * static_cast<double>(i) : -3.0;
  CHECK(largest(x) == 8.0);
  CHECK(smallest(x) == -3.0);
  CHECK(largest_magnitude(x) == 8.0);
  CHECK(largest_magnitude(-x) == 8.0);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    Eigen::VectorXd broken = x;
    broken[i] = NAN;
    CAPTURE(i);
    CHECK(std::isnan(largest(broken)));
    CHECK(std::isnan(smallest(broken)));
    CHECK(std::isnan(largest_magnitude(broken)));
  }
  CHECK(largest_magnitude(Eigen::VectorXd()) == 0.0);
}

TEST_CASE("Nothing over nothing is no error, and something over nothing is no end of one") {
  CHECK(relative_to(0.0, 0.0) == 0.0);
  CHECK(relative_to(1e-300, 0.0) == INFINITY);
  CHECK(relative_to(-1.0, -4.0) == 0.25);
  CHECK(std::isnan(relative_to(NAN, 1.0)));
}
