#include <fmt/format.h>

#include <cmath>

#include "analytic/channel.hpp"
#include "measures/fluid/channel.hpp"
#include "observe/field.hpp"

namespace veriflex::measures::channel {

namespace {

using observe::Observations;
using observe::Record;

struct Duct {
  Common common;  // velocity: on the axis; axis: along the duct
  Steady steady;

  double viscosity() const { return fluid::viscosity(common.fluid.relaxation_time); }
  double width() const { return static_cast<double>(common.nodes); }
  double force() const {
    return viscosity() * common.velocity / analytic::square_duct(0.5 * width(), 0.5 * width(), width());
  }
};

fluid::Spec spec_of(const Duct& study) {
  fluid::Spec spec = study.common.fluid;
  const std::size_t flow = study.common.axis;
  spec.grid.size = {study.common.nodes, study.common.nodes, study.common.nodes};
  spec.grid.size[flow] = breadth;
  spec.walls[along(flow)] = fluid::Walls{};
  spec.walls[along(along(flow))] = fluid::Walls{};
  spec.body_force[static_cast<Eigen::Index>(flow)] = study.force();
  return spec;
}

Record steady_state(const Duct& study, Progress& progress) {
  const fluid::Spec spec = spec_of(study);
  const std::vector<std::int64_t> nodes = observe::plane(spec.grid, study.common.axis, 0);
  const scene::Simulation end = run_to_steady(spec, nodes, study.steady, study.common.monitor, progress);
  return observe::at_nodes(end.fluid(), nodes, {.velocity = true}, "plane", "");
}

/// Fills the record `section`, one row per node in the order of the plane: velocity over that of the exact
/// solution on the axis; y and z are the two axes after the duct's. Returns the largest velocity across.
double fill_section(const Duct& study, const Record& plane, Record& section) {
  constexpr const char* axes[] = {"x", "y", "z"};
  constexpr const char* components[] = {"velocity_x", "velocity_y", "velocity_z"};
  const std::size_t flow = study.common.axis, a = along(flow), b = along(a);
  const double top = study.common.velocity, g = study.force();
  const auto value = [&](const char* column, std::size_t i) { return plane.find(column)->values[i]; };
  double across = 0.0;
  for (std::size_t i = 0; i < plane.columns.front().values.size(); ++i) {
    const double y = value(axes[a], i) + 0.5, z = value(axes[b], i) + 0.5;
    section.append({y / study.width(), z / study.width(), (value(components[flow], i) + 0.5 * g) / top,
                    g / study.viscosity() * analytic::square_duct(y, z, study.width()) / top});
    across = worse(across, std::hypot(value(components[a], i), value(components[b], i)) / top);
  }
  return across;
}

/// Along y in the middle and beside the wall.
void fill_profile(const Duct& study, const Record& section, Record& profile) {
  const auto at = [&](const char* column, std::size_t i) { return section.find(column)->values[i]; };
  // The plane's nodes have x fastest, which is the second of the two axes where the duct is along y.
  const auto nodes = static_cast<std::size_t>(study.common.nodes);
  const bool is_along_y = study.common.axis == 1;
  for (std::size_t a = 0; a < nodes; ++a) {
    const std::size_t middle = is_along_y ? nodes / 2 + nodes * a : a + nodes * (nodes / 2);
    const std::size_t wall = is_along_y ? nodes * a : a;
    profile.append({at("y", middle), at("velocity", middle), at("velocity_exact", middle),
                    at("velocity", wall), at("velocity_exact", wall)});
  }
}

/// Q nu/(g a^4) by the mean of the nodes, each of which stands in the middle of its square.
double flow_rate(const Duct& study, const std::vector<double>& velocity) {
  double sum = 0.0;
  for (const double u : velocity) sum += u;
  const double square = study.width() * study.width();
  const double mean = sum / square * study.common.velocity;
  return mean * study.viscosity() / (study.force() * square);
}

void run_duct(const Duct& study, Observations& seen, Progress& progress) {
  Record& section = seen.open("section");
  const double across = fill_section(study, steady_state(study, progress), section);
  fill_profile(study, section, seen.open("profile"));
  const std::vector<double>& velocity = section.find("velocity")->values;
  set_norms(seen, "", error_norms(velocity, section.find("velocity_exact")->values));
  seen.set("flow_rate", flow_rate(study, velocity));
  seen.set("cross_flow", across);
}

Observations duct_observations() {
  Observations all;
  all.metrics = norm_metrics("", "the velocity");
  all.metrics.push_back({"flow_rate", {}, "1", "flux times viscosity over g a^4, by the mean of the nodes"});
  all.metrics.push_back({"cross_flow", {}, "1", "largest velocity across the duct over that on its axis"});
  all.records = {{"profile",
                  "Velocity across the duct, in the middle and beside a wall",
                  {{"position", "y/a", "1", "from wall to wall", {}},
                   {"middle", "", "1", "over the exact velocity on the axis", {}},
                   {"middle_exact", "", "1", "series", {}},
                   {"beside_wall", "", "1", "over the exact velocity on the axis", {}},
                   {"beside_wall_exact", "", "1", "series", {}}}},
                 {"section",
                  "Velocity in a section of the duct",
                  {{"y", "y/a", "1", "from wall to wall", {}},
                   {"z", "z/a", "1", "from wall to wall", {}},
                   {"velocity", "u/U", "1", "sum f c + g/2, over the exact velocity on the axis", {}},
                   {"velocity_exact", "", "1", "series", {}}}}};
  return all;
}

}  // namespace

engine::Study read_duct(const io::Table& top) {
  const Common common = read_common(top, "z");
  const Duct study{
      .common = common,
      .steady = read_steady(top.table("channel"), 1e-12, common.fluid, static_cast<double>(common.nodes),
                            fmt::format("a duct of {} nodes", common.nodes))};
  // Between two pairs of walls.
  const double rate = 2.0 * slowest_rate(common.fluid, static_cast<double>(common.nodes));
  return study_of(top, {.fluid = spec_of(study)}, duct_observations(), study, run_duct,
                  steps_to_steady(study.steady, rate));
}

}  // namespace veriflex::measures::channel
