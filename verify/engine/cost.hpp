/// Wall and processor time per phase of a run.
#pragma once

#include <chrono>
#include <ctime>
#include <string>
#include <vector>

namespace veriflex::engine {

struct Phase {
  std::string name;
  double wall_seconds;
  double cpu_seconds;  // of all threads
};

class Cost {
 public:
  /// Time since the previous call (or construction) belongs to `phase`; repeated phases add up.
  void finish(const std::string& phase);
  /// The same, of which `parts` are counted apart, as phases `<phase>, <part>`.
  void finish(const std::string& phase, const std::vector<Phase>& parts);
  /// Time that was spent in an earlier program.
  void add(const Phase& phase) { phases_.push_back(phase); }
  const std::vector<Phase>& phases() const { return phases_; }
  double wall_seconds() const;

 private:
  Phase& at(const std::string& phase);

  std::vector<Phase> phases_;
  std::chrono::steady_clock::time_point wall_ = std::chrono::steady_clock::now();
  std::clock_t cpu_ = std::clock();
};

}  // namespace veriflex::engine
