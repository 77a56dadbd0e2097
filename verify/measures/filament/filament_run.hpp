/// One filament driven at one end through one fluid, and what is seen of it.
/// [wu-qi-2014, Sec. 3, Eqs. 26-27, Figs. 5-8]
#pragma once

#include <array>
#include <vector>

#include "base/error.hpp"
#include "base/progress.hpp"
#include "engine/cost.hpp"
#include "observe/check.hpp"
#include "scene/simulation.hpp"

namespace veriflex::measures {

/// What is driven at the far end: one node, as the paper says, or the whole end section.
enum class Driven { Node, Section };

struct Stroke {
  fluid::Spec fluid;
  solid::Rod rod;  // lies along y, its driven end at larger y
  bond::AnyLaw law;
  double angle_stiffness;  // [M L^2 T^-2]
  double node_mass;        // [M]
  solid::Substeps substeps;
  scene::CouplingSpec coupling;
  Vec3 offset;       // of the rod's axis from the middle of the box  [L]
  double amplitude;  // z0  [L]
  double reynolds;   // z0 omega L / nu
  Driven driven;
  double ramp_periods;  // 0: z0 sin(omega t) from rest
  int periods;
  observe::MonitorSpec monitor;
  Place node_mass_place{};  // in the case, where an unstable coupling is reported
  std::int64_t film = 0;    // nodes between the samples of the flow in the plane of the stroke; 0: none
  double short_bond = 0.0;  // a length whose share of shorter bonds is counted  [L]

  double length() const { return static_cast<double>(rod.sections - 1) * rod.spacing; }
  double omega() const;   // [T^-1]
  double period() const;  // [T]
};

constexpr int phases_per_period = 8;

/// Displacements of the axis nodes at one phase, section by section from the free end.
using CentreLine = Positions;

/// The flow in the plane of the stroke at one phase.
struct Frame {
  double phase;
  Positions place;        // of the samples, from the free end at rest  [L]
  Eigen::VectorXd speed;  // [L T^-1]
};

struct Moment {
  double time;        // in periods
  double drive;       // z of the driven node  [L]
  double force;       // that the drive exerts along z  [M L T^-2]
  double centre_y;    // displacement of the body's centre of mass  [L]
  double slip;        // root mean square over the coupled nodes  [L T^-1]
  double min_strain;  // of any bond
  double max_strain;
};

struct StrokeResult {
  std::vector<CentreLine> lines;  // phases_per_period for each period, at k T/8, k = 1 ...
  std::vector<Vec3> centre;       // centre of mass at the same times
  std::vector<Frame> film;        // phases_per_period, of the last period
  std::vector<Moment> history;    // about 64 a period
  std::vector<double> work;       // of the drive, per period  [M L^2 T^-2]
  double min_strain = 0.0, max_strain = 0.0;
  double min_strain_time = 0.0, max_strain_time = 0.0;    // in periods
  double min_strain_place = 0.0, max_strain_place = 0.0;  // along the axis, 0 at the free end  [L]
  std::vector<double> histogram;                          // of r/r0 in the last period, shares of strain_bins
  double share_short = 0.0;  // of bonds shorter than Stroke::short_bond, in the last period
  double max_mach = 0.0;
  std::size_t touched_nodes = 0;
  scene::Simulation::Seconds seconds;
  std::int64_t steps = 0;
};

constexpr int strain_bins = 80;
constexpr double strain_bin_lo = -0.4, strain_bin_hi = 0.6;

/// The body of a stroke, at its place in the box.
scene::Body body_of(const Stroke& stroke);

/// Its sub-step over the linear limit 2/omega_max of the body at rest, its driven coordinates held.
double step_over_limit(const Stroke& stroke);

/// The scene of a stroke before its first step. Throws BadParameter and NumericalFailure.
scene::Simulation simulation_of(const Stroke& stroke);

/// Fills `seen` as it goes. Throws observe::Interrupted when the run leaves its validity; `work`, `histogram`
/// and `share_short` are not yet divided then.
void run_stroke(const Stroke& stroke, const std::string& name, Progress& progress, StrokeResult& seen);

}  // namespace veriflex::measures
