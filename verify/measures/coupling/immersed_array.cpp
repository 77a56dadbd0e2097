#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "analytic/channel.hpp"
#include "base/error.hpp"
#include "base/reduce.hpp"
#include "base/root.hpp"
#include "engine/check_place.hpp"
#include "engine/read_scene.hpp"
#include "measures/coupling/immersed.hpp"
#include "measures/coupling/run_monitored.hpp"

// A body of markers in a periodic cell is an array of bodies. The force on the fluid acts inside of the body
// too, and the mean pressure gradient that it stands for acts on the body: once the flow is steady the
// markers take up the force on the whole cell.
//
// Markers stand on the body's surface, evenly, each for its share of the surface times one spacing: without
// slip there the fluid inside is at rest, markers in it would have nothing to do, and the surface of a
// lattice's ball lies anywhere within half a spacing of the ball's. The radius whose drag is measured is not
// theirs: kernels make the surface some spacings thick, and a steady force needs a steady slip. It is fitted
// to the most dilute array, and with it the drag of denser ones is predicted.

namespace veriflex::measures::immersed {

namespace {

using observe::Observations;
using std::numbers::pi;

enum class Shape { Sphere, Cylinder };

struct Array {
  fluid::Spec fluid;  // box and force are the cell's
  scene::Forcing forcing;
  Shape shape;
  double radius;                        // of the markers' surface  [L]
  double marker_spacing;                // square root of a marker's share of the surface  [L]
  std::int64_t first_cell;              // nodes across the most dilute cell
  std::vector<double> solid_fractions;  // of the denser ones, with the fitted radius
  double velocity;                      // of the flow, about  [L T^-1]
  double steady_change;
  observe::MonitorSpec monitor;
};

/// The markers, and what share of the surface times h each of them stands for.
struct Surface {
  Positions markers;
  double volume;  // [L^3]
};

/// A Fibonacci lattice: as even as any number of points can be.                       [swinbank-purser-2006]
Surface sphere(double radius, double spacing, const Vec3& centre) {
  const double area = 4.0 * pi * radius * radius;
  const auto count = static_cast<Eigen::Index>(std::llround(area / (spacing * spacing)));
  const double golden = pi * (3.0 - std::sqrt(5.0));
  Surface surface{Positions(count, 3), area / static_cast<double>(count)};
  for (Eigen::Index i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count);
    const double angle = golden * static_cast<double>(i);
    const double across = std::sqrt(1.0 - z * z);
    surface.markers.row(i) =
        (centre + radius * Vec3(across * std::cos(angle), across * std::sin(angle), z)).transpose();
  }
  return surface;
}

/// One ring for each node along the axis, here one.
Surface cylinder(double radius, double spacing, const Vec3& centre) {
  const auto count = static_cast<Eigen::Index>(std::llround(2.0 * pi * radius / spacing));
  Surface surface{Positions(count, 3), 2.0 * pi * radius / static_cast<double>(count)};
  for (Eigen::Index i = 0; i < count; ++i) {
    const double angle = 2.0 * pi * static_cast<double>(i) / static_cast<double>(count);
    surface.markers.row(i) = (centre + radius * Vec3(std::cos(angle), std::sin(angle), 0.0)).transpose();
  }
  return surface;
}

double solid_fraction(Shape shape, double radius, double side) {
  const double ratio = radius / side;
  return shape == Shape::Sphere ? 4.0 / 3.0 * pi * ratio * ratio * ratio : pi * ratio * ratio;
}

double side_of(Shape shape, double radius, double fraction) {
  return shape == Shape::Sphere ? radius * std::cbrt(4.0 / 3.0 * pi / fraction)
                                : radius * std::sqrt(pi / fraction);
}

/// F/(mu U), per length of a cylinder.
double exact_resistance(Shape shape, double radius, double side) {
  const double fraction = solid_fraction(shape, radius, side);
  return shape == Shape::Sphere ? 6.0 * pi * radius * analytic::sphere_array_drag(fraction)
                                : analytic::cylinder_array_drag(fraction);
}

/// In the units of the tables: over 6 pi a for a sphere.
double unit_of(Shape shape, double radius) { return shape == Shape::Sphere ? 6.0 * pi * radius : 1.0; }

struct Steadied {
  std::int64_t nodes;  // across the cell
  double resistance;   // F/(mu U) of the markers
  double relative;     // the same with U less the fluid's mean velocity at the markers
  double slip;         // root mean square over the markers, of the fluid's velocity, over U
  double across;       // force across the flow over that along it
  double imbalance;    // force that the markers do not take up, over the whole
  std::int64_t steps;
};

fluid::Spec cell(const Array& study, std::int64_t nodes) {
  fluid::Spec spec = study.fluid;
  spec.grid.size = {nodes, nodes, study.shape == Shape::Sphere ? nodes : 1};
  const auto side = static_cast<double>(nodes);
  const double force = study.velocity * fluid::viscosity(spec.relaxation_time) *
                       exact_resistance(study.shape, study.radius, side);
  spec.body_force[0] = force / static_cast<double>(nodes * nodes * spec.grid.size[2]);
  return spec;
}

/// Six times what momentum takes across the cell.
double settling_time(double side, double viscosity) {
  return 6.0 * side * side / (4.0 * pi * pi * viscosity);
}

std::int64_t settling_steps(double side, double viscosity) {
  return static_cast<std::int64_t>(std::ceil(settling_time(side, viscosity)));
}

/// Steps until the markers take up the whole force. The flow's own relaxation, as slow as the mean velocity's
/// approach to balance, is not waited for: creeping flow is linear, so that after its fast part, diffusion
/// across the cell, has died out it is multiplied by what the balance lacks.
Steadied drag_of(const Array& study, std::int64_t nodes) {
  const fluid::Spec spec = cell(study, nodes);
  const auto middle = static_cast<double>(nodes / 2);
  const Surface surface = study.shape == Shape::Sphere
                              ? sphere(study.radius, study.marker_spacing, {middle, middle, middle})
                              : cylinder(study.radius, study.marker_spacing, {middle, middle, 0.0});
  scene::Forcing forcing = study.forcing;
  forcing.marker_volume = surface.volume;
  scene::PrescribedBody body(spec, forcing);
  body.place(surface.markers);
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(spec);
  fluid->start([&](std::int64_t) { return fluid::equilibrium(1.0, {study.velocity, 0.0, 0.0}); });

  const double nu = fluid::viscosity(spec.relaxation_time);
  const auto side = static_cast<double>(nodes);
  const std::int64_t settling = settling_steps(side, nu);
  const auto volume = static_cast<double>(spec.grid.count());
  const double whole = spec.body_force[0] * volume;
  constexpr int max_rounds = 30;
  double imbalance = INFINITY;
  int rounds = 0;
  for (;;) {
    run_monitored(*fluid, study.monitor, fmt::format("{} nodes", nodes), settling,
                  [&](std::int64_t) { body.advance(*fluid, Vec3::Zero()); });
    ++rounds;
    imbalance = body.total_force()[0] / whole - 1.0;
    if (std::abs(imbalance) <= study.steady_change) break;
    if (rounds == max_rounds) {
      throw NumericalFailure(
          fmt::format("after {} times {} steps the markers take up {} times the force on the "
                      "fluid; steady means 1 within {}",
                      rounds, settling, 1.0 + imbalance, study.steady_change));
    }
    const fluid::State state = fluid->state();
    fluid->start([&](std::int64_t node) {
      fluid::Populations h = state.populations[static_cast<std::size_t>(node)];
      for (double& f : h) f /= 1.0 + imbalance;
      return h;
    });
  }
  const Vec3 force = body.total_force();
  const double velocity = (fluid->totals().momentum[0] + 0.5 * (whole - force[0])) / volume;
  const Positions slip = body.slip_of_fluid();
  return {nodes,
          force[0] / (nu * velocity),
          force[0] / (nu * (velocity - slip.col(0).mean())),
          std::sqrt(slip.squaredNorm() / static_cast<double>(slip.rows())) / velocity,
          std::hypot(force[1], force[2]) / force[0],
          std::abs(imbalance),
          rounds * settling};
}

double fitted_radius(const Array& study, std::int64_t nodes, double resistance) {
  const auto excess = [&](double radius) {
    return exact_resistance(study.shape, radius, static_cast<double>(nodes)) - resistance;
  };
  const double low = 0.5 * study.radius, high = 1.6 * study.radius;
  if (excess(low) > 0.0 || excess(high) < 0.0) {
    throw NumericalFailure(
        fmt::format("the drag in the cell of {} nodes, {} nu U, is that of no radius from {} to {}", nodes,
                    resistance, low, high));
  }
  return bracketed_root(excess, low, high);
}

/// Up to which the series of drag is known to 0.1 %.
double series_end(Shape shape) { return shape == Shape::Sphere ? 0.1251 : 0.1001; }

/// Whether any drag is predicted.
bool predicts(const Array& study) {
  return std::any_of(study.solid_fractions.begin(), study.solid_fractions.end(),
                     [&](double fraction) { return fraction < series_end(study.shape); });
}

Observations array_observations(const Array& study) {
  Observations all;
  all.records = {
      {"array",
       "Drag of each body of an array of markers, with the radius fitted to the most dilute one",
       {{"nodes", "", "1", "across a cell", {}},
        {"solid_fraction", "c", "1", "with the fitted radius", {}},
        {"drag", "", "1", "of the fitted radius, in the units of the table", {}},
        {"drag_exact", "", "1", "series; not a number beyond its end", {}},
        {"error_drag", "", "1", "relative; of the first cell zero by the fit", {}},
        {"error_relative", "", "1", "the same by U less the fluid's mean velocity at the markers", {}},
        {"slip", "", "1", "root mean square of sum f c + g/2 at the markers, over U", {}},
        {"across", "", "1", "force across the flow over the force along it", {}},
        {"steps", "", "T", "until the force was balanced", {}}}}};
  all.metrics = {
      {"offset", {}, "L", "fitted radius beyond the markers'"},
      {"offset_relative", {}, "L", "the same, fitted by U less the fluid's mean velocity at the markers"},
      {"slip", {}, "1", "over U, in the most dilute array"},
      {"imbalance", {}, "1", "largest share of the force that markers do not take up"},
      {"force_across", {}, "1", "largest force across the flow, over the drag"}};
  for (std::size_t i = 1; i <= study.solid_fractions.size(); ++i) {
    all.metrics.push_back({fmt::format("drag_{}", i),
                           {},
                           "1",
                           fmt::format("at solid fraction {}", study.solid_fractions[i - 1])});
  }
  if (predicts(study)) {
    all.metrics.push_back({"prediction_error", {}, "1", "largest of the predicted drags"});
    all.metrics.push_back({"prediction_error_relative",
                           {},
                           "1",
                           "the same by U less the fluid's mean velocity at the markers"});
  }
  return all;
}

void run_array(const Array& study, Observations& seen, Progress& progress) {
  const std::size_t cells = study.solid_fractions.size() + 1;
  progress.show("cells", 0, cells);
  const Steadied first = drag_of(study, study.first_cell);
  const double radius = fitted_radius(study, study.first_cell, first.resistance);
  const double relative = fitted_radius(study, study.first_cell, first.relative);
  const double unit = unit_of(study.shape, radius);
  seen.set("offset", radius - study.radius);
  seen.set("offset_relative", relative - study.radius);
  seen.set("slip", first.slip);
  observe::Record& record = seen.open("array");
  double worst = 0.0, worst_relative = 0.0, imbalance = 0.0, across = 0.0;
  for (std::size_t i = 0; i < cells; ++i) {
    const double wanted = i == 0 ? 0.0 : study.solid_fractions[i - 1];
    const Steadied s = i == 0 ? first : drag_of(study, std::llround(side_of(study.shape, radius, wanted)));
    const auto side = static_cast<double>(s.nodes);
    const bool is_known = wanted < series_end(study.shape);
    const double exact = is_known ? exact_resistance(study.shape, radius, side) : NAN;
    const double error = std::abs(s.resistance / exact - 1.0);
    const double error_relative =
        is_known ? std::abs(s.relative / exact_resistance(study.shape, relative, side) - 1.0) : NAN;
    record.append({side, solid_fraction(study.shape, radius, side), s.resistance / unit, exact / unit, error,
                   error_relative, s.slip, s.across, static_cast<double>(s.steps)});
    progress.show("cells", i + 1, cells);
    imbalance = worse(imbalance, s.imbalance);
    across = worse(across, s.across);
    if (i == 0) continue;
    double drag = s.resistance / unit;
    if (is_known) {
      worst = worse(worst, error);
      worst_relative = worse(worst_relative, error_relative);
      // The cell is a whole number of nodes: the fraction is not quite the one asked for.
      drag = drag * exact_resistance(study.shape, radius, side_of(study.shape, radius, wanted)) / exact;
    }
    seen.set(fmt::format("drag_{}", i), drag);
  }
  if (predicts(study)) {
    seen.set("prediction_error", worst);
    seen.set("prediction_error_relative", worst_relative);
  }
  seen.set("imbalance", imbalance);
  seen.set("force_across", across);
}

}  // namespace

engine::Study read_array(const io::Table& top) {
  const io::Table t = top.table("immersed");
  const Array study{
      .fluid = read_fluid(top),
      .forcing = read_forcing(top, Volume::OfSurface),
      .shape = t.choice("body", {"sphere", "cylinder"}) == "sphere" ? Shape::Sphere : Shape::Cylinder,
      .radius = read_positive(t, "radius", 3.0),
      .marker_spacing = read_positive(t, "marker_spacing", 1.0),
      .first_cell = t.integer("first_cell", 4, 4096),
      .solid_fractions = t.numbers("solid_fractions"),
      .velocity = read_positive(t, "velocity", 1e-4),
      .steady_change = read_positive(t, "steady_change", 1e-5),
      .monitor = engine::read_monitor(top)};
  const auto first_cell = static_cast<double>(study.first_cell);
  const double dilute = solid_fraction(study.shape, study.radius, first_cell);
  if (!(dilute < series_end(study.shape))) {
    t.fail(
        "radius", fmt::format("'radius' is {} in a cell of {} nodes", study.radius, study.first_cell),
        fmt::format("it is fitted there by a series, which is known up to a solid fraction of {:.3g}; this "
                    "is {:.3g}",
                    series_end(study.shape), dilute),
        "Use a smaller body or a larger first_cell");
  }
  if (!(study.marker_spacing >= 0.05) || study.marker_spacing > 2.0 * study.radius) {
    t.fail("marker_spacing", fmt::format("'marker_spacing' is {}", study.marker_spacing),
           fmt::format("it lies between 0.05 and the diameter, {}: a gap lets the fluid through, and many "
                       "markers a node are only slow",
                       2.0 * study.radius),
           "1 is a marker for each node");
  }
  const double touching = study.shape == Shape::Sphere ? pi / 6.0 : pi / 4.0;
  for (const double fraction : study.solid_fractions) {
    if (!(fraction > dilute && fraction < 0.9 * touching)) {
      t.fail("solid_fractions", fmt::format("'solid_fractions' holds {}", fraction),
             fmt::format("the radius is fitted at {:.3g}, and bodies touch at {:.3g}", dilute, touching),
             "Choose between the two, not too near to the last");
    }
  }
  engine::whole_steps(settling_time(first_cell, fluid::viscosity(study.fluid.relaxation_time)), 0.0,
                      "to settle the flow takes", top.table("fluid").place("relaxation_time"));
  return {.plan = engine::read_plan(top, {.fluid = cell(study, study.first_cell),
                                          .initial_flow = true,
                                          .coupling = engine::read_coupling(top),
                                          .exchange = "markers at rest on the surface of the body"}),
          .declares = array_observations(study),
          .run = [study](Observations& seen, Progress& progress, engine::Cost&) {
            run_array(study, seen, progress);
          }};
}

}  // namespace veriflex::measures::immersed
