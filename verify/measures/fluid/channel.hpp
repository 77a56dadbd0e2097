/// What the flows of the driver `channel` share; each flow stands in a file of its own.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/read_scene.hpp"
#include "engine/study.hpp"
#include "measures/fluid/norms.hpp"
#include "measures/fluid/steady.hpp"

namespace veriflex::measures::channel {

struct Common {
  fluid::Spec fluid;   // walls, box and force are the flow's
  std::int64_t nodes;  // across
  std::size_t axis;    // across the plates, or along the duct
  double velocity;     // [L T^-1]
  observe::MonitorSpec monitor;
};

/// `nodes`, `axis` (which has a default) and `velocity` of [channel], and [fluid] without walls and forces.
Common read_common(const io::Table& top, const std::string& axis);

/// `nodes` of [channel]: across the flow.
std::int64_t read_nodes(const io::Table& t);

/// `steady_change` and `step_limit`. `change` is the default with populations in double; what their storage
/// cannot meet is refused, as is a flow, named in the message, that comes to rest more slowly than the limit
/// of steps allows.
Steady read_steady(const io::Table& t, double change, const fluid::Spec& fluid, double slowest_width,
                   const std::string& flow);

/// By how much a step the slowest motion across a gap of that width decays, or what never meets a wall.
double slowest_rate(const fluid::Spec& fluid, double width);

/// Nodes along an axis along which nothing varies.
constexpr std::int64_t breadth = 4;

/// Between plates across common.axis; flow goes along the next axis.
fluid::Spec gap(const Common& common);
constexpr std::size_t along(std::size_t normal) { return (normal + 1) % 3; }

/// From the lower wall, half a spacing before the first node  [L].
inline double from_wall(std::int64_t node) { return static_cast<double>(node) + 0.5; }

/// The component along `axis` of velocities.
std::vector<double> component(const Positions& velocities, std::size_t axis);

engine::Study read_poiseuille(const io::Table& top);
engine::Study read_couette(const io::Table& top);
engine::Study read_duct(const io::Table& top);
engine::Study read_womersley(const io::Table& top);
engine::Study read_array(const io::Table& top);

}  // namespace veriflex::measures::channel
