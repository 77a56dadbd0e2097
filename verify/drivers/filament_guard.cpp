#include "drivers/filament_guard.hpp"

#include <fmt/format.h>

#include <cmath>

#include "engine/check_coupling.hpp"
#include "observe/interrupted.hpp"

namespace veriflex::drivers {

observe::Record history_of(const StrokeResult& seen, const std::string& name, const std::string& law) {
  observe::Record record{name,
                         "The stroke in time, " + law,
                         {{"time", "t/T", "1", "in periods", {}},
                          {"drive", "z", "L", "displacement of the driven node", {}},
                          {"force", "F", "M L T^-2", "that the drive exerts along z", {}},
                          {"centre_y", "Y", "L", "displacement of the centre of mass along the filament", {}},
                          {"slip", "", "L T^-1", "u_f - u_s, root mean square over the coupled nodes", {}},
                          {"least_strain", "", "1", "smallest bond strain", {}},
                          {"greatest_strain", "", "1", "largest bond strain", {}}}};
  for (const Moment& m : seen.history) {
    if (!std::isfinite(m.force) || !std::isfinite(m.slip)) break;  // of a stroke that broke off
    record.append({m.time, m.drive, m.force, m.centre_y, m.slip, m.least_strain, m.greatest_strain});
  }
  return record;
}

observe::Metric metric_of(double growth) {
  return {
      "coupling_growth", growth, "1",
      "largest factor a step of the linearised exchange, without the fluid's own motion; up to 1 is stable"};
}

namespace {

/// What is left of a stroke that broke off.
observe::Observations until(const StrokeResult& seen, const std::string& law) {
  observe::Record nodes{"last_good_nodes",
                        "Where the nodes were at the last good look, " + law,
                        {{"node", "", "1", "number of the node", {}},
                         {"x", "", "L", "in the box, not wrapped", {}},
                         {"y", "", "L", "along the filament at rest", {}},
                         {"z", "", "L", "along the drive", {}}}};
  const LastGood& good = seen.last_good;
  for (Eigen::Index i = 0; i < good.nodes.rows(); ++i) {
    nodes.append({static_cast<double>(i), good.nodes(i, 0), good.nodes(i, 1), good.nodes(i, 2)});
  }
  observe::Observations left{.records = {history_of(seen, "stroke", law), nodes},
                             .metrics = observe::last_good(good.step, good.fluid)};
  left.metrics.push_back({"least_strain", seen.least_strain, "1", "of any bond until the end"});
  left.metrics.push_back({"greatest_strain", seen.greatest_strain, "1", "of any bond until the end"});
  return left;
}

}  // namespace

double check_strokes(const std::vector<Stroke>& strokes, Progress& progress) {
  double growth = 0.0;
  for (const Stroke& stroke : strokes) {
    growth = std::max(growth, engine::check_coupling(stroke.fluid, body_of(stroke), coupling_of(stroke),
                                                     fmt::format("the {} body", bond::name_of(stroke.law)),
                                                     stroke.node_mass_place, progress));
  }
  return growth;
}

StrokeResult run_guarded(const Stroke& stroke, const std::string& name, double growth, Progress& progress) {
  try {
    return run_stroke(stroke, name, progress);
  } catch (const StrokeFailure& failure) {
    observe::Observations seen = until(failure.seen, name);
    seen.metrics.push_back(metric_of(growth));
    throw observe::Interrupted(NumericalFailure(fmt::format("{}: {}", name, failure.what())),
                               std::move(seen));
  }
}

std::vector<engine::Phase> parts_of(const scene::Simulation::Seconds& s) {
  return {{"fluid", s.fluid.wall, s.fluid.cpu},
          {"coupling", s.coupling.wall, s.coupling.cpu},
          {"solid", s.solid.wall, s.solid.cpu}};
}

}  // namespace veriflex::drivers
