#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "base/reduce.hpp"
#include "coupling/transfer.hpp"
#include "engine/read_scene.hpp"
#include "measures/drivers.hpp"
#include "measures/for_all.hpp"

// What the delta kernels keep of a point force. A unit force is spread from one marker by the very transfer
// that a coupled run uses; sums over the nodes are then the moments of D.
// [wu-qi-2014, Eq. 8; peskin-2002; roma-1999]

namespace veriflex::measures {

namespace {

using coupling::Delta;
using observe::Observations;

constexpr std::int64_t side = 8;  // of the periodic box: holds every support once, and is even
constexpr int scan_steps = 200;

/// At one position of a marker.
struct Moments {
  double sum;        // of D h^3: 1 keeps the force
  double imbalance;  // of D over nodes with even less those with odd x + y + z: 0 leaves checkerboards alone
  Vec3 first;        // of (x - X) D: 0 keeps the torque, and interpolates linear fields exactly  [L]
  double squares;    // of D^2: the share of its own force that a marker feels
};

Moments moments_at(coupling::Transfer& transfer, const Vec3& X) {
  const Grid box{{side, side, side}};
  transfer.locate(X.transpose());
  Positions weights;
  transfer.spread(Positions::Ones(1, 3), weights);
  Moments m{0.0, 0.0, Vec3::Zero(), 0.0};
  for (std::size_t i = 0; i < transfer.nodes().size(); ++i) {
    const double weight = weights(static_cast<Eigen::Index>(i), 0);
    const auto node = box.node(transfer.nodes()[i]);
    m.sum += weight;
    m.imbalance += (node[0] + node[1] + node[2]) % 2 == 0 ? weight : -weight;
    m.squares += weight * weight;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto k = static_cast<Eigen::Index>(axis);
      const double distance =
          std::remainder(static_cast<double>(node[axis]) - X[k], static_cast<double>(side));
      m.first[k] += distance * weight;
    }
  }
  return m;
}

struct Extremes {
  double sum_error = 0.0;
  double sum_min = std::numeric_limits<double>::infinity();
  double sum_mean = 0.0;
  double imbalance = 0.0;
  double first = 0.0;
  double squares_min = std::numeric_limits<double>::infinity();
  double squares_max = 0.0;
};

/// What is measured of each kernel.
struct DeltaMoment {
  const char* name;
  const char* dimension;
  const char* meaning;
  double Extremes::*value;
};

constexpr std::array delta_moments{
    DeltaMoment{"sum_error", "1", "max |sum of D h^3 - 1|", &Extremes::sum_error},
    DeltaMoment{"sum_min", "1", "smallest sum", &Extremes::sum_min},
    DeltaMoment{"sum_mean", "1", "mean sum", &Extremes::sum_mean},
    DeltaMoment{"imbalance", "1", "max |sum of (-1)^(x+y+z) D h^3|", &Extremes::imbalance},
    DeltaMoment{"first_moment", "L", "max over the axes of |sum of (x - X) D h^3|", &Extremes::first},
    DeltaMoment{"squares_min", "1", "smallest sum of (D h^3)^2", &Extremes::squares_min},
    DeltaMoment{"squares_max", "1", "largest sum of (D h^3)^2", &Extremes::squares_max}};

std::string name_of(const Named<Delta>& kernel, const DeltaMoment& quantity) {
  return fmt::format("{}_{}", kernel.id, quantity.name);
}

/// One record per moment, one column per kernel, along the diagonal of a cell.
Observations delta_moments_observations() {
  const observe::Column offset{"offset", "", "L", "of the marker from a node, along each axis", {}};
  Observations all;
  all.records = {{"delta_sums", "Sum of the weights along the diagonal of a cell", {offset}},
                 {"delta_imbalances", "Even less odd nodes along the same diagonal", {offset}},
                 {"delta_first_moments", "First moment along the same diagonal", {offset}}};
  for (const Named<Delta>& kernel : coupling::deltas) {
    const std::string name(kernel.id);
    all.records[0].columns.push_back({name, "", "1", "sum of D h^3", {}});
    all.records[1].columns.push_back({name, "", "1", "sum of (-1)^(x+y+z) D h^3", {}});
    all.records[2].columns.push_back({name, "", "L", "sum of (x - X) D h^3, the same along each axis", {}});
    for (const DeltaMoment& quantity : delta_moments)
      all.metrics.push_back({name_of(kernel, quantity), {}, quantity.dimension, quantity.meaning});
  }
  return all;
}

/// Over positions from a generator whose numbers are the same everywhere.
Extremes extremes_of(Delta delta, std::int64_t positions) {
  coupling::Transfer transfer({{side, side, side}}, {false, false, false}, delta);
  std::mt19937 random(1);
  const auto number = [&random] {
    return static_cast<double>(side) * static_cast<double>(random()) / 4294967296.0;
  };
  Extremes seen;
  for (std::int64_t i = 0; i < positions; ++i) {
    Vec3 X;
    for (double& x : X) x = number();
    const Moments m = moments_at(transfer, X);
    seen.sum_error = worse(seen.sum_error, std::abs(m.sum - 1.0));
    seen.sum_min = std::min(seen.sum_min, m.sum);
    seen.sum_mean += m.sum / static_cast<double>(positions);
    seen.imbalance = worse(seen.imbalance, std::abs(m.imbalance));
    seen.first = worse(seen.first, m.first.cwiseAbs().maxCoeff());
    seen.squares_min = std::min(seen.squares_min, m.squares);
    seen.squares_max = worse(seen.squares_max, m.squares);
  }
  return seen;
}

void scan(Observations& seen) {
  std::vector<coupling::Transfer> transfers;
  for (const Named<Delta>& kernel : coupling::deltas)
    transfers.emplace_back(Grid{{side, side, side}}, std::array{false, false, false}, kernel.value);
  for (int i = 0; i <= scan_steps; ++i) {
    const double x = static_cast<double>(i) / scan_steps;
    std::vector<double> sums{x}, imbalances{x}, first_moments{x};
    for (coupling::Transfer& transfer : transfers) {
      const Moments m = moments_at(transfer, Vec3::Constant(x));
      sums.push_back(m.sum);
      imbalances.push_back(m.imbalance);
      first_moments.push_back(m.first[0]);
    }
    seen.open("delta_sums").append(sums);
    seen.open("delta_imbalances").append(imbalances);
    seen.open("delta_first_moments").append(first_moments);
  }
}

void run_delta_moments(std::int64_t positions, Observations& seen, Progress& progress, engine::Cost& cost) {
  std::vector<Extremes> found(coupling::deltas.size());
  for_all(found.size(), "kernels", progress,
          [&](std::size_t i) { found[i] = extremes_of(coupling::deltas[i].value, positions); });
  cost.finish("positions");
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (const DeltaMoment& quantity : delta_moments)
      seen.set(name_of(coupling::deltas[i], quantity), found[i].*quantity.value);
  }
  scan(seen);
  cost.finish("scan");
}

}  // namespace

engine::Study read_delta_moments(const io::Table& top) {
  const std::int64_t positions = top.table("delta_moments").integer("positions", 1, 100'000'000);
  scene::Plan plan = engine::read_plan(top, {});
  scene::put_in(plan, {"coupling",
                       "supports and weights of single markers, for each delta function",
                       0.0,
                       {parts::Kind::Coupling}});
  return {.plan = std::move(plan),
          .declares = delta_moments_observations(),
          .run = [positions](Observations& seen, Progress& progress, engine::Cost& cost) {
            run_delta_moments(positions, seen, progress, cost);
          }};
}

}  // namespace veriflex::measures
