#include "measures/filament/filament_run.hpp"

#include <cmath>
#include <numbers>

#include "base/reduce.hpp"
#include "observe/run.hpp"
#include "scene/markers.hpp"
#include "solid/modes.hpp"

namespace veriflex::measures {

namespace {

/// Nodes of the rod's axis and those that are driven, by their numbers in rod_lattice().
struct Places {
  std::vector<std::int32_t> axis, driven;
};

Places places_of(const Stroke& stroke, const Positions& rest) {
  Places places;
  for (Eigen::Index i = 0; i < rest.rows(); ++i) {
    const bool on_axis = rest(i, 0) == 0.0 && rest(i, 1) == 0.0;
    if (on_axis) places.axis.push_back(static_cast<std::int32_t>(i));
    const bool at_end = rest(i, 2) > stroke.length() - 0.5 * stroke.rod.spacing;
    if (at_end && (on_axis || stroke.driven == Driven::Section)) {
      places.driven.push_back(static_cast<std::int32_t>(i));
    }
  }
  return places;
}

/// The free end. Whole boxes along a periodic axis are taken out of the offset: they change nothing.
Vec3 middle_of(const Stroke& stroke) {
  const std::array<bool, 3> walled = closed(stroke.fluid);
  Vec3 middle = stroke.offset;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    const std::int64_t size = stroke.fluid.grid.size[axis];
    if (!walled[axis]) middle[i] = std::remainder(middle[i], static_cast<double>(size));
    middle[i] += static_cast<double>(size / 2);
  }
  middle[1] -= 0.5 * stroke.length();
  return middle;
}

Vec3 bond_vector(const scene::Simulation& simulation, std::size_t bond) {
  const auto [i, j] = simulation.body().network().bonds[bond];
  const Positions& u = simulation.body().solid().displacement();
  return simulation.body().network().vectors.row(static_cast<Eigen::Index>(bond)) + (u.row(j) - u.row(i));
}

/// The shortest and the longest bond now.
struct Lengths {
  double min_square = INFINITY, max_square = -INFINITY;  // [L^2]
  std::size_t shortest = 0, longest = 0;
};

Lengths lengths_of(const scene::Simulation& simulation) {
  Lengths seen;
  for (std::size_t b = 0; b < simulation.body().network().bonds.size(); ++b) {
    const double square = bond_vector(simulation, b).squaredNorm();
    if (square < seen.min_square) {
      seen.min_square = square;
      seen.shortest = b;
    }
    if (square > seen.max_square) {
      seen.max_square = square;
      seen.longest = b;
    }
  }
  return seen;
}

/// Smallest and largest bond strain until now, of every step, and where along the rod.
void track_strains(const scene::Simulation& simulation, const Stroke& stroke, const Lengths& now, double time,
                   StrokeResult& seen) {
  const solid::Network& network = simulation.body().network();
  const auto place = [&](std::size_t bond) {
    return 0.5 * (network.rest(network.bonds[bond].first, 1) + network.rest(network.bonds[bond].second, 1));
  };
  const double smallest = std::sqrt(now.min_square) / stroke.rod.spacing - 1.0;
  const double largest = std::sqrt(now.max_square) / stroke.rod.spacing - 1.0;
  if (smallest < seen.min_strain) {
    seen.min_strain = smallest;
    seen.min_strain_time = time;
    seen.min_strain_place = place(now.shortest);
  }
  if (largest > seen.max_strain) {
    seen.max_strain = largest;
    seen.max_strain_time = time;
    seen.max_strain_place = place(now.longest);
  }
}

/// Counts the bonds' lengths.
void count_lengths(const scene::Simulation& simulation, const Stroke& stroke, StrokeResult& seen) {
  for (std::size_t b = 0; b < simulation.body().network().bonds.size(); ++b) {
    const double length = bond_vector(simulation, b).norm();
    if (length < stroke.short_bond) seen.share_short += 1.0;
    const double strain = length / stroke.rod.spacing - 1.0;
    const double bin = (strain - strain_bin_lo) / (strain_bin_hi - strain_bin_lo) * strain_bins;
    seen.histogram[static_cast<std::size_t>(std::clamp(std::floor(bin), 0.0, strain_bins - 1.0))] += 1.0;
  }
}

CentreLine line_of(const Positions& u, const std::vector<std::int32_t>& axis) {
  CentreLine line(static_cast<Eigen::Index>(axis.size()), 3);
  for (std::size_t s = 0; s < axis.size(); ++s) {
    line.row(static_cast<Eigen::Index>(s)) = u.row(axis[s]);
  }
  return line;
}

/// The flow in the plane through the axis along which the end is driven.
Frame frame_of(const fluid::Fluid& fluid, const Stroke& stroke, double phase) {
  const Vec3 middle = middle_of(stroke);
  const auto [nx, ny, nz] = fluid.spec().grid.size;
  std::vector<std::int64_t> nodes;
  for (std::int64_t z = 0; z < nz; z += stroke.film) {
    for (std::int64_t y = 0; y < ny; y += stroke.film) nodes.push_back(fluid.spec().grid.index(nx / 2, y, z));
  }
  Positions u;
  fluid.velocities(nodes, u);
  Frame frame{phase, Positions(u.rows(), 3), u.rowwise().norm()};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto at = fluid.spec().grid.node(nodes[i]);
    for (int axis = 0; axis < 3; ++axis) {
      frame.place(static_cast<Eigen::Index>(i), axis) =
          static_cast<double>(at[static_cast<std::size_t>(axis)]) - middle[axis];
    }
  }
  return frame;
}

}  // namespace

scene::Body body_of(const Stroke& stroke) {
  solid::Network network = solid::rod_lattice(stroke.rod);
  if (stroke.angle_stiffness != 0.0) solid::add_angles(network);
  solid::Conditions conditions;
  conditions.node_mass = stroke.node_mass;
  conditions.drive = solid::Drive{places_of(stroke, network.rest).driven, 2, stroke.amplitude, stroke.omega(),
                                  stroke.ramp_periods * stroke.period()};
  network.rest = scene::turned(network.rest, 1);
  network.vectors = scene::turned(network.vectors, 1);
  return {.material = {stroke.law, stroke.angle_stiffness},
          .network = std::move(network),
          .conditions = conditions,
          .substeps = stroke.substeps,
          .place = middle_of(stroke),
          .axis = 1,
          .coupling = stroke.coupling};
}

double step_over_limit(const Stroke& stroke) {
  const scene::Body body = body_of(stroke);
  solid::FixedDofs held = solid::FixedDofs::Constant(body.network.node_count(), 3, false);
  for (const std::int32_t node : body.conditions.drive->nodes) held(node, body.conditions.drive->axis) = true;
  const double omega = solid::largest_frequency(
      body.material, body.network, Positions::Zero(body.network.node_count(), 3), held, stroke.node_mass);
  return 0.5 * omega / stroke.substeps.count;
}

scene::Simulation simulation_of(const Stroke& stroke) {
  return scene::Simulation({.fluid = stroke.fluid, .bodies = {body_of(stroke)}});
}

double Stroke::omega() const {
  return reynolds * fluid::viscosity(fluid.relaxation_time) / (amplitude * length());
}

double Stroke::period() const { return 2.0 * std::numbers::pi / omega(); }

namespace {

/// Looks at the body after each step of its stroke.
class StrokeObserver {
 public:
  StrokeObserver(const Stroke& stroke, StrokeResult& seen)
      : stroke_(stroke),
        seen_(seen),
        places_(places_of(stroke, solid::rod_lattice(stroke.rod).rest)),
        period_(stroke.period()),
        every_(std::max<std::int64_t>(1, std::llround(period_ / 64.0))) {}

  void look(const scene::Simulation& simulation) {
    const std::int64_t step = simulation.steps();
    const Positions& now = simulation.body().solid().displacement();
    if (step > 0) {
      const double force = add_work(simulation, now);
      add_phases(simulation, now);
      const Lengths lengths = lengths_of(simulation);
      const double time = static_cast<double>(step) / period_;
      track_strains(simulation, stroke_, lengths, time, seen_);
      if (step % every_ == 0 || step == seen_.steps) add_moment(simulation, now, lengths, force);
    }
    before_ = now;
    momentum_before_ = simulation.body().solid().momentum()[2];
  }

 private:
  /// The drive's force: what is left of the body's momentum balance, as inner forces add up to nothing.
  double add_work(const scene::Simulation& simulation, const Positions& now) {
    const double momentum = simulation.body().solid().momentum()[2];
    const double force = momentum - momentum_before_ - simulation.body().exchanged().col(2).sum();
    const auto time = static_cast<double>(simulation.steps());
    const auto in_period =
        std::min<std::int64_t>(static_cast<std::int64_t>((time - 0.5) / period_), stroke_.periods - 1);
    const std::int32_t driven = places_.driven.front();
    seen_.work[static_cast<std::size_t>(in_period)] += force * (now(driven, 2) - before_(driven, 2));
    return force;
  }

  /// Centre lines at the phases passed in this step.
  void add_phases(const scene::Simulation& simulation, const Positions& now) {
    const auto time = static_cast<double>(simulation.steps());
    for (; next_phase_ * period_ / phases_per_period <= time &&
           next_phase_ <= stroke_.periods * phases_per_period;
         ++next_phase_) {
      const double part =
          next_phase_ * period_ / phases_per_period - (time - 1.0);  // linear between two steps
      const Positions between = (1.0 - part) * before_ + part * now;
      seen_.lines.push_back(line_of(between, places_.axis));
      seen_.centre.push_back(between.colwise().mean().transpose());
    }
  }

  void add_moment(const scene::Simulation& simulation, const Positions& now, const Lengths& lengths,
                  double force) {
    const auto time = static_cast<double>(simulation.steps());
    const Positions& slip = simulation.body().slip();
    seen_.history.push_back({.time = time / period_,
                             .drive = now(places_.driven.front(), 2),
                             .force = force,
                             .centre_y = now.col(1).mean(),
                             .slip = std::sqrt(slip.squaredNorm() / static_cast<double>(slip.rows())),
                             .min_strain = std::sqrt(lengths.min_square) / stroke_.rod.spacing - 1.0,
                             .max_strain = std::sqrt(lengths.max_square) / stroke_.rod.spacing - 1.0});
    if (time > (stroke_.periods - 1) * period_) count_lengths(simulation, stroke_, seen_);
  }

  const Stroke& stroke_;
  StrokeResult& seen_;
  Places places_;
  double period_;
  std::int64_t every_;  // steps between moments
  int next_phase_ = 1;
  Positions before_;
  double momentum_before_ = 0.0;
};

/// The flow at the phases of the last period, each in the step nearest to it.
void film(const scene::Simulation& simulation, const Stroke& stroke, StrokeResult& seen) {
  const double phases = static_cast<double>(simulation.steps()) * phases_per_period / stroke.period();
  const auto into_last = std::llround(phases) - (stroke.periods - 1) * phases_per_period;
  if (into_last != std::ssize(seen.film) + 1) return;  // the end is looked at too, which may be one step on
  seen.film.push_back(
      frame_of(simulation.fluid(), stroke, static_cast<double>(into_last) / phases_per_period));
}

}  // namespace

void run_stroke(const Stroke& stroke, const std::string& name, Progress& progress, StrokeResult& seen) {
  scene::Simulation simulation = simulation_of(stroke);
  seen.histogram.assign(strain_bins, 0.0);
  seen.work.assign(static_cast<std::size_t>(stroke.periods), 0.0);
  seen.steps = static_cast<std::int64_t>(std::ceil(stroke.periods * stroke.period()));
  StrokeObserver observer(stroke, seen);
  const observe::Due each_step{1.0}, each_phase{stroke.period() / phases_per_period};
  std::vector<observe::Observer> observers{
      {each_step, [&](const scene::Simulation& now) { observer.look(now); }, true}};
  if (stroke.film > 0)
    observers.push_back({each_phase, [&](const scene::Simulation& now) { film(now, stroke, seen); }});
  observe::Run run(simulation, stroke.monitor, std::move(observers), name, progress);
  run.advance(seen.steps, seen.steps);
  run.finish();
  seen.max_mach = run.max_mach();
  double bonds = 0.0;
  for (const double share : seen.histogram) bonds += share;
  for (double& share : seen.histogram) share /= bonds;
  seen.share_short /= bonds;
  seen.touched_nodes = simulation.body().touched_nodes();
  seen.seconds = simulation.seconds();
}

}  // namespace veriflex::measures
