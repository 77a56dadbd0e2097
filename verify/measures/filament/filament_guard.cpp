#include "measures/filament/filament_guard.hpp"

#include <fmt/format.h>

#include <cmath>

#include "measures/filament/filament_compare.hpp"
#include "observe/interrupted.hpp"

namespace veriflex::measures {

observe::Record history_of(const StrokeResult& seen, const std::string& name, const std::string& law) {
  observe::Record record{name,
                         "The stroke in time, " + law,
                         {{"time", "t/T", "1", "in periods", {}},
                          {"drive", "z", "L", "displacement of the driven node", {}},
                          {"force", "F", "M L T^-2", "that the drive exerts along z", {}},
                          {"centre_y", "Y", "L", "displacement of the centre of mass along the filament", {}},
                          {"slip", "", "L T^-1", "u_f - u_s, root mean square over the coupled nodes", {}},
                          {"min_strain", "", "1", "smallest bond strain", {}},
                          {"max_strain", "", "1", "largest bond strain", {}}}};
  for (const Moment& m : seen.history) {
    if (!std::isfinite(m.force) || !std::isfinite(m.slip)) break;  // of a stroke that broke off
    record.append({m.time, m.drive, m.force, m.centre_y, m.slip, m.min_strain, m.max_strain});
  }
  return record;
}

observe::Metric growth_of_coupling() {
  return {
      "coupling_growth",
      {},
      "1",
      "largest factor a step of the linearised exchange, without the fluid's own motion; up to 1 is stable"};
}

void check_strokes(const std::vector<Stroke>& strokes, observe::Observations& seen, Progress& progress) {
  double growth = 0.0;
  const auto check = [&] {
    for (const Stroke& stroke : strokes) {
      engine::check_coupling(stroke.fluid, body_of(stroke),
                             fmt::format("the {} body", bond::name_of(stroke.law)), stroke.node_mass_place,
                             growth, progress);
    }
  };
  try {
    check();
  } catch (const InputError&) {
    seen.set("coupling_growth", growth);
    throw;
  }
  seen.set("coupling_growth", growth);
}

StrokeResult run_guarded(const Stroke& stroke, const std::string& name, const std::string& history,
                         Progress& progress) {
  StrokeResult seen;
  try {
    run_stroke(stroke, name, progress, seen);
  } catch (const observe::Interrupted& broken) {
    observe::Observations left = broken.seen;
    left.records.insert(left.records.begin(), history_of(seen, history, name));
    left.metrics.push_back({"last_min_strain", seen.min_strain, "1", "of any bond until the end"});
    left.metrics.push_back({"last_max_strain", seen.max_strain, "1", "of any bond until the end"});
    throw observe::Interrupted(broken, std::move(left));
  }
  return seen;
}

std::vector<engine::Phase> parts_of(const scene::Simulation::Seconds& s) {
  return {{"fluid", s.fluid.wall, s.fluid.cpu},
          {"coupling", s.coupling.wall, s.coupling.cpu},
          {"solid", s.solid.wall, s.solid.cpu}};
}

}  // namespace veriflex::measures
