#include "solid/relax.hpp"
#include "base/error.hpp"
#include "catch.hpp"

using namespace veriflex;
using namespace veriflex::solid;

namespace {

struct Cantilever {
  Material material{bond::Harmonic{0.26, 1.0}, 0.025};
  Network network;
  FixedDofs held;
  Positions load, rest;
};

// A strip two nodes thick, clamped at its first section, under a load across its last.
Cantilever cantilever() {
  Cantilever c;
  c.network = cubic_lattice({{2, 1, 8}, 1.0});
  add_angles(c.network);
  c.rest = Positions::Zero(c.network.node_count(), 3);
  c.held = FixedDofs::Constant(c.network.node_count(), 3, false);
  c.held.topRows(2).setConstant(true);
  c.held.col(1).setConstant(true);
  c.load = c.rest;
  c.load.col(0).tail(2).setConstant(1e-3);
  return c;
}

Equilibrium found_by(const Statics& how, const Cantilever& c) {
  return relax(how, c.material, c.network, c.rest, c.held, c.load);
}

}  // namespace

TEST_CASE("every method finds the same equilibrium") {
  const Cantilever c = cantilever();
  const Equilibrium newton = found_by({}, c);
  CHECK(newton.u.col(0).tail(2).mean() > 1.0);  // far beyond small deflections
  for (const auto& method : relaxations) {
    INFO(method.name);
    const Equilibrium e = found_by({method.value, 1e-9}, c);
    CHECK(e.residual <= 1e-9);
    CHECK((e.u - newton.u).cwiseAbs().maxCoeff() < 1e-6);
    // What the holds exert balances the load.
    CHECK(e.reaction.col(0).sum() == Approx(-2e-3).margin(1e-9));
  }
}

TEST_CASE("a search has the more steps the larger the body is") {
  Cantilever c = cantilever();
  c.network = cubic_lattice({{3, 3, 9}, 1.0});  // 216 free coordinates
  add_angles(c.network);
  c.load = c.rest = Positions::Zero(c.network.node_count(), 3);
  c.held = FixedDofs::Constant(c.network.node_count(), 3, false);
  c.held.topRows(9).setConstant(true);
  c.load.col(0).tail(9).setConstant(1e-5);
  const Equilibrium newton = found_by({}, c);
  for (const auto& method : relaxations) {
    INFO(method.name);
    CHECK((found_by({method.value, 1e-7}, c).u - newton.u).cwiseAbs().maxCoeff() <
          1e-3 * newton.u.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("a larger residual ends a search earlier and farther away") {
  const Cantilever c = cantilever();
  const Equilibrium newton = found_by({}, c);
  for (const auto& method : relaxations) {
    INFO(method.name);
    const Equilibrium rough = found_by({method.value, 1e-2}, c);
    const Equilibrium fine = found_by({method.value, 1e-8}, c);
    CHECK(rough.iterations < fine.iterations);
    CHECK((rough.u - newton.u).norm() > (fine.u - newton.u).norm());
  }
}

TEST_CASE("a body that nothing holds against its load has no equilibrium by any method") {
  Cantilever c = cantilever();
  c.held.col(0).setConstant(false);
  c.held.col(2).setConstant(false);
  for (const auto& method : relaxations) {
    INFO(method.name);
    CHECK_THROWS_AS(found_by({method.value, 1e-9}, c), NumericalFailure);
  }
}
