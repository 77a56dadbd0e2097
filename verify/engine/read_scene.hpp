/// Readers of the scene tables that several drivers share.
#pragma once

#include "bond/derive.hpp"
#include "fluid/obstacle.hpp"
#include "io/document.hpp"
#include "observe/check.hpp"
#include "scene/coupling_spec.hpp"
#include "scene/plan.hpp"

namespace veriflex::engine {

/// [bond], or another table of the same form: `law` and that law's parameters.
bond::AnyLaw read_law(const io::Table& top, const std::string& where = "bond");

/// What follows from that law, with a law that has no rest length reported at its place in the case.
bond::Derivation read_derivation(const io::Table& top, const bond::AnyLaw& law);

/// [solid]: `shape` pair, chain, bar or rod with its size, and `spacing` (default: the law's rest length).
/// [angle]: `stiffness` k_a; without that table there are no angles. The law must be defined at the spacing.
scene::SolidSpec read_solid(const io::Table& top, const bond::AnyLaw& law, double rest_length);

/// The same for drivers whose theory holds for a body at rest: refuses another spacing than the rest length.
scene::SolidSpec read_solid_at_rest(const io::Table& top, const bond::AnyLaw& law, double rest_length);

/// [angle] alone: k_a, 0 when the table is absent  [M L^2 T^-2].
double read_angle_stiffness(const io::Table& top);

/// `stiffness`: a factor of all stiffnesses of a body, of bonds and angles; 1 without it.
double read_stiffness_factor(const io::Table& table);

/// [fluid]: `nodes`, `relaxation_time` and what else the box has. `nodes` and `relaxation_time` are left to
/// the driver that varies them when `varied` says so: they are then 1 node and tau = 1.
enum class Varied { Nothing, Nodes, NodesAndRelaxationTime };
fluid::Spec read_fluid(const io::Table& top, Varied varied = Varied::Nothing);

/// Refuses a `representation` of [fluid] that is impossible at the fluid's tau; for drivers that vary tau.
void check_representation(const io::Table& top, const fluid::Spec& spec);

/// That value of `key`, refused where it is not positive.
double need_positive(const io::Table& table, const std::string& key, double value,
                     const std::string& suggestion = "Give more than 0");

/// Three numbers.
Vec3 read_vector(const io::Table& table, const std::string& key);

/// `x`, `y` or `z` as 0, 1 or 2.
int read_axis(const io::Table& table, const std::string& key = "axis");

/// `relaxation_time`, more than 1/2.
double read_relaxation_time(const io::Table& table);

/// `nodes` of [fluid]: three numbers.
std::array<std::int64_t, 3> read_box(const io::Table& fluid);

/// [fluid.obstacle]: the shape that read_fluid cuts out of the box; for drivers that refine it.
fluid::Shape read_obstacle(const io::Table& fluid);

/// [monitor]: when a fluid is checked, and how fast it may become. The table may be absent.
observe::MonitorSpec read_monitor(const io::Table& top);

/// [coupling]: `delta`, `nodes`, `marker_volume`, `subcycled`, `forcing_iterations`; all have defaults, and
/// so the table may be absent.
scene::CouplingSpec read_coupling(const io::Table& top);

/// `keep` of a table: parts that are built although they do nothing, out of `known`. Throws InputError.
std::vector<std::string> read_kept(const io::Table& table, const std::vector<std::string>& known);

/// The plan, with a scene that cannot be planned reported at its place in the case.
scene::Plan read_plan(const io::Table& top, const scene::Outline& scene);

}  // namespace veriflex::engine
