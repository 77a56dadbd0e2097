#include <fmt/format.h>

#include <cmath>

#include "analytic/channel.hpp"
#include "measures/fluid/channel.hpp"
#include "measures/for_all.hpp"
#include "observe/field.hpp"

namespace veriflex::measures::channel {

namespace {

using observe::Observations;
using observe::Record;

struct Duct {
  Common common;
  Steady steady;
  double velocity;  // on the axis at the first resolution  [L T^-1]
};

struct Piece {
  std::size_t flow;    // axis along the duct
  std::int64_t nodes;  // across
};

/// On the axis of the duct; falls as 1/nodes, so that the Reynolds number stays.
double top_velocity(const Duct& study, std::int64_t nodes) {
  return study.velocity * static_cast<double>(study.common.resolutions.front()) / static_cast<double>(nodes);
}

double force_of(const Duct& study, std::int64_t nodes) {
  const auto width = static_cast<double>(nodes);
  return fluid::viscosity(study.common.fluid.relaxation_time) * top_velocity(study, nodes) /
         analytic::square_duct(0.5 * width, 0.5 * width, width);
}

fluid::Spec spec_of(const Duct& study, const Piece& piece) {
  fluid::Spec spec = study.common.fluid;
  spec.grid.size = {piece.nodes, piece.nodes, piece.nodes};
  spec.grid.size[piece.flow] = breadth;
  spec.walls[along(piece.flow)] = fluid::Walls{};
  spec.walls[along(along(piece.flow))] = fluid::Walls{};
  spec.body_force[static_cast<Eigen::Index>(piece.flow)] = force_of(study, piece.nodes);
  return spec;
}

/// Velocity over that of the exact solution on the axis, one row per node of the section; the columns are
/// along the duct and the two axes after it.
struct Section {
  std::vector<double> y, z, velocity, exact;
  double cross_flow;  // largest
};

Section section_of(const Duct& study, const Piece& piece, const Record& plane) {
  constexpr const char* axes[] = {"x", "y", "z"};
  constexpr const char* components[] = {"velocity_x", "velocity_y", "velocity_z"};
  const std::size_t a = along(piece.flow), b = along(a);
  const auto width = static_cast<double>(piece.nodes);
  const double top = top_velocity(study, piece.nodes);
  const double g = force_of(study, piece.nodes);
  const double nu = fluid::viscosity(study.common.fluid.relaxation_time);
  const auto value = [&](const char* column, std::size_t i) { return plane.find(column)->values[i]; };
  Section section{{}, {}, {}, {}, 0.0};
  for (std::size_t i = 0; i < plane.columns.front().values.size(); ++i) {
    const double y = value(axes[a], i) + 0.5, z = value(axes[b], i) + 0.5;
    section.y.push_back(y / width);
    section.z.push_back(z / width);
    section.velocity.push_back((value(components[piece.flow], i) + 0.5 * g) / top);
    section.exact.push_back(g / nu * analytic::square_duct(y, z, width) / top);
    const double cross = std::hypot(value(components[a], i), value(components[b], i)) / top;
    section.cross_flow = worse(section.cross_flow, cross);
  }
  return section;
}

Section steady_state(const Duct& study, const Piece& piece) {
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(spec_of(study, piece));
  const std::vector<std::int64_t> nodes = observe::plane(fluid->spec().grid, piece.flow, 0);
  run_to_steady(*fluid, nodes, study.steady, study.common.monitor);
  return section_of(study, piece, observe::at_nodes(*fluid, nodes, {.velocity = true}, "plane", ""));
}

/// Nodes of a section stand in another order for each axis: z fastest where the duct is along y.
double velocity_at(const Section& section, std::int64_t nodes, std::size_t flow, std::int64_t a,
                   std::int64_t b) {
  const std::int64_t place = flow == 1 ? b + nodes * a : a + nodes * b;
  return section.velocity[static_cast<std::size_t>(place)];
}

double axis_difference(const std::vector<Section>& sections, std::int64_t nodes) {
  double worst = 0.0;
  for (std::int64_t b = 0; b < nodes; ++b) {
    for (std::int64_t a = 0; a < nodes; ++a) {
      const double along_z = velocity_at(sections[2], nodes, 2, a, b);
      for (const std::size_t flow : {0U, 1U}) {
        worst = worse(worst, std::abs(velocity_at(sections[flow], nodes, flow, a, b) - along_z));
      }
    }
  }
  return worst;
}

Record section_record(const Section& section) {
  return {"section",
          "Velocity in a section of the duct",
          {{"y", "y/a", "1", "from wall to wall", section.y},
           {"z", "z/a", "1", "from wall to wall", section.z},
           {"velocity", "u/U", "1", "sum f c + g/2, over the exact velocity on the axis", section.velocity},
           {"velocity_exact", "", "1", "series", section.exact}}};
}

/// Along y beside the middle and beside the wall.
Record profile_record(const Section& section, std::int64_t nodes) {
  Record profile{"profile",
                 "Velocity across the duct, in the middle and beside a wall",
                 {{"position", "y/a", "1", "from wall to wall", {}},
                  {"middle", "", "1", "over the exact velocity on the axis", {}},
                  {"middle_exact", "", "1", "series", {}},
                  {"beside_wall", "", "1", "over the exact velocity on the axis", {}},
                  {"beside_wall_exact", "", "1", "series", {}}}};
  for (std::int64_t a = 0; a < nodes; ++a) {
    const auto middle = static_cast<std::size_t>(a + nodes * (nodes / 2));
    const auto wall = static_cast<std::size_t>(a);
    profile.append({section.y[middle], section.velocity[middle], section.exact[middle],
                    section.velocity[wall], section.exact[wall]});
  }
  return profile;
}

std::vector<Piece> pieces_of(const Duct& study) {
  const std::vector<std::int64_t>& resolutions = study.common.resolutions;
  std::vector<Piece> pieces;  // the finest first: it takes longest
  for (auto nodes = resolutions.rbegin(); nodes != resolutions.rend(); ++nodes) pieces.push_back({2, *nodes});
  for (const std::size_t flow : {0U, 1U}) pieces.push_back({flow, resolutions.front()});
  return pieces;
}

/// Q nu/(g a^4) by the mean of the nodes, each of which stands in the middle of its square.
double flow_rate(const Duct& study, const Section& section, std::int64_t nodes) {
  double sum = 0.0;
  for (const double velocity : section.velocity) sum += velocity;
  const auto width = static_cast<double>(nodes);
  const double mean = sum / (width * width) * top_velocity(study, nodes);
  const double nu = fluid::viscosity(study.common.fluid.relaxation_time);
  return mean * nu / (force_of(study, nodes) * width * width);
}

void run(const Duct& study, Observations& seen, Progress& progress) {
  const std::vector<std::int64_t>& resolutions = study.common.resolutions;
  const std::size_t coarsest = resolutions.size() - 1;
  const std::vector<Piece> pieces = pieces_of(study);
  std::vector<Section> sections(pieces.size());
  for_all(
      pieces.size(), "ducts", progress, [&](std::size_t i) { sections[i] = steady_state(study, pieces[i]); },
      [&](std::size_t i) {
        if (i == 0) {
          seen.records.push_back(profile_record(sections[i], pieces[i].nodes));
          seen.records.push_back(section_record(sections[i]));
        }
        if (i <= coarsest)
          add_errors(seen, pieces[i].nodes, error_norms(sections[i].velocity, sections[i].exact));
      });

  add_convergence(seen);
  seen.metrics.push_back({"flow_rate", flow_rate(study, sections.front(), resolutions.back()), "1",
                          "flux times viscosity over g a^4, mean of the nodes of the finest resolution"});
  seen.metrics.push_back(
      {"axis_difference",
       axis_difference({sections[coarsest + 1], sections[coarsest + 2], sections[coarsest]},
                       resolutions.front()),
       "1", "duct along x or y against z, over the top velocity, first resolution"});
  seen.metrics.push_back({"cross_flow", sections[coarsest].cross_flow, "1",
                          "largest velocity across the duct over the top velocity, first resolution"});
}

}  // namespace

engine::Study read_duct(const io::Table& top) {
  const io::Table t = top.table("channel");
  const Common common = read_common(top);
  const Duct study{.common = common,
                   .steady = read_steady(t, 1e-12, common.fluid.storage),
                   .velocity = read_velocity(t, common)};
  const double rate =
      slowest_rate(common.fluid.relaxation_time, static_cast<double>(common.resolutions.back()));
  require_in_reach(t, study.steady, rate, fmt::format("a duct of {} nodes", common.resolutions.back()));
  std::vector<std::string> measures = convergence_measures();
  measures.insert(measures.end(),
                  {"axis_difference", "cross_flow", "flow_rate", "profile.middle", "profile.beside_wall"});
  std::vector<fluid::Spec> runs;
  for (const Piece& piece : pieces_of(study)) runs.push_back(spec_of(study, piece));
  return {
      .plan = plan_at_once(top, runs),
      .measures = measures,
      .run = [study](Observations& seen, Progress& progress, engine::Cost&) { run(study, seen, progress); }};
}

}  // namespace veriflex::measures::channel
