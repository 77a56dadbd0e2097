#include "measures/coupling/kicked_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.hpp"
#include "base/reduce.hpp"
#include "base/stop.hpp"
#include "measures/solid/noise.hpp"
#include "scene/simulation.hpp"

namespace veriflex::measures {

namespace {

constexpr double kick = 1e-8;        // largest force on a node  [M L T^-2]
constexpr double blown = 1e5;        // times the first change: no need to go on
constexpr std::int64_t window = 40;  // steps; longer than the period of whatever may grow
constexpr double grown = 2.0;        // in half a run: nodes that are not coupled swing for long, and unevenly
constexpr double rounded = 1e-6;     // of the first change: rounded bonds jitter by 1e-8 to 1e-7 of it
static_assert(shortest_kicked_run == 4 * window);

std::vector<Positions> velocities(const scene::Simulation& simulation) {
  std::vector<Positions> v;
  for (std::size_t i = 0; i < simulation.body_count(); ++i) {
    if (simulation.body(i).is_elastic()) v.push_back(simulation.body(i).solid().carried_velocity());
  }
  return v;
}

/// Largest of `count` changes from `first` on.
double largest_of(const std::vector<double>& changes, std::size_t first, std::size_t count) {
  double most = 0.0;
  for (std::size_t i = first; i < first + count; ++i) most = worse(most, changes[i]);
  return most;
}

}  // namespace

Positions kick_of(Eigen::Index nodes, std::uint64_t seed) {
  Positions load = noise(nodes, kick, seed);
  load.rowwise() -= load.colwise().mean().eval();
  return load;
}

KickedRun run_kicked(const scene::Scene& scene, std::int64_t steps) {
  scene::Simulation simulation(scene);
  std::vector<Positions> before = velocities(simulation);
  std::vector<double> changes;
  bool blew_up = false;
  for (std::int64_t step = 1; step <= steps && !blew_up; ++step) {
    try {
      simulation.advance();
    } catch (const NumericalFailure&) {
      if (stop::was_thrown()) throw;
      blew_up = true;
      break;
    }
    std::vector<Positions> now = velocities(simulation);
    double square = 0.0;
    for (std::size_t i = 0; i < now.size(); ++i) square += (now[i] - before[i]).squaredNorm();
    before = std::move(now);
    changes.push_back(std::sqrt(square));
    blew_up = !(changes.back() < blown * changes.front());
  }
  const std::size_t half = changes.size() / 2;
  const std::size_t looked_at = std::min<std::size_t>(window, half / 2);  // fewer where it soon blew up
  if (looked_at == 0) return {blew_up, INFINITY};
  const std::size_t end = changes.size() - looked_at;
  const double middle = largest_of(changes, half, looked_at), last = largest_of(changes, end, looked_at);
  const bool does_grow = last > grown * middle && last > rounded * changes.front();
  return {blew_up || does_grow, std::pow(last / middle, 1.0 / static_cast<double>(end - half))};
}

double least_stable(const std::function<bool(double mass)>& grows_at, double predicted, double resolution,
                    const std::string& what) {
  if (!(predicted > 0.0))
    throw NumericalFailure(fmt::format("{}: every node mass is stable in the map", what));
  double stride = 1.0 + 8.0 * resolution;
  double unstable = predicted / stride, stable = predicted * stride;
  while (!grows_at(unstable)) {
    stable = unstable;
    stride = 2.0 * stride - 1.0;
    unstable /= stride;
    if (unstable < 0.1 * predicted) {
      throw NumericalFailure(fmt::format("{}: no node mass down to {:.3g} grows, predicted is {:.3g}", what,
                                         unstable, predicted));
    }
  }
  if (stable > predicted) {
    while (grows_at(stable)) {
      unstable = stable;
      stride = 2.0 * stride - 1.0;
      stable *= stride;
      if (stable > 10.0 * predicted) {
        throw NumericalFailure(fmt::format("{}: every node mass up to {:.3g} grows, predicted is {:.3g}",
                                           what, stable, predicted));
      }
    }
  }
  while (stable - unstable > resolution * unstable) {
    const double mass = 0.5 * (stable + unstable);
    (grows_at(mass) ? unstable : stable) = mass;
  }
  return 0.5 * (stable + unstable);
}

}  // namespace veriflex::measures
