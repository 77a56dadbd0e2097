/// What the flows of the driver `immersed` share; each flow stands in a file of its own.
#pragma once

#include <string>
#include <vector>

#include "engine/study.hpp"
#include "io/document.hpp"
#include "observe/check.hpp"
#include "scene/prescribed_body.hpp"

namespace veriflex::measures::immersed {

/// [fluid] of a flow that lays its own periodic box and force.
fluid::Spec read_fluid(const io::Table& top);

/// Whether the case may give the markers' volume, or each stands for its share of a surface times h.
enum class Volume { Given, OfSurface };

/// [coupling] of markers whose motion is given.
scene::Forcing read_forcing(const io::Table& top, Volume volume);

/// More than 0.
double read_positive(const io::Table& t, const std::string& key, double otherwise);

/// Rising, between the bounds.
std::vector<std::int64_t> read_rising(const io::Table& t, const std::string& key, std::int64_t min,
                                      std::int64_t max);

engine::Study read_array(const io::Table& top);
engine::Study read_plate(const io::Table& top);
engine::Study read_rod(const io::Table& top);

}  // namespace veriflex::measures::immersed
