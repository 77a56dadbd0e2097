/// Planted bugs: what a program like this might well get wrong, one switch each, to see whether its own cases
/// and tests would notice (`make mutants`, docs/MUTANTS.md).
///
/// In a normal build every switch is false while it is compiled, and nothing of it remains in the program.
/// Built with VERIFLEX_MUTANTS=ON (preset `mutants`) the program has the bug that the environment variable
/// VERIFLEX_MUTANT names, and none without it; an unknown name ends it with exit code 2.
///
/// In a hot loop a switch belongs where a constant is prepared, outside of the loop if at all possible.
#pragma once

#include <array>
#include <cstdint>

#include "base/named.hpp"

namespace veriflex {

/// Name, and what is wrong; in the order of the folders.
// clang-format off
#define VERIFLEX_EACH_MUTANT(EACH) \
  EACH(wrap_one_short, "a node below the box comes back one node short of its far end") \
  EACH(root_stops_early, "a bracketed root is what three iterations find") \
  EACH(quadrature_of_four_points, "an integral is that of 4 points instead of 512") \
  EACH(nan_lost_by_maximum, "the larger of two numbers is the other one where one is NaN") \
  EACH(nan_lost_in_arrays, "the largest magnitude of an array passes over NaN") \
  EACH(angles_not_counted, "evaluations of angles are not counted as work") \
  EACH(parts_bytes_short, "a part of a scene is counted with nine tenths of its memory") \
  EACH(harmonic_energy_doubled, "harmonic energy without its half") \
  EACH(harmonic_rest_length_off, "the harmonic tension rests 0.1 % beyond the rest length") \
  EACH(fene_r_max_not_squared, "R0 of the FENE energy is not squared, as the paper prints it") \
  EACH(lj_shift_dropped, "the Lennard-Jones energy is not shifted to be continuous at its cut-off") \
  EACH(lj_cutoff_dropped, "the Lennard-Jones tension goes on beyond its cut-off") \
  EACH(lj_repulsion_halved, "the Lennard-Jones tension lacks the 2 of its repulsion") \
  EACH(fene_k_without_square, "the default K is 30 epsilon/sigma") \
  EACH(fene_stiffness_gap, "the FENE stiffness is divided by 1 - (r/R0)^2 once instead of twice") \
  EACH(shifted_fene_width, "D of the shifted FENE energy is not squared") \
  EACH(shifted_fene_unbounded, "the shifted FENE bond has no longest length") \
  EACH(rest_length_rounded, "the rest length is rounded to four digits, as the paper prints it") \
  EACH(young_modulus_without_spacing, "the modulus is the stiffness, not over the rest length") \
  EACH(secant_range_of_tangent, "the range of the secant modulus is that of the tangent modulus") \
  EACH(angle_stiffness_of_full_shear, "calibrated k_a is r0^3 E/(4 (1 + nu))") \
  EACH(calibrated_energy_by_area, "a calibrated law is scaled by length^2 instead of length^3") \
  EACH(angle_stiffness_doubled, "k_a counts twice, as Eq. 14 read literally would have it") \
  EACH(angle_force_off, "forces of angles are 0.1 % larger than their energy says") \
  EACH(straight_and_right_swapped, "straight angles rest at 90 degrees and right ones at 180") \
  EACH(straight_angle_by_acos, "the deviation of a straight angle is a difference of angles") \
  EACH(angle_taken_as_tangent, "the force of an angle goes with the tangent of its deviation") \
  EACH(strayed_angles_unnoticed, "angles far from rest are computed by the series for small ones") \
  EACH(angle_hessian_unmixed, "the Hessian lacks the mixed derivatives of angles") \
  EACH(hessian_without_tension, "the Hessian lacks the stiffness across a bond that its tension gives") \
  EACH(bond_reaction_missing, "the first node of a bond does not feel it along z") \
  EACH(domain_not_asked, "bonds beyond the range of their law are not noticed") \
  EACH(rod_one_section_short, "a rod has one section less than asked for") \
  EACH(boundary_of_edges_only, "only nodes with fewer than five bonds count as surface") \
  EACH(spheroid_without_poles, "nodes on the surface of a spheroid are outside") \
  EACH(section_between_nodes, "the section of a block is (n - 1)(m - 1) r0^2") \
  EACH(newton_stops_early, "a static solution is content with a residual a million times larger") \
  EACH(newton_through_limits, "a step of Newton may go through a limit of the law") \
  EACH(damped_dynamics_stops_early, "damped dynamics is content with a residual a million times larger") \
  EACH(node_mass_halved, "leap-frog accelerates half of the node mass") \
  EACH(substep_short, "a sub-step is 1 % too short") \
  EACH(force_of_last_substep, "the reaction is the force of the last sub-step over their number, not the mean") \
  EACH(force_not_averaged, "the reaction is the sum of the force over the sub-steps, not the mean") \
  EACH(frozen_force_follows, "a force that is frozen over the sub-steps follows the velocity") \
  EACH(coupling_velocity_on_step, "F_int takes the velocity of the step, not the one that leap-frog carries") \
  EACH(start_not_shifted, "the velocity of the start is taken as that of half a step before") \
  EACH(drive_a_substep_late, "driven nodes are where they should have been a sub-step ago") \
  EACH(drive_ramp_ignored, "a drive has its full amplitude from the start") \
  EACH(drag_doubled, "drag acts with twice its coefficient") \
  EACH(velocity_without_load, "the velocity of a loaded body is half a kick of its load behind") \
  EACH(load_raises_energy, "the energy of a dead load has the wrong sign") \
  EACH(refused_steps_kept, "a step that should be refused is kept") \
  EACH(smallest_frequency, "the largest frequency of a small body is its smallest") \
  EACH(frequency_without_mass, "frequencies do not know the mass of a node") \
  EACH(midpoint_inertia_halved, "the implicit midpoint rule has half of the inertia") \
  EACH(mechanisms_accepted, "a body with zero modes is solved as if it stood") \
  EACH(tau_off_by_half, "a collision relaxes with tau + 1/2") \
  EACH(tau_off_by_1e_4, "a collision relaxes with tau times 1.0001") \
  EACH(collision_without_u_squared, "the equilibrium of a collision lacks -3/2 u^2") \
  EACH(diagonal_weight_doubled, "density relaxes with the weight 1/36 for the diagonals") \
  EACH(body_force_doubled, "a body force gives twice its momentum") \
  EACH(velocity_not_shifted, "Guo's equilibrium takes the velocity along x without half of the force") \
  EACH(guo_source_not_reduced, "Guo's source lacks its factor 1 - 1/(2 tau)") \
  EACH(moments_without_squares, "what leaves a node of moments has no terms in u^2") \
  EACH(moment_force_unshifted, "a force on moments does not shift their velocity") \
  EACH(moment_push_halved, "a force at a node of moments gives half of its momentum") \
  EACH(moments_not_restored, "a fluid of moments is put back by its populations' sums") \
  EACH(node_force_halved, "a force at a node of populations gives half of its momentum") \
  EACH(equilibrium_linear, "an equilibrium to start from lacks 9/2 (c.u)^2") \
  EACH(stress_not_halved, "the viscous stress has the factor 1 - 1/tau") \
  EACH(inflow_at_once, "an inflow has its full velocity from the start") \
  EACH(wall_gain_halved, "a moving wall gives half of its momentum") \
  EACH(corner_link_to_other_wall, "the link across two ends of the box belongs to the later axis") \
  EACH(obstacle_force_once, "the force on an obstacle counts a turned population once") \
  EACH(obstacle_link_lost, "populations along one direction go through an obstacle") \
  EACH(outflow_density_ignored, "an outflow lets out at density 1 whatever was asked") \
  EACH(outflow_without_shear, "an outflow does not know the shear of the node inside") \
  EACH(outflow_of_last_node, "what leaves by an outflow is carried on from the last node alone") \
  EACH(parabola_off_by_half_a_node, "the parabola of an inflow is half a node off its walls") \
  EACH(parabola_of_last_walls, "an inflow between four walls is a parabola between two of them") \
  EACH(obstacle_without_images, "an obstacle across a periodic edge lacks its part beyond") \
  EACH(initial_stress_reversed, "populations to start from have the stress of the opposite shear") \
  EACH(row_end_not_turned, "what wraps round the high end of a row keeps its lane") \
  EACH(wall_ends_ignored, "a sweep does not look at what came back from a wall at the low end of a row") \
  EACH(turned_back_one_node_off, "what a wall beside a row turns back comes back at the next node") \
  EACH(tile_edge_left_out, "the first row of each further tile is not swept") \
  EACH(staggered_sum_still, "the staggered momentum does not alternate with the steps") \
  EACH(lone_fast_node_overlooked, "a row with a single node that is too fast is passed over") \
  EACH(delta_scaled, "the cosine delta function is 0.1 % too small") \
  EACH(three_point_cut_short, "the 3-point delta function ends at 1.4") \
  EACH(support_shifted, "weights are those of a marker 0.01 nodes away") \
  EACH(ball_not_cut, "the ball of the cosine is the whole cube") \
  EACH(spread_evenly, "forces are spread evenly over the support, not by the weights of interpolation") \
  EACH(last_node_not_interpolated, "interpolation leaves out the last node of each support") \
  EACH(rounds_ignore_volume, "further rounds of forcing take a marker's volume for 1") \
  EACH(shared_node_of_first_body, "at a node under two bodies only the first one's force counts") \
  EACH(exchange_reversed, "F_int has the wrong sign") \
  EACH(marker_volume_ignored, "F_int takes a marker's volume for 1") \
  EACH(reaction_missing, "the fluid does not feel a body") \
  EACH(reaction_doubled, "the fluid feels a body twice") \
  EACH(markers_stay_behind, "markers of an elastic body stay where it was undeformed") \
  EACH(supports_kept_too_long, "supports of markers are found anew in every second step") \
  EACH(prescribed_velocity_ahead, "a given motion has the velocity of half a step later") \
  EACH(uniform_force_ahead, "a uniform force is that of the next step") \
  EACH(bodies_not_restored, "a state that is put back leaves the bodies where they are") \
  EACH(contact_across_edge_missed, "bodies that meet across the edge of the box are far apart") \
  EACH(axes_turned_wrong, "a body whose axis is x or y is turned the other way") \
  EACH(bonds_across_reversed, "bonds through the edge of the box point into the body") \
  EACH(map_without_reaction, "the linearised step gives the fluid half of the reaction") \
  EACH(map_of_one_substep, "the linearised step takes the stiffness over a whole step in each sub-step") \
  EACH(growth_of_one_substep, "alternating growth is that of a body without sub-steps") \
  EACH(growth_seen_too_small, "the exact growth of a scene is the root of what it is") \
  EACH(plan_of_fewer_bytes, "a plan forgets the memory of what markers exchange") \
  EACH(lammps_bond_reversed, "the second arm of an angle of a data file points at its apex") \
  EACH(total_without_potential, "the total energy of a body is its kinetic energy") \
  EACH(walls_blamed_for_force, "the impulse of walls contains that of the body force") \
  EACH(support_with_fluid, "what holds a body is credited with the force of the fluid") \
  EACH(strain_of_last_step, "the largest strain between rows is that of the last step") \
  EACH(slip_without_root, "the root mean square of the slip is its mean square") \
  EACH(inertia_of_points, "the tensor of inertia adds r r^T instead of taking it off") \
  EACH(turns_of_first_body, "the turning of all bodies is added to that of the first") \
  EACH(observer_rounds_down, "an observer whose interval is no whole number of steps misses rows") \
  EACH(mach_without_sound, "the Mach number is the speed") \
  EACH(momentum_as_velocity, "the velocity at a node is its momentum") \
  EACH(stress_columns_swapped, "the columns of the stresses xz and yz hold each other's") \
  EACH(buckling_overlooked, "a column counts as buckled at ten times its limit") \
  EACH(lost_energy_unnoticed, "a body may lose any energy") \
  EACH(cells_inside_out, "a cell that is turned inside out is not noticed") \
  EACH(csv_sign_lost, "numbers of a table lose their sign") \
  EACH(tolerance_always_relative, "an absolute tolerance is taken times the target") \
  EACH(target_taken_as_measured, "a check compares its target with itself") \
  EACH(error_with_sign, "what is measured below its target has no error") \
  EACH(outside_taken_as_within, "a check that must lie outside is judged as one that must lie within") \
  EACH(refutation_unchecked, "a refuted claim may be refuted by any number") \
  EACH(curve_loses_nan, "the distance of a curve from its reference passes over NaN") \
  EACH(verdict_of_last_check, "only the last check of a case decides") \
  EACH(checksum_not_compared, "a data file that does not match its checksum is read") \
  EACH(plan_not_held, "a run that built what its plan left out passes") \
  EACH(order_of_swapped_grids, "the order of an error is fitted with the grids swapped") \
  EACH(richardson_of_first_order, "Richardson's extrapolation takes order 1") \
  EACH(gci_without_safety, "the grid convergence index lacks its factor of safety") \
  EACH(reynolds_of_radius, "the Reynolds number is that of half the length") \
  EACH(unit_of_time_inverted, "units of time are converted the wrong way") \
  EACH(moved_check_is_same, "two runs whose checks measured different numbers are the same") \
  EACH(dimension_lost, "the dimension of a metric is not stored") \
  EACH(ratio_of_a_row_to_itself, "a ratio of two rows is that of the second to itself") \
  EACH(largest_is_last, "the largest of some rows is the last") \
  EACH(spacings_not_inverted, "an axis of numbers of nodes is taken as one of spacings") \
  EACH(front_keeps_the_beaten, "a front keeps settings that others beat") \
  EACH(boundary_at_near_end, "a boundary is where the outcome was still as before") \
  EACH(criterion_ignored, "a run beyond the bound of a boundary counts as good") \
  EACH(orders_of_other_rows, "orders along an axis are taken from rows of another one") \
  EACH(ablation_sees_last_metric, "how far a part moves a case is told of the last metric alone") \
  EACH(rows_of_any_program, "rows that another program has left are taken") \
  EACH(advice_by_tau, "errors are fitted to tau instead of tau - 1/2") \
  EACH(slip_reference_off, "the exact slip of a half-way wall is that of a wall elsewhere") \
  EACH(duct_series_thinned, "the series of a square duct takes every second term") \
  EACH(womersley_real, "the exact oscillating flow has the wrong phase") \
  EACH(norm_of_squares, "an error in L2 lacks its root") \
  EACH(swing_through_zero, "a period is counted between rises through zero, not through the mean") \
  EACH(period_of_one_more, "a mean period is divided by the number of rises") \
  EACH(passage_without_rates, "when an oscillation passes through rest is found without its rate") \
  EACH(multirate_order_ignored, "the steps of the multirate method have order 3 whatever is asked for") \
  EACH(mean_flow_not_held, "a driven filament may set the whole box in motion") \
  EACH(harmonic_a_step_early, "the first harmonic of a filament is taken with the phase of a step before") \
  EACH(interface_at_last_layer, "the surface of an elastic layer is at its last nodes, not half a cell beyond") \
  EACH(checkpoint_without_moments, "a checkpoint of a fluid of moments holds its populations alone") \
  EACH(memories_not_resumed, "a run that goes on forgets what its series have added up")
// clang-format on

#define VERIFLEX_MUTANT(name, text) name,
enum class Mutant : std::uint8_t { none, VERIFLEX_EACH_MUTANT(VERIFLEX_MUTANT) };
#undef VERIFLEX_MUTANT

/// All but `none`.
#define VERIFLEX_MUTANT(name, text) Named<Mutant>{Mutant::name, #name, #name, text},
inline constexpr std::array mutants{VERIFLEX_EACH_MUTANT(VERIFLEX_MUTANT)};
#undef VERIFLEX_MUTANT
static_assert(mutants.size() < 255);

#ifdef VERIFLEX_MUTANTS
/// The bug that this program has.
extern const Mutant active_mutant;
inline bool planted(Mutant mutant) { return mutant == active_mutant; }
#else
/// Whether this program has that bug.
constexpr bool planted(Mutant) { return false; }
#endif

}  // namespace veriflex
