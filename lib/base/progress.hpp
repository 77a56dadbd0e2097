/// A line on the terminal while long work goes on.
#pragma once

#include <chrono>
#include <string>

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

 private:
  using Clock = std::chrono::steady_clock;
  std::string label_;
  std::string phase_;
  bool terminal_;
  bool shown_ = false;
  Clock::time_point phase_start_;
  Clock::time_point seen_;  // last call
  Clock::time_point last_;  // last line written
};

}  // namespace veriflex
