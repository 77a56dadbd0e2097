#include "fluid/fluid.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "base/error.hpp"
#include "base/memory.hpp"
#include "base/mutant.hpp"
#include "fluid/links.hpp"
#include "fluid/moment_fluid.hpp"
#include "fluid/population_fluid.hpp"

namespace veriflex::fluid {

std::array<bool, 3> closed(const Spec& spec) {
  return {spec.walls[0].has_value(), spec.walls[1].has_value(), spec.walls[2].has_value()};
}

double Inflow::risen(std::int64_t steps) const {
  const double t = static_cast<double>(steps);
  return t < rise && !planted(Mutant::inflow_at_once) ? 0.5 - 0.5 * std::cos(std::numbers::pi * t / rise)
                                                      : 1.0;
}

Populations equilibrium(double rho, const Vec3& u) {
  Populations h;
  for (int q = 0; q < Q; ++q) {
    const double cu = along(q, u);
    h[static_cast<std::size_t>(q)] =
        w(q) * ((rho - 1.0) + rho * (3.0 * cu + (planted(Mutant::equilibrium_linear) ? 0.0 : 4.5) * cu * cu -
                                     1.5 * u.squaredNorm()));
  }
  return h;
}

double density_deviation(const Populations& h) {
  double sum = h[0];
  for (std::size_t q = 1; q < Q; q += 2) sum += h[q] + h[q + 1];
  return sum;
}

Vec3 momentum(const Populations& h) {
  Vec3 j = Vec3::Zero();
  for (std::size_t q = 1; q < Q; q += 2) {
    const double along = h[q] - h[q + 1];
    for (int axis = 0; axis < 3; ++axis) j[axis] += along * c[q][static_cast<std::size_t>(axis)];
  }
  return j;
}

Mat3 viscous_stress(const Populations& h, double relaxation_time) {
  const double rho = 1.0 + density_deviation(h);
  const Populations rest = equilibrium(rho, momentum(h) / rho);
  Mat3 sum = Mat3::Zero();
  for (std::size_t q = 1; q < Q; ++q) {
    const Vec3 v(c[q][0], c[q][1], c[q][2]);
    sum += (h[q] - rest[q]) * v * v.transpose();
  }
  return -(1.0 - (planted(Mutant::stress_not_halved) ? 1.0 : 0.5) / relaxation_time) * sum;
}

State Fluid::state() const {
  std::vector<std::int64_t> nodes(static_cast<std::size_t>(spec_.grid.count()));
  std::iota(nodes.begin(), nodes.end(), std::int64_t{0});
  State state{steps_, std::vector<Populations>(nodes.size())};
  populations(nodes, state.populations);
  return state;
}

void Fluid::advance(std::int64_t steps) {
  for (std::int64_t i = 0; i < steps; ++i) collide_and_stream();
}

void Fluid::tell_parts(const Bytes& bytes) {
  using parts::Kind;
  const bool moments = representation_of(spec_) == Representation::Moments;
  parts_.emplace_back(moments ? Kind::Moments : Kind::Populations, bytes.nodes);
  if (spec_.walls[0] || spec_.walls[1] || spec_.walls[2]) parts_.emplace_back(Kind::Walls, bytes.walls);
  if (spec_.has_obstacle()) parts_.emplace_back(Kind::Obstacle, bytes.obstacle);
  if (spec_.is_forced()) parts_.emplace_back(Kind::BodyForce, 0.0);
}

bool is_made_row_by_row(const Spec& spec) {
  return !spec.has_obstacle() && std::none_of(spec.walls.begin(), spec.walls.end(), [](const auto& walls) {
    return walls && std::any_of(walls->openings.begin(), walls->openings.end(), [](const auto& opening) {
             return !std::holds_alternative<std::monostate>(opening);
           });
  });
}

Representation representation_of(const Spec& spec) {
  const bool possible = spec.relaxation_time == 1.0;
  if (spec.representation == Representation::Moments && !possible) {
    throw BadParameter("fluid.representation", "moments alone are no state of this fluid",
                       fmt::format("only at tau = 1 does a collision keep nothing but density and momentum; "
                                   "'relaxation_time' is {}",
                                   spec.relaxation_time),
                       "Leave 'representation' out: \"auto\" takes moments where that is possible");
  }
  return possible && spec.representation != Representation::Populations ? Representation::Moments
                                                                        : Representation::Populations;
}

double memory_bytes(const Spec& spec) {
  return representation_of(spec) == Representation::Moments ? moment_bytes(spec) : population_bytes(spec);
}

double start_bytes(const Spec& spec) {
  return representation_of(spec) == Representation::Moments
             ? static_cast<double>(spec.grid.count()) * static_cast<double>(sizeof(Populations))
             : 0.0;
}

namespace {

/// Refuses what does not fit into the memory that is available now.
void require(const Spec& spec, double bytes, const std::string& what, const std::string& suggestion) {
  const double available = available_memory_bytes();
  if (bytes <= available) return;
  const auto [nx, ny, nz] = spec.grid.size;
  throw BadParameter(
      "fluid.nodes", fmt::format("a box of {} x {} x {} nodes does not fit into memory", nx, ny, nz),
      fmt::format("its {} take {:.3g} GB, {:.3g} GB are available", what, bytes * 1e-9, available * 1e-9),
      suggestion);
}

}  // namespace

void require_memory(const Spec& spec) {
  require(spec, memory_bytes(spec), std::string(row_of(representations, representation_of(spec)).name),
          spec.storage == Storage::Double ? "Use fewer nodes, or storage = \"float\" for half of it"
                                          : "Use fewer nodes");
}

void require_start_memory(const Spec& spec) {
  require(spec, start_bytes(spec), "populations at the start",
          "Use fewer nodes, or representation = \"populations\"");
}

std::unique_ptr<Fluid> make_fluid(const Spec& spec) {
  if (!(spec.relaxation_time > 0.5)) {
    throw BadParameter("fluid.relaxation_time", fmt::format("'relaxation_time' is {}", spec.relaxation_time),
                       "the viscosity (tau - 1/2)/3 must be positive", "Use more than 0.5, for example 1.0");
  }
  require_memory(spec);
  return representation_of(spec) == Representation::Moments ? make_moment_fluid(spec)
                                                            : make_population_fluid(spec);
}

}  // namespace veriflex::fluid
