#include "scene/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "base/memory.hpp"
#include "base/mutant.hpp"
#include "coupling/transfer.hpp"
#include "scene/markers.hpp"

namespace veriflex::scene {

namespace {

std::string describe(const bond::AnyLaw& law) {
  std::string text = bond::name_of(law) + ":";
  for (const bond::NamedValue& p : bond::parameters_of(law)) text += fmt::format(" {} = {}", p.name, p.value);
  return text;
}

using parts::Kind;

bool has(const std::vector<Kind>& parts, Kind kind) {
  return std::find(parts.begin(), parts.end(), kind) != parts.end();
}

struct Size {
  double nodes, bonds, section;  // section: nodes in one, which is how far the Cholesky factor fills in
  std::string shape;
};

Size size_of(const solid::Block& block) {
  const auto [n, m, l] = block.nodes;
  return {static_cast<double>(block.node_count()), static_cast<double>(block.bond_count()),
          static_cast<double>(n) * static_cast<double>(m), fmt::format("{} x {} x {}", n, m, l)};
}

Size size_of(const solid::Rod& rod) {
  const double section = std::numbers::pi * (rod.radius + 0.5) * (rod.radius + 0.5);
  const double nodes = section * static_cast<double>(rod.sections);
  return {nodes, 3.0 * nodes, section,
          fmt::format("rod of radius {}, {} sections,", rod.radius, rod.sections)};
}

/// While a Hessian is assembled its triplets stand beside it, all of them and those of free coordinates, and
/// it has a place for each until equal ones are added up.
double assembly_bytes(double bonds, double angles) {
  return (2.0 * 16.0 + 12.0) * (36.0 * bonds + 144.0 * angles);
}

void plan_solid(const SolidSpec& spec, const Outline& scene, Plan& plan) {
  const Size size = std::visit([](const auto& shape) { return size_of(shape); }, spec.shape);
  const bool angles = spec.angle_stiffness != 0.0;
  const double angle_count = angles ? 15.0 * size.nodes : 0.0;
  const double network = size.nodes * 24.0 + size.bonds * 32.0 + angle_count * sizeof(solid::Angle);
  // Displacement, gradient, load, reaction; bond vectors and their gradients; for a static solution the
  // Hessian's triplets and entries and its factor, for a moving one the velocities.
  const double state = size.nodes * 4.0 * 24.0 + size.bonds * 48.0;
  const double factor = size.nodes * 9.0 * std::min(size.section, 4096.0) * 12.0;
  const bool moves =
      has(scene.by, Kind::LeapFrog) || has(scene.by, Kind::Midpoint) || has(scene.by, Kind::RungeKutta);
  const bool solves = !moves || has(scene.by, Kind::Statics);
  const double solver =
      (moves ? size.nodes * 24.0 : 0.0) + (solves ? assembly_bytes(size.bonds, angle_count) + factor : 0.0);
  const double available = available_memory_bytes();
  if (network + state + solver > available || size.nodes * 3.0 > 2147483647.0) {
    throw BadParameter(
        "solid.nodes", fmt::format("{} nodes are too many", size.shape),
        fmt::format("the solution would take about {:.3g} GB, {:.3g} GB are available; indices end at "
                    "715827882 nodes",
                    (network + state + solver) * 1e-9, available * 1e-9),
        "Use fewer nodes");
  }
  plan.built.push_back(
      {"solid",
       fmt::format("{} nodes, nearest-neighbour bonds ({})", size.shape, bond::name_of(*scene.law)),
       network + state,
       {Kind::Bonds}});
  if (angles) {
    plan.built.push_back(
        {"angles",
         fmt::format("right and straight, each pair of bonds of a node once, k_a = {}", spec.angle_stiffness),
         0.0,
         {Kind::Angles}});
  } else {
    plan.left_out.push_back({"angles",
                             "k_a = 0: no angle list, no angle loop; bonds alone have no shear stiffness",
                             Kind::Angles});
  }
  if (!scene.by.empty()) plan.built.push_back({moves ? "motion" : "statics", scene.method, solver, scene.by});
  if (!moves) plan.left_out.push_back({"velocities", "a static study needs none", Kind::LeapFrog});
  if (moves && !has(scene.by, Kind::Constraints) && !has(scene.by, Kind::Drive)) {
    plan.left_out.push_back(
        {"constraints", "the body is free: no pass over held or driven coordinates", Kind::Constraints});
  }
}

std::string describe_walls(const fluid::Spec& spec) {
  std::string closed;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (spec.walls[axis])
      closed += closed.empty() ? fmt::format("{}", "xyz"[axis]) : fmt::format(", {}", "xyz"[axis]);
  }
  return closed;
}

std::string describe_openings(const fluid::Spec& spec) {
  std::string open;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t end = 0; spec.walls[axis] && end < 2; ++end) {
      const auto& opening = spec.walls[axis]->openings[end];
      if (std::holds_alternative<std::monostate>(opening)) continue;
      open += fmt::format("; {} at the {} end of {}",
                          std::holds_alternative<fluid::Inflow>(opening) ? "inflow of given velocity"
                                                                         : "outflow of given density",
                          end == 0 ? "low" : "high", "xyz"[axis]);
    }
  }
  return open;
}

void plan_fluid(const fluid::Spec& spec, bool initial_flow, bool uniform_force, Plan& plan) {
  fluid::require_memory(spec);
  const auto [nx, ny, nz] = spec.grid.size;
  const bool moments = fluid::representation_of(spec) == fluid::Representation::Moments;
  plan.built.push_back({"fluid",
                        fmt::format("{} x {} x {} nodes, D3Q15 BGK {}, tau = {}, {} {}", nx, ny, nz,
                                    moments ? "in two copies" : "in place", spec.relaxation_time,
                                    row_of(fluid::storages, spec.storage).name,
                                    moments ? "density and momentum" : "populations"),
                        fluid::memory_bytes(spec),
                        {moments ? Kind::Moments : Kind::Populations}});
  if (moments) {
    plan.left_out.push_back({"populations",
                             "at tau = 1 a collision keeps density and momentum alone; where an observation "
                             "asks for populations they are made from the step before",
                             Kind::Populations, "fluid.representation=populations"});
  }
  const std::string closed = describe_walls(spec);
  if (closed.empty()) {
    plan.left_out.push_back({"walls", "the box is periodic: no list of cut links", Kind::Walls});
  } else {
    plan.built.push_back(
        {"walls",
         fmt::format("half-way bounce-back at both ends of {}{}", closed, describe_openings(spec)),
         0.0,
         {Kind::Walls}});
  }
  if (spec.has_obstacle()) {
    plan.built.push_back({"obstacle",
                          fmt::format("{} nodes, half-way bounce-back around them", spec.obstacle.size()),
                          static_cast<double>(spec.grid.count()) / 8.0,
                          {Kind::Obstacle}});
  } else {
    plan.left_out.push_back({"obstacle", "the case names none", Kind::Obstacle, "fluid.keep=[\"obstacle\"]"});
  }
  if (spec.is_forced()) {
    plan.built.push_back({"body force",
                          spec.scheme == fluid::Scheme::FirstOrder ? "first order" : "second order (Guo)",
                          0.0,
                          {Kind::BodyForce}});
  } else {
    plan.left_out.push_back({"body force", "zero: the sweep is compiled without it", Kind::BodyForce,
                             "fluid.keep=[\"body force\"]"});
  }
  if (initial_flow && moments) {
    plan.built.push_back({"initial flow",
                          "its populations, until the first step",
                          fluid::start_bytes(spec),
                          {Kind::InitialFlow}});
  }
  if (uniform_force) {
    plan.built.push_back({"uniform force",
                          "of first order, on every node at each step",
                          32.0 * static_cast<double>(spec.grid.count()),
                          {Kind::UniformForce}});
  }
  plan.left_out.push_back(
      {"fields", "density, velocity and stress exist only where an observation asks for them"});
}

std::string words_of(const CouplingSpec& coupling, const std::string& exchange) {
  const std::string nodes = coupling.coupled == Coupled::Boundary ? "boundary nodes"
                            : coupling.coupled == Coupled::Ring   ? "the surface's nodes without end caps"
                            : coupling.coupled == Coupled::All    ? "all nodes"
                                                                  : "listed nodes";
  const std::string delta =
      coupling::visit(coupling.delta, [](auto kernel) { return std::string(kernel.name); });
  if (!exchange.empty()) return fmt::format("{}, {} delta", exchange, delta);
  return fmt::format("{}, {} delta, force {}", nodes, delta,
                     coupling.subcycled ? "following the sub-steps" : "frozen over the sub-steps");
}

}  // namespace

Plan plan(const Outline& scene) {
  Plan plan;
  if (scene.law) plan.built.push_back({"bond law", describe(*scene.law), 0.0});
  if (scene.solid) {
    plan_solid(*scene.solid, scene, plan);
  } else {
    plan.left_out.push_back({"solid", "the case names none", Kind::Bonds});
  }
  if (scene.fluid) {
    plan_fluid(*scene.fluid, scene.initial_flow, scene.uniform_force, plan);
  } else {
    plan.left_out.push_back({"fluid", "the case names none", Kind::Populations});
  }
  if (scene.coupling) {
    plan.built.push_back({"coupling", words_of(*scene.coupling, scene.exchange), 0.0, {Kind::Coupling}});
  } else {
    plan.left_out.push_back({"coupling", "no body meets a fluid", Kind::Coupling});
  }
  return plan;
}

namespace {

double leap_frog_bytes(const Body& body) {
  const auto nodes = static_cast<double>(body.network.node_count());
  const auto bonds = static_cast<double>(body.network.bonds.size());
  const double stars = body.network.angles.empty() ? 0.0 : 8.0 * bonds;  // each bond is an arm at both ends
  return nodes * 4.0 * 24.0 + bonds * 2.0 * 24.0 + stars;
}

/// Of a body without its length: a factor fills in about the width of a cross-section, of which a body of n
/// nodes has n^(2/3) at most.
double implicit_midpoint_bytes(const Body& body) {
  const auto nodes = static_cast<double>(body.network.node_count());
  const auto bonds = static_cast<double>(body.network.bonds.size());
  const auto angles = body.material.has_angles() ? static_cast<double>(body.network.angles.size()) : 0.0;
  return leap_frog_bytes(body) + assembly_bytes(bonds, angles) +
         nodes * 9.0 * std::pow(nodes, 2.0 / 3.0) * 12.0;
}

struct Exchange {
  double bytes;  // of supports, weights and what is exchanged
  double nodes;  // of the fluid under the supports
};

/// With the markers where they start.
Exchange exchange_of(const Body& body, const fluid::Spec& fluid) {
  const Positions markers = markers_at_rest(body);
  coupling::Transfer transfer(fluid.grid, closed(fluid), body.coupling->delta, fluid.obstacle);
  try {
    transfer.locate(markers);
  } catch (const NumericalFailure&) {
    return {0.0, 0.0};  // a body without room is refused by whoever knows its place in the case
  }
  const double per_node = body.motion ? 3.0 : 2.0, per_marker = 4.0;
  const auto nodes = static_cast<double>(transfer.nodes().size());
  return {transfer.bytes() +
              24.0 * (per_node * nodes + (planted(Mutant::plan_of_fewer_bytes) ? 0.0 : per_marker) *
                                             static_cast<double>(markers.rows())),
          nodes};
}

void plan_motion(const Body& body, std::size_t index, const std::string& of, Plan& plan) {
  const solid::Conditions& conditions = body.conditions;
  const auto nodes = static_cast<double>(body.network.node_count());
  if (body.scheme == solid::Scheme::ImplicitMidpoint) {
    plan.built.push_back({"motion" + of,
                          "implicit midpoint rule, Newton's method with a factor that is kept",
                          implicit_midpoint_bytes(body),
                          {Kind::Midpoint, Kind::Statics}});
  } else {
    plan.built.push_back(
        {"motion" + of,
         fmt::format("leap-frog, {}", body.substeps.safety > 0.0
                                          ? std::string("sub-steps as the stiffest bond needs")
                                          : fmt::format("{} sub-steps", body.substeps.count)),
         leap_frog_bytes(body),
         {Kind::LeapFrog}});
  }
  const auto keep = [&](const char* part) { return fmt::format("body.{}.keep=[\"{}\"]", index, part); };
  if (body.material.has_angles()) {
    plan.built.push_back(
        {"angles" + of,
         fmt::format("{} of stiffness {}", body.network.angles.size(), body.material.angle_stiffness),
         solid::angle_bytes(body.network),
         {Kind::Angles}});
  } else {
    plan.left_out.push_back({"angles" + of, "k_a = 0: no list, no loop", Kind::Angles, keep("angles")});
  }
  if (conditions.fixed.size() > 0) {
    plan.built.push_back(
        {"constraints" + of, "a pass over fixed coordinates", 3.0 * nodes, {Kind::Constraints}});
  } else {
    plan.left_out.push_back({"constraints" + of, "nothing is held: no pass over its coordinates",
                             Kind::Constraints, keep("constraints")});
  }
  if (conditions.drive) {
    plan.built.push_back(
        {"drive" + of,
         fmt::format("{} nodes along {}", conditions.drive->nodes.size(), "xyz"[conditions.drive->axis]),
         4.0 * static_cast<double>(conditions.drive->nodes.size()),
         {Kind::Drive}});
  } else {
    plan.left_out.push_back({"drive" + of, "nothing is driven", Kind::Drive});
  }
  if (conditions.load.size() > 0) {
    plan.built.push_back({"loads" + of, "a pass over dead loads", 24.0 * nodes, {Kind::Loads}});
  } else {
    plan.left_out.push_back(
        {"loads" + of, "nothing is loaded: no pass over its nodes", Kind::Loads, keep("loads")});
  }
}

/// Returns how many of the fluid's nodes it pushes.
double plan_body(const Scene& scene, std::size_t index, Plan& plan) {
  const Body& body = scene.bodies[index];
  const std::string of = scene.bodies.size() == 1 ? "" : " of " + body.name;
  plan.built.push_back(
      {"body " + body.name,
       fmt::format("{} nodes, {} bonds; {}", body.network.node_count(), body.network.bonds.size(),
                   body.motion ? std::string("rigid, its motion is given") : describe(body.material.law)),
       solid::bond_bytes(body.network)});
  if (!body.motion) {
    plan.built.back().parts.push_back(Kind::Bonds);
    plan_motion(body, index, of, plan);
  }
  if (!scene.fluid || !body.coupling) {
    plan.left_out.push_back({"coupling" + of, "it meets no fluid", Kind::Coupling});
    return 0.0;
  }
  const Exchange exchange = exchange_of(body, *scene.fluid);
  plan.built.push_back({"coupling" + of, words_of(*body.coupling, ""), exchange.bytes, {Kind::Coupling}});
  return exchange.nodes;
}

}  // namespace

Plan plan_scene(const Scene& scene) {
  Plan plan;
  if (scene.fluid) {
    plan_fluid(*scene.fluid, static_cast<bool>(scene.initial_flow), static_cast<bool>(scene.uniform_force),
               plan);
  } else {
    plan.left_out.push_back({"fluid", "the case names none", Kind::Populations});
  }
  double pushed = scene.uniform_force ? static_cast<double>(scene.fluid->grid.count()) : 0.0;  // nodes
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) pushed += plan_body(scene, i, plan);
  const auto coupled = std::count_if(scene.bodies.begin(), scene.bodies.end(),
                                     [](const Body& body) { return body.coupling.has_value(); });
  if (scene.fluid && coupled + (scene.uniform_force ? 1 : 0) > 1) {
    plan.built.push_back({"sum of reactions",
                          "adds up where bodies touch the same nodes of the fluid",
                          72.0 * pushed,
                          {Kind::Sum}});
  } else if (scene.fluid) {
    plan.left_out.push_back({"sum of reactions", "at most one body pushes the fluid", Kind::Sum});
  }
  if (scene.bodies.empty()) plan.left_out.push_back({"bodies", "the case names none", Kind::Bonds});
  return plan;
}

void put_in(Plan& plan, Built built) {
  std::erase_if(plan.left_out, [&](const LeftOut& l) { return l.part && has(built.parts, *l.part); });
  plan.built.push_back(std::move(built));
}

std::vector<std::string> broken_promises(const Plan& plan, const parts::AllMade& made) {
  const auto count = [&](Kind kind) { return made[static_cast<std::size_t>(kind)].count; };
  const auto name = [](Kind kind) { return row_of(parts::kinds, kind).name; };
  std::vector<Kind> planned;
  std::vector<std::string> broken;
  for (const Built& built : plan.built) {
    for (const Kind kind : built.parts) {
      planned.push_back(kind);
      if (count(kind) == 0)
        broken.push_back(fmt::format("{}: planned as {} and not there", name(kind), built.module));
    }
  }
  for (const auto& kind : parts::kinds) {
    if (kind.value == Kind::Hessian) continue;  // a look at a state makes one and forgets it
    if (count(kind.value) == 0 || has(planned, kind.value)) continue;
    broken.push_back(fmt::format("{}: there and not planned", kind.name));
  }
  return broken;
}

std::optional<ExpectedWork> expected_work(const Scene& scene, std::int64_t steps) {
  const auto times = static_cast<std::uint64_t>(steps);
  ExpectedWork work{scene.fluid, {}, 0.0};
  if (scene.fluid) work.counts.node_updates = times * static_cast<std::uint64_t>(scene.fluid->grid.count());
  for (const Body& body : scene.bodies) {
    if (scene.fluid && body.coupling) {
      work.counts.marker_interpolations +=
          times * coupled_nodes(body).size() * static_cast<std::uint64_t>(body.coupling->forcing_iterations);
    }
    if (body.motion) continue;
    if (body.substeps.safety > 0.0 || body.scheme != solid::Scheme::LeapFrog) return std::nullopt;
    if (scene.fluid && body.coupling) {
      const auto nodes = static_cast<double>(body.network.node_count());
      (body.coupling->subcycled ? work.checked_substeps : work.checked_nodes) +=
          body.coupling->subcycled ? nodes * body.substeps.count : nodes;
    }
    const std::uint64_t evaluations = 1 + times * static_cast<std::uint64_t>(body.substeps.count);
    work.counts.bond_evaluations += evaluations * body.network.bonds.size();
    work.counts.angle_evaluations += evaluations * body.network.angles.size();
  }
  return work;
}

solid::Network build(const SolidSpec& spec) {
  solid::Network network = std::holds_alternative<solid::Block>(spec.shape)
                               ? solid::cubic_lattice(std::get<solid::Block>(spec.shape))
                               : solid::rod_lattice(std::get<solid::Rod>(spec.shape));
  if (spec.angle_stiffness != 0.0) solid::add_angles(network);
  return network;
}

}  // namespace veriflex::scene
