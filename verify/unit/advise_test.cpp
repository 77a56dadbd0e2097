// Advice from sweeps whose laws are known: what is predicted, and what is refused.
#include <cmath>

#include "base/error.hpp"
#include "catch.hpp"
#include "studies/advise.hpp"
#include "studies/grid.hpp"

using namespace veriflex;
using namespace veriflex::studies;

namespace {

// error = a/n^2 + b/r + floor, time = c n^4 r, at words that change both.
double error_at(double n, double r, bool coarse) { return (coarse ? 8.0 : 2.0) / (n * n) + 0.01 / r + 1e-6; }
double time_at(double n, double r, bool coarse) {
  return 1e-7 * std::pow(n, 4) * r * (coarse ? 0.5 : 1.0) + 1e-4;
}

SweptRows swept(const std::vector<double>& ns, const std::vector<double>& rs) {
  SweptRows rows{{{"word", "", "1", "", {}}, {"n", "", "1", "", {}}, {"r", "", "1", "", {}}}, {}, {}, {}};
  for (const bool coarse : {false, true}) {
    for (const double n : ns) {
      for (const double r : rs) {
        rows.axes[0].texts.push_back(coarse ? "coarse" : "fine");
        rows.axes[1].values.push_back(n);
        rows.axes[2].values.push_back(r);
        rows.error.push_back(error_at(n, r, coarse));
        rows.seconds.push_back(time_at(n, r, coarse));
        rows.memory.push_back(8.0 * n * n * n);
      }
    }
  }
  return rows;
}

const std::vector<double> resolutions{8.0, 12.0, 16.0, 24.0, 32.0, 48.0}, rounds{1.0, 2.0, 4.0, 8.0, 16.0};

double value_of(const Advice& advice, const std::string& key) {
  for (const std::string& one : advice.setting)
    if (one.starts_with(key + "=")) return std::stod(one.substr(key.size() + 1));
  return NAN;
}

}  // namespace

TEST_CASE("Advice reaches the error that is asked for, and nothing on the grid does so in less time") {
  const SweptRows rows = swept(resolutions, rounds);
  for (const double wanted : {0.05, 0.02, 0.01, 5e-3, 3e-3}) {
    INFO("error " << wanted);
    const Advice advice = advise(rows, {wanted, {}});
    const bool coarse = advice.setting[0] == "word=coarse";
    const double n = value_of(advice, "n"), r = value_of(advice, "r");
    const double error = error_at(n, r, coarse), seconds = time_at(n, r, coarse);
    CHECK(error <= wanted);
    CHECK(advice.error == Approx(error).epsilon(0.05));
    CHECK(advice.seconds == Approx(seconds).epsilon(0.05));
    for (std::size_t i = 0; i < rows.error.size(); ++i) {
      if (rows.error[i] * advice.error_factor <= wanted) CHECK(seconds <= 1.02 * rows.seconds[i]);
    }
  }
}

TEST_CASE("Points that no fit has seen are predicted") {
  // Every second resolution and round is left out of the sweep; odd ones, between which any number may stand.
  const SweptRows rows = swept({9.0, 15.0, 25.0, 43.0}, {1.0, 3.0, 9.0, 27.0});
  int seen = 0;
  for (const double n : {10.0, 18.0, 31.0}) {
    for (const double r : {2.0, 5.0, 15.0}) {
      // The advice for exactly this error is a setting of that error.
      const Advice advice = advise(rows, {error_at(n, r, false), {}});
      const bool coarse = advice.setting[0] == "word=coarse";
      const double at_n = value_of(advice, "n"), at_r = value_of(advice, "r");
      CHECK(advice.error == Approx(error_at(at_n, at_r, coarse)).epsilon(0.1));
      CHECK(advice.seconds == Approx(time_at(at_n, at_r, coarse)).epsilon(0.1));
      CHECK(advice.seconds <= 1.05 * time_at(n, r, false));
      ++seen;
    }
  }
  CHECK(seen == 9);
}

TEST_CASE("What limits the error is named, and what lies beyond the sweep is said to") {
  const SweptRows rows = swept(resolutions, rounds);
  CHECK(advise(rows, {0.03, {}}).limited_by == "n");
  // 0.01/r at r = 16 is 6.3e-4: less needs more rounds than were swept.
  const Advice beyond = advise(rows, {1.6e-3, {}});
  CHECK(value_of(beyond, "r") > 1.0);
  CHECK_THROWS_WITH(advise(rows, {1e-7, {}}), ContainsSubstring("no setting up to a factor of two"));
}

TEST_CASE("Two values show no law along their axis, nor does tau = 1 with two others") {
  SweptRows rows = swept(resolutions, {1.0, 4.0});
  for (const double wanted : {0.05, 0.02, 0.0125, 6e-3}) {
    const double r = value_of(advise(rows, {wanted, {}}), "r");
    CHECK((r == 1.0 || r == 4.0));
  }
  rows = swept(resolutions, {0.6, 0.8, 1.0});
  rows.axes[2].name = "fluid.relaxation_time";
  for (const double wanted : {0.05, 0.03, 0.02}) {
    const double tau = value_of(advise(rows, {wanted, {}}), "fluid.relaxation_time");
    CHECK((tau == 0.6 || tau == 0.8 || tau == 1.0));
  }
}

TEST_CASE("Beyond the sweep nothing is advised that would be better than all rows and take less time") {
  // The error falls with fewer of r, by luck, and so does the time.
  SweptRows rows = swept(resolutions, rounds);
  for (std::size_t i = 0; i < rows.error.size(); ++i)
    rows.error[i] = 0.01 * rows.axes[2].values[i] + 1.0 / std::pow(rows.axes[1].values[i], 2);
  for (const double wanted : {0.05, 0.0125, 0.011}) CHECK(value_of(advise(rows, {wanted, {}}), "r") >= 1.0);
}

TEST_CASE("A budget that is too small says what it buys") {
  const SweptRows rows = swept(resolutions, rounds);
  const Advice free = advise(rows, {5e-3, {}});
  CHECK(advise(rows, {5e-3, 2.0 * free.seconds}).seconds == free.seconds);
  CHECK_THROWS_WITH(advise(rows, {5e-3, 0.1 * free.seconds}), ContainsSubstring("these buy an error of"));
}

TEST_CASE("Where rows did not complete nothing is advised, and too few rows are no fit") {
  SweptRows rows = swept(resolutions, rounds);
  for (std::size_t i = 0; i < rows.error.size(); ++i)
    if (rows.axes[0].texts[i] == "coarse") rows.error[i] = NAN;
  CHECK(advise(rows, {0.05, {}}).setting[0] == "word=fine");
  // The coarsest resolution is unstable: what lies between it and the next is not known to be stable.
  SweptRows stiff = swept(resolutions, rounds);
  for (std::size_t i = 0; i < stiff.error.size(); ++i)
    if (stiff.axes[1].values[i] == 8.0) stiff.error[i] = NAN;
  CHECK(value_of(advise(stiff, {1.0, {}}), "n") == 12.0);
  CHECK(value_of(advise(swept(resolutions, rounds), {1.0, {}}), "n") == 8.0);
  CHECK_THROWS_WITH(advise(swept({8.0, 16.0}, {1.0}), {0.1, {}}),
                    ContainsSubstring("too few completed rows"));
}

TEST_CASE("A sweep that follows no such law is offered row by row") {
  SweptRows rows = swept(resolutions, rounds);
  for (std::size_t i = 0; i < rows.error.size(); ++i) rows.error[i] *= i % 3 == 0 ? 30.0 : 1.0;
  const Advice advice = advise(rows, {0.03, {}});
  CHECK(advice.is_measured);
  CHECK(advice.error_factor > 2.0);
  double least = INFINITY;
  for (std::size_t i = 0; i < rows.error.size(); ++i)
    if (rows.error[i] <= 0.03) least = std::min(least, rows.seconds[i]);
  CHECK(advice.seconds == least);
}

TEST_CASE("Errors that no power law follows are no reason to break off") {
  // As of a wave at tau = 1: the leading term vanishes along one axis, and some errors are exact zeros.
  SweptRows rows = swept(resolutions, rounds);
  for (std::size_t i = 0; i < rows.error.size(); ++i) {
    rows.error[i] = i % 4 == 0 ? 1e-300 : i % 4 == 1 ? 0.0 : 1e300;
    rows.error[i] *= i % 3 == 0 ? 1.0 : 1e-5;
  }
  const Advice advice = advise(rows, {1e-4, {}});
  CHECK(advice.is_measured);
  CHECK(advice.error <= 1e-4);
}

TEST_CASE("Where axes do not add up, each line along the longest has a law of its own") {
  // As of a viscosity whose leading error vanishes at one relaxation time: second order there is fourth.
  SweptRows rows;
  rows.axes = {{"fluid.relaxation_time", "", "1", "", {}}, {"n", "", "1", "", {}}};
  for (const double tau : {0.8, 1.0, 1.5}) {
    for (const double n : {8.0, 16.0, 32.0, 48.0, 64.0}) {
      rows.axes[0].values.push_back(tau);
      rows.axes[1].values.push_back(n);
      rows.error.push_back(tau == 1.0 ? 20.0 * std::pow(n, -4) : (tau - 0.5) / (n * n));
      rows.seconds.push_back(1e-6 * n * n * n);
      rows.memory.push_back(1e6);
    }
  }
  const Advice advice = advise(rows, {8.1e-6, {}});
  CHECK(advice.setting[0] == "fluid.relaxation_time=1");
  CHECK_FALSE(advice.is_measured);
  CHECK(value_of(advice, "n") == 40.0);  // 39.6 would do
  CHECK(advice.error <= 8.1e-6);
}

TEST_CASE("Along a relaxation time the law is one of the viscosity, of tau - 1/2") {
  SweptRows rows;
  rows.axes = {{"fluid.relaxation_time", "", "1", "", {}}, {"r", "", "1", "", {}}};
  const auto error = [](double tau, double r) { return 2.0 * std::pow(tau - 0.5, 2) + 0.01 / r; };
  const auto seconds = [](double tau, double r) { return 1e-3 * r / (tau - 0.5); };
  for (const double tau : {0.51, 0.52, 0.55, 0.6, 0.7, 0.9, 1.3}) {
    for (const double r : rounds) {
      rows.axes[0].values.push_back(tau);
      rows.axes[1].values.push_back(r);
      rows.error.push_back(error(tau, r));
      rows.seconds.push_back(seconds(tau, r));
      rows.memory.push_back(1e6);
    }
  }
  for (const double wanted : {0.1, 0.04, 0.01}) {
    INFO("error " << wanted);
    const Advice advice = advise(rows, {wanted, {}});
    const double tau = value_of(advice, "fluid.relaxation_time"), r = value_of(advice, "r");
    CHECK_FALSE(advice.is_measured);
    CHECK(error(tau, r) <= wanted);
    CHECK(advice.error == Approx(error(tau, r)).epsilon(0.05));
    CHECK(advice.seconds == Approx(seconds(tau, r)).epsilon(0.05));
  }
}

TEST_CASE("Lines too short for a law of their own are no reason to break off") {
  SweptRows rows = swept({8.0, 12.0, 16.0}, {1.0, 2.0});
  for (std::size_t i = 0; i < rows.error.size(); ++i) rows.error[i] *= i % 3 == 0 ? 100.0 : 1.0;
  const Advice advice = advise(rows, {0.05, {}});
  CHECK(advice.is_measured);
  CHECK(advice.error <= 0.05);
}

TEST_CASE("A row that was run is offered as it was measured") {
  const SweptRows rows = swept(resolutions, rounds);
  // Exactly the error of a row, which a fit that has to be safe would not dare to promise.
  const Advice advice = advise(rows, {error_at(24.0, 4.0, false), {}});
  for (std::size_t i = 0; i < rows.error.size(); ++i) {
    if (rows.error[i] <= error_at(24.0, 4.0, false)) CHECK(advice.seconds <= rows.seconds[i]);
  }
}

TEST_CASE("A time between rows is that of the rows around where the machine does not follow a law") {
  SweptRows rows;
  rows.axes = {{"n", "", "1", "", {}}};
  // From 40 on nothing fits the cache any more.
  const auto seconds = [](double n) { return 1e-6 * n * n * n * (n < 40.0 ? 1.0 : 3.0); };
  for (const double n : {16.0, 32.0, 48.0, 64.0, 96.0}) {
    rows.axes[0].values.push_back(n);
    rows.error.push_back(1.0 / (n * n));
    rows.seconds.push_back(seconds(n));
    rows.memory.push_back(1e6);
  }
  for (const double n : {24.0, 56.0, 80.0}) {
    const Advice advice = advise(rows, {1.02 / (n * n), {}});
    CHECK(value_of(advice, "n") == n);
    CHECK_FALSE(advice.is_measured);
    CHECK(advice.seconds == Approx(seconds(n)).epsilon(0.2));
  }
}

TEST_CASE("Nothing is advised between tau = 1 and its neighbours, where the fluid is stored otherwise") {
  SweptRows rows;
  rows.axes = {{"fluid.relaxation_time", "", "1", "", {}}, {"r", "", "1", "", {}}};
  for (const double tau : {0.6, 0.7, 0.8, 1.0}) {
    for (const double r : rounds) {
      rows.axes[0].values.push_back(tau);
      rows.axes[1].values.push_back(r);
      rows.error.push_back(2.0 * std::pow(tau - 0.5, 2) + 0.01 / r);
      rows.seconds.push_back(1e-3 * r / (tau - 0.5));
      rows.memory.push_back(1e6);
    }
  }
  int between = 0;
  for (double wanted = 0.03; wanted < 0.6; wanted *= 1.07) {
    const double tau = value_of(advise(rows, {wanted, {}}), "fluid.relaxation_time");
    CHECK((tau <= 0.8 || tau == 1.0));
    between += tau > 0.6 && tau < 0.8 && tau != 0.7 ? 1 : 0;
  }
  CHECK(between > 3);
}

TEST_CASE("Whole numbers between rows are as even as half of what the rows share") {
  CHECK(as_even(85.0, 64.0, 96.0) == 80.0);
  CHECK(as_even(39.0, 32.0, 48.0) == 40.0);
  CHECK(as_even(19.0, 16.0, 24.0) == 20.0);
  CHECK(as_even(19.0, 16.0, 24.0, 8.0) == 16.0);
  CHECK(as_even(11.0, 10.0, 15.0) == 11.0);
  CHECK(as_even(10.0, 8.0, 12.0) == 12.0);
  CHECK(as_even(15.0, 10.0, 18.0) == 16.0);
  CHECK(as_even(1.0, 64.0, 96.0) == 16.0);
  CHECK(as_even(130.0, 64.0, 96.0) == 128.0);
}

TEST_CASE("Keys that change with an axis are found between its values also where they are lists") {
  const Axis axis{{"nodes.0", "nodes.1", "place"},
                  {{"16", "8", "[8.0, 4.0]"}, {"32", "16", "[16.0, 4.0]"}},
                  {16.0, 32.0}};
  const auto values = values_at(axis, "24");
  REQUIRE(values);
  CHECK(values->at(1) == "12");
  CHECK(values->at(2) == "[12.0, 4.0]");
  CHECK(*values_at(axis, "32") == axis.values[1]);
  const Axis words{{"nodes.0", "storage"}, {{"16", "'float'"}, {"32", "'double'"}}, {16.0, 32.0}};
  CHECK_FALSE(values_at(words, "24"));
}

TEST_CASE("An axis that is not to be chosen keeps its value") {
  const SweptRows rows = swept(resolutions, rounds);
  for (const double wanted : {0.05, 0.01}) {
    const Advice advice = advise(only(only(rows, "word", "fine"), "r", "8"), {wanted, {}});
    CHECK(advice.setting[0] == "word=fine");
    CHECK(advice.setting[2] == "r=8");
    CHECK(error_at(value_of(advice, "n"), 8.0, false) <= wanted);
  }
  CHECK_THROWS_WITH(only(rows, "r", "7"), ContainsSubstring("no row of the sweep has r=7"));
  CHECK_THROWS_WITH(only(rows, "s", "7"), ContainsSubstring("no row of the sweep has s=7"));
}
