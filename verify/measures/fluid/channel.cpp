#include "measures/fluid/channel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>

#include "engine/convergence.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"

namespace veriflex::measures {

namespace channel {

namespace {

constexpr std::int64_t max_across = 4096;
constexpr double min_velocity = 1e-30;  // its square and that of its rounding are still numbers in float

/// The least change per step that is asked for: a few roundings of the velocity over 100 steps.
double steady_within_reach(fluid::Storage storage) { return 4.0 * min_change(storage); }

std::vector<std::int64_t> read_resolutions(const io::Table& t) {
  const std::vector<std::int64_t> nodes = t.integers("resolutions");
  if (nodes.size() < 2 || nodes.front() < 2 || nodes.back() > max_across) {
    t.fail("resolutions", "fewer than two, or not between 2 and 4096 nodes", "an order needs two of them",
           "Give for example [8, 16, 32]");
  }
  for (std::size_t i = 1; i < nodes.size(); ++i) {
    if (nodes[i] <= nodes[i - 1]) {
      t.fail("resolutions", "they do not rise", "the order is taken between neighbours", "Sort them");
    }
  }
  return nodes;
}

}  // namespace

Common read_common(const io::Table& top) {
  const io::Table table = top.table("fluid");
  Common common{engine::read_fluid(top, engine::Varied::Nodes), read_resolutions(top.table("channel")),
                engine::read_monitor(top)};
  for (const char* key : {"body_force", "walls_x", "walls_y", "walls_z", "obstacle"}) {
    if (table.has(key)) {
      table.fail(key, fmt::format("'{}' is set", key),
                 "walls and forces are the flow's, on each axis in turn", "Leave it out");
    }
  }
  return common;
}

double read_velocity(const io::Table& t, const Common& common) {
  const double velocity = t.number("velocity");
  const double smallest = velocity * static_cast<double>(common.resolutions.front()) /
                          static_cast<double>(common.resolutions.back());
  if (!(velocity > 0.0)) {
    t.fail("velocity", fmt::format("'velocity' is {}", velocity), "nothing would flow",
           "Give for example 0.01");
  }
  if (smallest < min_velocity) {
    t.fail("velocity", fmt::format("'velocity' is {}", velocity),
           fmt::format("below {} at the finest resolution squares are lost to underflow", min_velocity),
           "Give for example 0.01");
  }
  return velocity;
}

Steady read_steady(const io::Table& t, double change, fluid::Storage storage) {
  const double least = steady_within_reach(storage);
  const Steady steady{
      t.number("steady_change", std::max(change, least)),
      t.has("step_limit") ? t.integer("step_limit", 100, 1'000'000'000'000) : std::int64_t{1'000'000}};
  if (!(steady.change >= least)) {
    t.fail("steady_change", fmt::format("'steady_change' is {}", steady.change),
           fmt::format("rounding alone changes velocities of populations in {} by up to {:.2g} a step, mean "
                       "over 100, and never comes to rest",
                       row_of(fluid::storages, storage).name, least),
           fmt::format("Give at least {:.2g}", least));
  }
  return steady;
}

double slowest_rate(double relaxation_time, double width) {
  const double pi = std::numbers::pi;
  return std::min(pi * pi * fluid::viscosity(relaxation_time) / (width * width), 1.0 / relaxation_time);
}

void require_in_reach(const io::Table& t, const Steady& steady, double rate, const std::string& flow) {
  // The change per step is rate exp(-rate t). Half of that time, since amplitudes are known roughly only.
  const double steps = 0.5 * std::log(std::max(1.0, rate / steady.change)) / rate;
  if (steps <= static_cast<double>(steady.step_limit)) return;
  t.fail(t.has("step_limit") ? "step_limit" : "resolutions",
         fmt::format("{} needs more than {:.3g} steps to become steady", flow, steps),
         fmt::format("the limit is {}", steady.step_limit),
         "Raise step_limit or steady_change, or use fewer nodes or another relaxation time");
}

fluid::Spec gap(const fluid::Spec& base, std::size_t normal, std::int64_t nodes) {
  fluid::Spec spec = base;
  spec.grid.size = {breadth, breadth, breadth};
  spec.grid.size[normal] = nodes;
  spec.walls[normal] = fluid::Walls{};
  return spec;
}

Norms error_norms(std::span<const double> measured, std::span<const double> exact) {
  Norms error{0.0, 0.0, 0.0};
  Norms size{0.0, 0.0, 0.0};
  const auto add = [](Norms& to, double value) {
    to.l1 += std::abs(value);
    to.l2 += value * value;
    to.linf = worse(to.linf, std::abs(value));
  };
  for (std::size_t i = 0; i < exact.size(); ++i) {
    add(error, measured[i] - exact[i]);
    add(size, exact[i]);
  }
  return {relative_to(error.l1, size.l1), relative_to(std::sqrt(error.l2), std::sqrt(size.l2)),
          relative_to(error.linf, size.linf)};
}

void insert(observe::Record& record, Order order, std::span<const double> row) {
  const std::vector<double>& first = record.columns.front().values;
  const auto place =
      std::find_if(first.begin(), first.end(),
                   [&](double value) { return order == Order::Rising ? value > row[0] : value < row[0]; }) -
      first.begin();
  for (std::size_t i = 0; i < row.size(); ++i) {
    std::vector<double>& values = record.columns[i].values;
    values.insert(values.begin() + place, row[i]);
  }
}

void add_errors(observe::Observations& seen, std::int64_t nodes, const Norms& errors) {
  auto record = std::find_if(seen.records.begin(), seen.records.end(),
                             [](const observe::Record& r) { return r.name == "convergence"; });
  if (record == seen.records.end()) {
    seen.records.push_back({"convergence",
                            "Error of the velocity against the exact solution",
                            {{"spacing", "", "1", "1/nodes across the flow", {}},
                             {"error_l1", "", "1", "mean error over mean velocity", {}},
                             {"error_l2", "", "1", "root mean square error over that of the velocity", {}},
                             {"error_linf", "", "1", "largest error over largest velocity", {}}}});
    record = std::prev(seen.records.end());
  }
  insert(*record, Order::Falling,
         std::array{1.0 / static_cast<double>(nodes), errors.l1, errors.l2, errors.linf});
}

void add_convergence(observe::Observations& seen) {
  const observe::Record& record = *seen.record("convergence");
  const std::vector<double>& spacing = record.columns.front().values;
  for (const std::string norm : {"l1", "l2", "linf"}) {
    const std::vector<double>& error = record.find("error_" + norm)->values;
    seen.metrics.push_back(
        {"order_" + norm, engine::orders(spacing, error).back(), "1", "order in the spacing, last two rows"});
  }
  for (const char* error : {"error_l2", "error_linf"})
    seen.metrics.push_back({error, record.find(error)->values.back(), "1", "of the finest resolution"});
}

std::vector<std::string> convergence_measures() {
  return {"order_l1", "order_l2", "order_linf", "error_l2", "error_linf"};
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
