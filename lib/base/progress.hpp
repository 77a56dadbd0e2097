/// A line on the terminal while long work goes on, and what a run warns of.
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace veriflex {

/// Shows `label: done/total, m:ss left` on standard error at most a few times a second, and only where that
/// is a terminal. Safe to call from several threads when calls are serialised by the caller.
class Progress {
 public:
  explicit Progress(std::string label);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void show(const std::string& phase, std::size_t done, std::size_t total);

  /// Something that does not stop the run but must not be overlooked: written to standard error at once, and
  /// kept for the result.
  void warn(const std::string& warning);
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  using Clock = std::chrono::steady_clock;
  std::string label_;
  std::string phase_;
  bool terminal_;
  bool shown_ = false;
  std::vector<std::string> warnings_;
  Clock::time_point phase_start_;
  Clock::time_point seen_;  // last call
  Clock::time_point last_;  // last line written
};

/// Every Progress line begins with these words from now on.
void lead_progress_with(const std::string& words);

}  // namespace veriflex
