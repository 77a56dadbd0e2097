/// What the flows of the driver `channel` share; each flow stands in a file of its own.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "base/reduce.hpp"
#include "drivers/march.hpp"
#include "engine/study.hpp"
#include "fluid/obstacle.hpp"
#include "io/document.hpp"

namespace veriflex::drivers::channel {

struct Common {
  fluid::Spec fluid;                      // walls, box and force are the flow's
  std::vector<std::int64_t> resolutions;  // nodes across, rising
  observe::Watch watch;
};

Common read_common(const io::Section& top);
double read_velocity(const io::Section& t);  // [channel] velocity, nonzero  [L T^-1]
Steady read_steady(const io::Section& t, double change);

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

/// Record `convergence` (1/nodes, error_l1, error_l2, error_linf) and the metrics order_l1, order_l2,
/// order_linf of its last two rows, error_l2 and error_linf of the last.
void add_convergence(observe::Observations& seen, std::span<const std::int64_t> resolutions,
                     std::span<const Norms> errors);
std::vector<std::string> convergence_measures();

/// A box across which `nodes` stand, for the plan.
engine::Study study_of(const io::Section& top, const fluid::Spec& largest, std::vector<std::string> measures,
                       std::function<void(observe::Observations&, Progress&, engine::Cost&)> run);

engine::Study read_poiseuille(const io::Section& top);
engine::Study read_couette(const io::Section& top);
engine::Study read_duct(const io::Section& top);
engine::Study read_womersley(const io::Section& top);
engine::Study read_array(const io::Section& top);

}  // namespace veriflex::drivers::channel
