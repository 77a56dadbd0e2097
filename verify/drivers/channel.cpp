#include "drivers/channel.hpp"

#include <fmt/format.h>

#include <cmath>

#include "drivers/drivers.hpp"
#include "engine/read_scene.hpp"

namespace veriflex::drivers {

namespace channel {

namespace {

constexpr std::int64_t most_across = 4096;

std::vector<std::int64_t> read_resolutions(const io::Section& t) {
  const std::vector<std::int64_t> nodes = t.integers("resolutions");
  if (nodes.size() < 2 || nodes.front() < 2 || nodes.back() > most_across) {
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

Common read_common(const io::Section& top) {
  const io::Section table = top.table("fluid");
  Common common{engine::read_fluid(top, engine::Varied::Nodes), read_resolutions(top.table("channel")),
                engine::read_watch(top)};
  for (const char* key : {"body_force", "walls_x", "walls_y", "walls_z", "obstacle"}) {
    if (table.has(key)) {
      table.fail(key, fmt::format("'{}' is set", key),
                 "walls and forces are the flow's, on each axis in turn", "Leave it out");
    }
  }
  return common;
}

double read_velocity(const io::Section& t) {
  const double velocity = t.number("velocity");
  if (!(velocity > 0.0)) {
    t.fail("velocity", fmt::format("'velocity' is {}", velocity), "nothing would flow",
           "Give for example 0.01");
  }
  return velocity;
}

Steady read_steady(const io::Section& t, double change) {
  const Steady steady{t.number("steady_change", change), t.has("step_limit")
                                                             ? t.integer("step_limit", 100, 1'000'000'000'000)
                                                             : std::int64_t{1'000'000}};
  if (!(steady.change > 0.0)) {
    t.fail("steady_change", fmt::format("'steady_change' is {}", steady.change),
           "round-off never comes to rest", "Give for example 1e-12");
  }
  return steady;
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
  return {error.l1 / size.l1, std::sqrt(error.l2 / size.l2), error.linf / size.linf};
}

void add_convergence(observe::Observations& seen, std::span<const std::int64_t> resolutions,
                     std::span<const Norms> errors) {
  observe::Record record{"convergence",
                         "Error of the velocity against the exact solution",
                         {{"spacing", "", "1", "1/nodes across the flow", {}},
                          {"error_l1", "", "1", "mean error over mean velocity", {}},
                          {"error_l2", "", "1", "root mean square error over that of the velocity", {}},
                          {"error_linf", "", "1", "largest error over largest velocity", {}}}};
  for (std::size_t i = 0; i < resolutions.size(); ++i) {
    record.append({1.0 / static_cast<double>(resolutions[i]), errors[i].l1, errors[i].l2, errors[i].linf});
  }
  seen.records.push_back(record);
  const std::size_t last = resolutions.size() - 1;
  const double refined =
      std::log(static_cast<double>(resolutions[last]) / static_cast<double>(resolutions[last - 1]));
  const auto order = [refined](double coarse, double fine) { return std::log(coarse / fine) / refined; };
  const Norms& coarse = errors[last - 1];
  const Norms& fine = errors[last];
  seen.metrics.push_back({"order_l1", order(coarse.l1, fine.l1), "1", "order in the spacing, last two rows"});
  seen.metrics.push_back({"order_l2", order(coarse.l2, fine.l2), "1", "order in the spacing, last two rows"});
  seen.metrics.push_back(
      {"order_linf", order(coarse.linf, fine.linf), "1", "order in the spacing, last two rows"});
  seen.metrics.push_back({"error_l2", fine.l2, "1", "of the finest resolution"});
  seen.metrics.push_back({"error_linf", fine.linf, "1", "of the finest resolution"});
}

std::vector<std::string> convergence_measures() {
  return {"order_l1", "order_l2", "order_linf", "error_l2", "error_linf"};
}

engine::Study study_of(const io::Section& top, const fluid::Spec& largest, std::vector<std::string> measures,
                       std::function<void(observe::Observations&, Progress&, engine::Cost&)> run) {
  return {.plan = engine::read_plan(top, {.fluid = largest}),
          .measures = std::move(measures),
          .run = std::move(run)};
}

}  // namespace channel

engine::Study read_channel(const io::Section& top) {
  const std::string flow =
      top.table("channel").choice("flow", {"poiseuille", "couette", "duct", "womersley", "array"});
  if (flow == "poiseuille") return channel::read_poiseuille(top);
  if (flow == "couette") return channel::read_couette(top);
  if (flow == "duct") return channel::read_duct(top);
  if (flow == "womersley") return channel::read_womersley(top);
  return channel::read_array(top);
}

}  // namespace veriflex::drivers
