// What a scene does not name costs nothing: no memory, no call.

#include <algorithm>

#include "allocations.hpp"
#include "base/work.hpp"
#include "catch.hpp"
#include "scene/plan.hpp"
#include "solid/leapfrog.hpp"

using namespace veriflex;
using namespace veriflex::solid;

namespace {

const bond::AnyLaw harmonic = bond::Harmonic{0.26, 1.0};
const Block block{{3, 4, 5}, 1.0};  // 60 nodes, 133 bonds: no two kinds of array have the same size
constexpr std::size_t nodes = 60;
constexpr std::size_t bonds = 133;
constexpr std::size_t vector_size = 3 * sizeof(double);
// What Eigen asks for beyond an array where it aligns by hand, as it does under AddressSanitizer.
constexpr std::size_t padding = EIGEN_MALLOC_ALREADY_ALIGNED ? 0 : EIGEN_DEFAULT_ALIGN_BYTES;

Network lattice(bool with_angles) {
  Network network = cubic_lattice(block);
  if (with_angles) add_angles(network);
  return network;
}

Positions zero() { return Positions::Zero(nodes, 3); }

std::ptrdiff_t arrays_per_node(const std::vector<std::size_t>& sizes) {
  return std::count(sizes.begin(), sizes.end(), nodes * vector_size + padding);
}
std::ptrdiff_t arrays_per_bond(const std::vector<std::size_t>& sizes) {
  return std::count(sizes.begin(), sizes.end(), bonds * vector_size + padding);
}

// A law that counts what is asked of it.
struct Counting {
  static constexpr std::string_view name = "counting";
  static constexpr std::array<bond::Parameter<Counting>, 0> parameters() { return {}; }
  double energy(double) const { return static_cast<void>(++energies), 0.0; }
  double tension(double) const { return static_cast<void>(++tensions), 0.0; }
  double stiffness(double) const { return static_cast<void>(++stiffnesses), 0.0; }
  Interval domain() const { return {0.0, bond::infinity}; }
  double typical_length() const { return 1.0; }
  void check() const {}
  static inline int energies = 0, tensions = 0, stiffnesses = 0;
};
static_assert(bond::BondLaw<Counting>);

bool left_out(const scene::Plan& plan, const std::string& module) {
  return std::any_of(plan.left_out.begin(), plan.left_out.end(),
                     [&](const scene::LeftOut& l) { return l.module == module; });
}

}  // namespace

TEST_CASE("A force evaluation asks each bond once, for its tension alone") {
  const Network network = lattice(false);
  REQUIRE(network.bonds.size() == bonds);
  Workspace work;
  Positions force;
  REQUIRE(deform(Counting{}, network, zero(), work));
  REQUIRE(gradient(Counting{}, NoAngle{}, network, work, force));
  CHECK(Counting::tensions == static_cast<int>(bonds));
  CHECK(Counting::energies == 0);
  CHECK(Counting::stiffnesses == 0);
}

TEST_CASE("Without an angle stiffness no angle list is built and no angle is looked at") {
  CHECK(scene::build({block, 0.0}).angles.capacity() == 0);
  CHECK_FALSE(scene::build({block, 0.025}).angles.empty());

  // Even where a list is there: flat right angles, which have no force, are not noticed.
  Network network = lattice(true);
  for (Angle& angle : network.angles) angle.straight = false;
  const auto evaluate = [&](double angle_stiffness, Workspace& work) {
    return visit({harmonic, angle_stiffness}, [&](const auto& law, const auto& angle) {
      Positions force;
      return deform(law, network, zero(), work) && gradient(law, angle, network, work, force);
    });
  };
  Workspace without;
  CHECK(evaluate(0.0, without));
  CHECK(without.stars.groups.capacity() == 0);
  Workspace with;
  CHECK_FALSE(evaluate(0.025, with));
}

TEST_CASE("A static evaluation has one array per node, the force, and a second one allocates nothing") {
  for (const bool with_angles : {false, true}) {
    const Network network = lattice(with_angles);
    const Positions u = zero();
    Workspace work;
    Positions force;
    const auto evaluate = [&] {
      visit({harmonic, with_angles ? 0.025 : 0.0}, [&](const auto& law, const auto& angle) {
        return deform(law, network, u, work) && gradient(law, angle, network, work, force);
      });
    };
    work::mine();  // of this thread, once
    const std::vector<std::size_t> first = allocations_of(evaluate);
    CHECK(arrays_per_node(first) == 1);
    CHECK(arrays_per_bond(first) == 2);  // vectors and gradients by them
    if (!with_angles) CHECK(first.size() == 3);
    CHECK(allocations_of(evaluate).empty());
  }
}

TEST_CASE("A free body carries displacement, velocity and force, a held or loaded one what that needs") {
  const Network network = lattice(true);
  const Positions still = zero();
  const auto arrays = [&](const Conditions& conditions) {
    std::optional<Leapfrog> motion;
    const std::vector<std::size_t> sizes = allocations_of([&] {
      motion.emplace(Material{harmonic, 0.025}, network, conditions, 0.5, Substeps{}, still, still);
    });
    return std::pair(arrays_per_node(sizes), std::count(sizes.begin(), sizes.end(), 3 * nodes + padding));
  };
  const auto [free, free_holds] = arrays({});
  CHECK(free == 4);  // and the next displacement, until it is known to be good
  CHECK(free_holds == 0);
  Conditions held;
  held.fixed = FixedDofs::Constant(nodes, 3, false);
  CHECK(arrays(held) == std::pair(free, std::ptrdiff_t{1}));
  Conditions loaded;
  loaded.load = zero();
  CHECK(arrays(loaded) == std::pair(free + 1, std::ptrdiff_t{0}));
}

TEST_CASE("A step allocates nothing once the first is done, whatever its sub-steps") {
  const Network network = lattice(true);
  for (const int substeps : {1, 4}) {
    Positions v = zero();
    v(0, 2) = 0.01;
    Leapfrog motion({harmonic, 0.025}, network, {}, 0.5, {substeps, 0.0}, zero(), v);
    motion.step();
    CHECK(allocations_of([&] {
            for (int step = 0; step < 20; ++step) motion.step();
          }).empty());
  }
}

TEST_CASE("The plan says what is left out") {
  const scene::SolidSpec bare{block, 0.0};
  const scene::SolidSpec stiff{block, 0.025};
  CHECK(left_out(scene::plan({.law = harmonic, .solid = bare, .by = {parts::Kind::Statics}}), "angles"));
  CHECK_FALSE(
      left_out(scene::plan({.law = harmonic, .solid = stiff, .by = {parts::Kind::Statics}}), "angles"));
  CHECK(left_out(scene::plan({.law = harmonic, .solid = stiff, .by = {parts::Kind::Statics}}), "velocities"));
  const scene::Plan moving = scene::plan({.law = harmonic, .solid = stiff, .by = {parts::Kind::LeapFrog}});
  CHECK_FALSE(left_out(moving, "velocities"));
  CHECK(left_out(moving, "constraints"));
  CHECK_FALSE(left_out(
      scene::plan({.law = harmonic, .solid = stiff, .by = {parts::Kind::LeapFrog, parts::Kind::Constraints}}),
      "constraints"));
}
