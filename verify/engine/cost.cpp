#include "engine/cost.hpp"

#include <algorithm>

namespace veriflex::engine {

void Cost::finish(const std::string& phase) {
  const auto wall = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  auto found = std::find_if(phases_.begin(), phases_.end(), [&](const Phase& p) { return p.name == phase; });
  if (found == phases_.end()) found = phases_.insert(phases_.end(), {phase, 0.0, 0.0});
  found->wall_seconds += std::chrono::duration<double>(wall - wall_).count();
  found->cpu_seconds += static_cast<double>(cpu - cpu_) / CLOCKS_PER_SEC;
  wall_ = wall;
  cpu_ = cpu;
}

double Cost::wall_seconds() const {
  double total = 0.0;
  for (const Phase& phase : phases_) total += phase.wall_seconds;
  return total;
}

}  // namespace veriflex::engine
