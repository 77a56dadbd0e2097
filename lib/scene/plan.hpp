/// What a run of a scene will build and leave out. Every entry names the parts that it speaks of, so that the
/// run can be held against it: what was built is told by the parts themselves (base/parts).
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/work.hpp"
#include "bond/laws.hpp"
#include "fluid/fluid.hpp"
#include "scene/scene.hpp"
#include "solid/network.hpp"

namespace veriflex::scene {

struct SolidSpec {
  std::variant<solid::Block, solid::Rod> shape;
  double angle_stiffness;  // k_a; 0 builds no angles  [M L^2 T^-2]
};

/// What a study of one body makes use of. A module that is not named is absent: not built, no memory.
struct Outline {
  std::optional<bond::AnyLaw> law{};
  std::optional<SolidSpec> solid{};
  std::string method{};  // how the solid is solved, in words
  /// What solves it (LeapFrog, Midpoint, Statics; none: forces alone), and how it is held and loaded
  /// (Constraints, Drive, Loads).
  std::vector<parts::Kind> by{};
  std::optional<fluid::Spec> fluid{};
  bool initial_flow = false;               // the fluid is started from one
  bool uniform_force = false;              // that changes with time acts on it
  std::optional<CouplingSpec> coupling{};  // of a body and the fluid
  std::string exchange{};  // that coupling in words, where the study varies it or lays its own markers
};

struct Built {
  std::string module;
  std::string what;
  double memory_bytes;               // before it is built: that of its arrays, of a solution an estimate
  std::vector<parts::Kind> parts{};  // that a run must build
};

struct LeftOut {
  std::string module;
  std::string why;
  std::optional<parts::Kind> part{};  // that no run may build
  /// The setting with which it is there all the same and must change nothing, as --set takes it; empty: there
  /// is none.
  std::string put_in{};
};

struct Plan {
  std::vector<Built> built;
  std::vector<LeftOut> left_out;
};

/// Puts an entry among those that are built, and takes away those of its parts that were left out.
void put_in(Plan& plan, Built built);

/// What a run has built against its plan, in words: a part that was planned and is not there, one that was to
/// be left out and is. Empty when they agree.
std::vector<std::string> broken_promises(const Plan& plan, const parts::AllMade& made);

/// Throws BadParameter ("solid.nodes", "fluid.nodes") when a module would not fit into the memory that is
/// available now.
Plan plan(const Outline& scene);

/// The same of a scene whose bodies are built. Throws BadParameter ("fluid.nodes").
Plan plan_scene(const Scene& scene);

/// What steps of a scene will do, from which their time can be estimated.
struct ExpectedWork {
  std::optional<fluid::Spec> fluid;
  work::Counts counts;            // bytes_moved are not among them
  double checked_nodes = 0.0;     // of bodies whose coupling is looked at before the first step, and
  double checked_substeps = 0.0;  // nodes times sub-steps of those whose force follows the sub-steps
};

/// Nothing where the number of sub-steps is only known at run time.
std::optional<ExpectedWork> expected_work(const Scene& scene, std::int64_t steps);

solid::Network build(const SolidSpec& spec);

}  // namespace veriflex::scene
