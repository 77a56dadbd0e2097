/// What the flows of the driver `channel` share; each flow stands in a file of its own.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "base/reduce.hpp"
#include "engine/study.hpp"
#include "fluid/obstacle.hpp"
#include "io/document.hpp"
#include "measures/at_once.hpp"
#include "measures/fluid/run_fluid.hpp"

namespace veriflex::measures::channel {

struct Common {
  fluid::Spec fluid;                      // walls, box and force are the flow's
  std::vector<std::int64_t> resolutions;  // nodes across, rising
  observe::MonitorSpec monitor;
};

Common read_common(const io::Table& top);

/// [channel] `velocity` at the first resolution; it falls as 1/nodes  [L T^-1].
double read_velocity(const io::Table& t, const Common& common);

/// `steady_change` and `step_limit`. `change` is the default with populations in double; what their storage
/// cannot meet is refused.
Steady read_steady(const io::Table& t, double change, fluid::Storage storage);

/// At which the slowest mode across a gap, or what never meets a wall, comes to rest  [T^-1].
double slowest_rate(double relaxation_time, double width);

/// Refuses at `step_limit` a flow, named in the message, that comes to rest too slowly for it.
void require_in_reach(const io::Table& t, const Steady& steady, double rate, const std::string& flow);

/// Nodes along an axis along which nothing varies.
constexpr std::int64_t breadth = 4;

/// A gap of `nodes` between plates across `normal`; flow goes along the next axis.
fluid::Spec gap(const fluid::Spec& base, std::size_t normal, std::int64_t nodes);
constexpr std::size_t along(std::size_t normal) { return (normal + 1) % 3; }

/// From the lower wall, half a spacing before the first node  [L].
inline double from_wall(std::int64_t node) { return static_cast<double>(node) + 0.5; }

struct Norms {
  double l1, l2, linf;  // relative to the same norm of the exact values
};
Norms error_norms(std::span<const double> measured, std::span<const double> exact);

/// Inserts a row where the others have the same order in the first column, rising or falling.
enum class Order { Rising, Falling };
void insert(observe::Record& record, Order order, std::span<const double> row);

/// Adds a row to record `convergence` (1/nodes, error_l1, error_l2, error_linf) as soon as it is known; the
/// rows stand in the order of the resolutions in whichever order they are added.
void add_errors(observe::Observations& seen, std::int64_t nodes, const Norms& errors);

/// The metrics order_l1, order_l2, order_linf of the last two rows of record `convergence`, error_l2 and
/// error_linf of the last.
void add_convergence(observe::Observations& seen);
std::vector<std::string> convergence_measures();

engine::Study read_poiseuille(const io::Table& top);
engine::Study read_couette(const io::Table& top);
engine::Study read_duct(const io::Table& top);
engine::Study read_womersley(const io::Table& top);
engine::Study read_array(const io::Table& top);

}  // namespace veriflex::measures::channel
