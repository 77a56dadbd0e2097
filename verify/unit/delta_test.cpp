// Conditions along one axis that the delta kernels are built from.            [peskin-2002; roma-1999]
#include "coupling/delta.hpp"

#include <numbers>
#include <vector>

#include "catch.hpp"

using namespace veriflex::coupling;

namespace {

/// Moments of the weights of a marker at x along one axis.
struct Moments {
  double sum = 0.0, even_less_odd = 0.0, first = 0.0, squares = 0.0;
};

template <class K>
Moments moments(double x) {
  std::array<double, 4> weights{};
  const double start = support<K>(x, weights);
  Moments m;
  for (int i = 0; i < K::width; ++i) {
    const double weight = weights[static_cast<std::size_t>(i)];
    const double node = start + i;
    m.sum += weight;
    m.even_less_odd += std::remainder(node, 2.0) == 0.0 ? weight : -weight;
    m.first += (node - x) * weight;
    m.squares += weight * weight;
  }
  return m;
}

/// Positions on nodes, half-way and in between, on both sides of zero.
std::vector<double> positions() {
  std::vector<double> all;
  for (int i = -300; i <= 300; ++i) all.push_back(i / 100.0);
  return all;
}

constexpr double round_off = 4e-15;  // of a few weights below 1 whose distances are off by 4e-16

}  // namespace

TEST_CASE("Weights along an axis add up to one") {
  for (const double x : positions()) {
    INFO("x = " << x);
    CHECK(std::abs(moments<Cosine>(x).sum - 1.0) < round_off);
    CHECK(std::abs(moments<ThreePoint>(x).sum - 1.0) < round_off);
    CHECK(std::abs(moments<FourPoint>(x).sum - 1.0) < round_off);
  }
}

TEST_CASE("The 3-point and 4-point kernels keep the first moment, the cosine is off as its formula says") {
  for (const double x : positions()) {
    INFO("x = " << x);
    CHECK(std::abs(moments<ThreePoint>(x).first) < round_off);
    CHECK(std::abs(moments<FourPoint>(x).first) < round_off);
    const double d = x - std::floor(x);
    const double angle = 0.5 * std::numbers::pi * d;
    const double expected = 0.5 - d + 0.5 * (std::sin(angle) - std::cos(angle));
    CHECK(std::abs(moments<Cosine>(x).first - expected) < round_off);
  }
}

TEST_CASE("Even and odd nodes have half of the weight each, but for the 3-point kernel") {
  for (const double x : positions()) {
    INFO("x = " << x);
    CHECK(std::abs(moments<Cosine>(x).even_less_odd) < round_off);
    CHECK(std::abs(moments<FourPoint>(x).even_less_odd) < round_off);
    const double d = x - std::round(x);  // phi(d) is the node's, the others have the rest
    CHECK(std::abs(std::abs(moments<ThreePoint>(x).even_less_odd) -
                   std::abs(2.0 * ThreePoint::phi(d) - 1.0)) < round_off);
  }
}

TEST_CASE("The squares of the weights add up to the same at every position") {
  for (const double x : positions()) {
    INFO("x = " << x);
    CHECK(std::abs(moments<Cosine>(x).squares - 3.0 / 8.0) < round_off);
    CHECK(std::abs(moments<ThreePoint>(x).squares - 1.0 / 2.0) < round_off);
    CHECK(std::abs(moments<FourPoint>(x).squares - 3.0 / 8.0) < round_off);
  }
}

TEST_CASE("Kernels are even, and end at the edge of their support without a jump") {
  for (const double d : {0.0, 0.3, 0.5, 0.9, 1.0, 1.4, 1.7}) {
    CHECK(Cosine::phi(d) == Cosine::phi(-d));
    CHECK(ThreePoint::phi(d) == ThreePoint::phi(-d));
    CHECK(FourPoint::phi(d) == FourPoint::phi(-d));
  }
  const double inside = 1e-6;  // their slopes vanish or are below 1 there
  CHECK(Cosine::phi(2.0 - inside) < inside);
  CHECK(ThreePoint::phi(1.5 - inside) < inside);
  CHECK(FourPoint::phi(2.0 - inside) < inside);
  CHECK(Cosine::phi(2.0) == 0.0);
  CHECK(ThreePoint::phi(1.5) == 0.0);
  CHECK(FourPoint::phi(2.0) == 0.0);
}
