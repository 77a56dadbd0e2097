#include "measures/coupling/immersed.hpp"

#include <fmt/format.h>

#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"

namespace veriflex::measures {

namespace immersed {

fluid::Spec read_fluid(const io::Table& top) {
  const io::Table table = top.table("fluid");
  for (const char* key : {"body_force", "force_scheme", "walls_x", "walls_y", "walls_z", "obstacle"}) {
    if (table.has(key)) {
      table.fail(key, fmt::format("'{}' is set", key), "the flow lays its own periodic box and force",
                 "Leave it out");
    }
  }
  return engine::read_fluid(top, engine::Varied::Nodes);
}

scene::Forcing read_forcing(const io::Table& top, Volume volume) {
  const scene::CouplingSpec spec = engine::read_coupling(top);
  if (top.has("coupling")) {
    const io::Table table = top.table("coupling");
    for (const char* key : {"nodes", "subcycled"}) {
      if (table.has(key)) {
        table.fail(key, fmt::format("'{}' is set", key), "the motion of these markers is given",
                   "Leave it out");
      }
    }
    if (volume == Volume::OfSurface && table.has("marker_volume")) {
      table.fail("marker_volume", "'marker_volume' is set",
                 "a marker stands for its share of the surface times h", "Leave it out");
    }
  }
  return {spec.delta, spec.marker_volume, spec.forcing_iterations};
}

double read_positive(const io::Table& t, const std::string& key, double otherwise) {
  return engine::need_positive(t, key, t.number(key, otherwise),
                               fmt::format("Give for example {}", otherwise));
}

std::vector<std::int64_t> read_rising(const io::Table& t, const std::string& key, std::int64_t min,
                                      std::int64_t max) {
  const std::vector<std::int64_t> values = t.integers(key);
  std::int64_t before = min - 1;
  for (const std::int64_t value : values) {
    if (value <= before || value > max) {
      t.fail(key, fmt::format("'{}' holds {}", key, value),
             fmt::format("they must rise and lie between {} and {}", min, max), "Correct the list");
    }
    before = value;
  }
  if (values.size() < 2) t.fail(key, "fewer than two", "a comparison needs two", "Give two or more");
  return values;
}

}  // namespace immersed

engine::Study read_immersed(const io::Table& top) {
  const std::string flow = top.table("immersed").choice("flow", {"array", "plate", "rod"});
  if (flow == "array") return immersed::read_array(top);
  if (flow == "plate") return immersed::read_plate(top);
  return immersed::read_rod(top);
}

}  // namespace veriflex::measures
