#include "measures/fluid/channel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "measures/drivers.hpp"

namespace veriflex::measures {

namespace channel {

namespace {

constexpr std::int64_t max_across = 4096;
constexpr double min_velocity = 1e-30;  // its square and that of its rounding are still numbers in float

/// The least change per step that is asked for: a few roundings of the velocity over 100 steps.
double steady_within_reach(fluid::Storage storage) { return 4.0 * min_change(storage); }

double read_velocity(const io::Table& t) {
  const double velocity = t.number("velocity");
  if (!(velocity > 0.0)) {
    t.fail("velocity", fmt::format("'velocity' is {}", velocity), "nothing would flow",
           "Give for example 0.01");
  }
  if (velocity < min_velocity) {
    t.fail("velocity", fmt::format("'velocity' is {}", velocity),
           fmt::format("below {} squares are lost to underflow", min_velocity), "Give for example 0.01");
  }
  return velocity;
}

}  // namespace

std::int64_t read_nodes(const io::Table& t) { return t.integer("nodes", 2, max_across); }

Common read_common(const io::Table& top, const std::string& axis) {
  const io::Table table = top.table("fluid");
  const io::Table t = top.table("channel");
  const int given = t.has("axis") ? engine::read_axis(t) : axis[0] - 'x';
  Common common{.fluid = engine::read_fluid(top, engine::Varied::Nodes),
                .nodes = read_nodes(t),
                .axis = static_cast<std::size_t>(given),
                .velocity = read_velocity(t),
                .monitor = engine::read_monitor(top)};
  for (const char* key : {"body_force", "walls_x", "walls_y", "walls_z", "obstacle"}) {
    if (table.has(key))
      table.fail(key, fmt::format("'{}' is set", key), "walls and forces are the flow's", "Leave it out");
  }
  return common;
}

double slowest_rate(const fluid::Spec& fluid, double width) {
  const double pi = std::numbers::pi;
  return std::min(pi * pi * fluid::viscosity(fluid.relaxation_time) / (width * width),
                  1.0 / fluid.relaxation_time);
}

Steady read_steady(const io::Table& t, double change, const fluid::Spec& fluid, double slowest_width,
                   const std::string& flow) {
  const double least = steady_within_reach(fluid.storage);
  const Steady steady{
      t.number("steady_change", std::max(change, least)),
      t.has("step_limit") ? t.integer("step_limit", 100, 1'000'000'000'000) : std::int64_t{1'000'000}};
  if (!(steady.change >= least)) {
    t.fail("steady_change", fmt::format("'steady_change' is {}", steady.change),
           fmt::format("rounding alone changes velocities of populations in {} by up to {:.2g} a step, mean "
                       "over 100, and never comes to rest",
                       row_of(fluid::storages, fluid.storage).name, least),
           fmt::format("Give at least {:.2g}", least));
  }
  // The change per step is rate exp(-rate t); half of that time, since amplitudes are known roughly only.
  const double rate = slowest_rate(fluid, slowest_width);
  const double steps = 0.5 * std::log(std::max(1.0, rate / steady.change)) / rate;
  if (steps > static_cast<double>(steady.step_limit)) {
    t.fail(t.has("step_limit") ? "step_limit" : "nodes",
           fmt::format("{} needs more than {:.3g} steps to become steady", flow, steps),
           fmt::format("the limit is {}", steady.step_limit),
           "Raise step_limit or steady_change, or use fewer nodes or another relaxation time");
  }
  return steady;
}

fluid::Spec gap(const Common& common) {
  fluid::Spec spec = common.fluid;
  spec.grid.size = {breadth, breadth, breadth};
  spec.grid.size[common.axis] = common.nodes;
  spec.grid.size[along(along(common.axis))] = 1;  // one thread's work where the walls stand across x
  spec.walls[common.axis] = fluid::Walls{};
  return spec;
}

std::vector<double> component(const Positions& velocities, std::size_t axis) {
  const auto column = velocities.col(static_cast<Eigen::Index>(axis));
  return {column.begin(), column.end()};
}

}  // namespace channel

engine::Study read_channel(const io::Table& top) {
  const std::string flow =
      top.table("channel").choice("flow", {"poiseuille", "couette", "duct", "womersley", "array"});
  if (flow == "poiseuille") return channel::read_poiseuille(top);
  if (flow == "couette") return channel::read_couette(top);
  if (flow == "duct") return channel::read_duct(top);
  if (flow == "womersley") return channel::read_womersley(top);
  return channel::read_array(top);
}

}  // namespace veriflex::measures
