#include <fmt/format.h>

#include <cmath>

#include "measures/fluid/channel.hpp"
#include "measures/for_all.hpp"
#include "observe/field.hpp"

// Between a plate at rest and a sliding one the velocity is linear, and half-way bounce-back has no slip for
// that: the lattice's own solution is the continuum's.

namespace veriflex::measures::channel {

namespace {

using observe::Observations;
using observe::Record;

struct Couette {
  Common common;
  Steady steady;
  double velocity;  // of the high wall along the next axis; half of it along the other  [L T^-1]
};

struct Piece {
  std::size_t normal;
  std::int64_t nodes;
};

Vec3 wall_velocity(const Couette& study, std::size_t normal) {
  Vec3 u = Vec3::Zero();
  u[static_cast<Eigen::Index>(along(normal))] = study.velocity;
  u[static_cast<Eigen::Index>(along(along(normal)))] = 0.5 * study.velocity;
  return u;
}

struct Errors {
  double velocity, stress, density;
};

constexpr const char* velocity_names[] = {"velocity_x", "velocity_y", "velocity_z"};
constexpr const char* stress_names[3][3] = {{"stress_xx", "stress_xy", "stress_xz"},
                                            {"stress_xy", "stress_yy", "stress_yz"},
                                            {"stress_xz", "stress_yz", "stress_zz"}};

fluid::Spec spec_of(const Couette& study, const Piece& piece) {
  fluid::Spec spec = gap(study.common.fluid, piece.normal, piece.nodes);
  spec.walls[piece.normal]->high_velocity = wall_velocity(study, piece.normal);
  return spec;
}

Record steady_state(const Couette& study, const Piece& piece) {
  const fluid::Spec spec = spec_of(study, piece);
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(spec);
  const std::vector<std::int64_t> nodes = observe::line(spec.grid, piece.normal, {0, 0, 0});
  run_to_steady(*fluid, nodes, study.steady, study.common.monitor);
  return observe::at_nodes(*fluid, nodes, {.density = true, .velocity = true, .stress = true}, "state", "");
}

/// Relative to the wall's velocity, to the exact shear stress and to the density.
Errors errors_of(const Couette& study, const Piece& piece, const Record& state) {
  const Vec3 wall = wall_velocity(study, piece.normal);
  const auto height = static_cast<double>(piece.nodes);
  const double nu = fluid::viscosity(study.common.fluid.relaxation_time);
  Errors worst{0.0, 0.0, 0.0};
  for (std::size_t j = 0; j < static_cast<std::size_t>(piece.nodes); ++j) {
    const double share = from_wall(static_cast<std::int64_t>(j)) / height;
    worst.density = worse(worst.density, std::abs(state.find("density")->values[j] - 1.0));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double of_wall = wall[static_cast<Eigen::Index>(axis)];
      const double u = state.find(velocity_names[axis])->values[j];
      worst.velocity = worse(worst.velocity, std::abs(u - share * of_wall) / study.velocity);
      const double shear = state.find(stress_names[piece.normal][axis])->values[j];
      worst.stress =
          worse(worst.stress, std::abs(shear / (nu * study.velocity / height) - of_wall / study.velocity));
    }
  }
  return worst;
}

std::vector<Piece> pieces_of(const Couette& study) {
  std::vector<Piece> pieces;
  for (const std::int64_t nodes : study.common.resolutions) {
    for (const std::size_t normal : {0U, 1U, 2U}) pieces.push_back({normal, nodes});
  }
  return pieces;
}

Record profile_record(const Couette& study, const Record& state) {
  Record profile{"profile",
                 "Velocity between the walls at the coarsest resolution, walls across x",
                 {{"position", "y/H", "1", "from wall to wall", {}},
                  {"velocity", "", "1", "over that of the wall", {}},
                  {"velocity_exact", "", "1", "a straight line", {}}}};
  const std::vector<double>& u = state.find("velocity_y")->values;
  for (std::size_t j = 0; j < u.size(); ++j) {
    const double share = (static_cast<double>(j) + 0.5) / static_cast<double>(u.size());
    profile.append({share, u[j] / study.velocity, share});
  }
  return profile;
}

void run(const Couette& study, Observations& seen, Progress& progress) {
  const std::vector<Piece> pieces = pieces_of(study);
  seen.records.push_back({"couette",
                          "Departure from the linear profile",
                          {{"nodes", "", "1", "between the walls", {}},
                           {"axis", "", "1", "across the walls: 0, 1, 2 are x, y, z", {}},
                           {"velocity_error", "", "1", "largest, over the wall's velocity", {}},
                           {"stress_error", "", "1", "largest, over the shear stress", {}},
                           {"density_error", "", "1", "largest", {}}}});
  std::vector<Record> states(pieces.size());
  Errors worst{0.0, 0.0, 0.0};
  for_all(
      pieces.size(), "walls", progress, [&](std::size_t i) { states[i] = steady_state(study, pieces[i]); },
      [&](std::size_t i) {
        const Errors e = errors_of(study, pieces[i], states[i]);
        seen.records.front().append({static_cast<double>(pieces[i].nodes),
                                     static_cast<double>(pieces[i].normal), e.velocity, e.stress, e.density});
        worst = {worse(worst.velocity, e.velocity), worse(worst.stress, e.stress),
                 worse(worst.density, e.density)};
      });
  seen.records.insert(seen.records.begin(), profile_record(study, states.front()));
  seen.metrics = {{"velocity_error", worst.velocity, "1", "worst of all nodes, axes and resolutions"},
                  {"stress_error", worst.stress, "1", "worst of all nodes, axes and resolutions"},
                  {"density_error", worst.density, "1", "worst of all nodes, axes and resolutions"}};
}

}  // namespace

engine::Study read_couette(const io::Table& top) {
  const io::Table t = top.table("channel");
  const Common common = read_common(top);
  const Couette study{.common = common,
                      .steady = read_steady(t, 1e-15, common.fluid.storage),
                      .velocity = read_velocity(t, common)};
  const double rate =
      slowest_rate(common.fluid.relaxation_time, static_cast<double>(common.resolutions.back()));
  require_in_reach(t, study.steady, rate, fmt::format("a gap of {} nodes", common.resolutions.back()));
  std::vector<fluid::Spec> runs;
  for (const Piece& piece : pieces_of(study)) runs.push_back(spec_of(study, piece));
  return {
      .plan = plan_at_once(top, runs),
      .measures = {"velocity_error", "stress_error", "density_error", "profile.velocity"},
      .run = [study](Observations& seen, Progress& progress, engine::Cost&) { run(study, seen, progress); }};
}

}  // namespace veriflex::measures::channel
