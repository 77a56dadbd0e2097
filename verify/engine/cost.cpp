#include "engine/cost.hpp"

#include <algorithm>

namespace veriflex::engine {

void Cost::finish(const std::string& phase) { finish(phase, {}); }

void Cost::finish(const std::string& phase, const std::vector<Phase>& parts) {
  const auto wall = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  double wall_seconds = std::chrono::duration<double>(wall - wall_).count();
  double cpu_seconds = static_cast<double>(cpu - cpu_) / CLOCKS_PER_SEC;
  for (const Phase& part : parts) {
    Phase& counted = at(phase + ", " + part.name);
    counted.wall_seconds += part.wall_seconds;
    counted.cpu_seconds += part.cpu_seconds;
    wall_seconds -= part.wall_seconds;
    cpu_seconds -= part.cpu_seconds;
  }
  Phase& rest = at(phase);
  rest.wall_seconds += wall_seconds;
  rest.cpu_seconds += cpu_seconds;
  wall_ = wall;
  cpu_ = cpu;
}

Phase& Cost::at(const std::string& phase) {
  auto found = std::find_if(phases_.begin(), phases_.end(), [&](const Phase& p) { return p.name == phase; });
  if (found == phases_.end()) found = phases_.insert(phases_.end(), {phase, 0.0, 0.0});
  return *found;
}

double Cost::wall_seconds() const {
  double total = 0.0;
  for (const Phase& phase : phases_) total += phase.wall_seconds;
  return total;
}

}  // namespace veriflex::engine
