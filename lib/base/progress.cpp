#include "base/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <utility>

namespace veriflex {

Progress::Progress(std::string label)
    : label_(std::move(label)),
      terminal_(isatty(STDERR_FILENO) == 1),
      phase_start_(Clock::now()),
      seen_(phase_start_),
      last_(phase_start_) {}

Progress::~Progress() {
  if (shown_) fmt::print(stderr, "\r\033[K");
}

void Progress::show(const std::string& phase, std::size_t done, std::size_t total) {
  if (!terminal_) return;
  const Clock::time_point now = Clock::now();
  if (phase != phase_) {
    phase_ = phase;
    phase_start_ = seen_;  // a phase begins where the one before ended, not with its first finished piece
  }
  seen_ = now;
  if (now - last_ < std::chrono::milliseconds(200)) return;
  last_ = now;
  shown_ = true;
  std::string left = "?";
  if (done > 0) {
    const double seconds = std::chrono::duration<double>(now - phase_start_).count();
    const auto rest =
        static_cast<long>(seconds * static_cast<double>(total - done) / static_cast<double>(done));
    left = fmt::format("{}:{:02}", rest / 60, rest % 60);
  }
  fmt::print(stderr, "\r\033[K{}: {} {}/{}, {} left", label_, phase, done, total, left);
  std::fflush(stderr);
}

void Progress::warn(const std::string& warning) {
  fmt::print(stderr, "{}veriflex: {}: warning: {}\n", shown_ ? "\r\033[K" : "", label_, warning);
  warnings_.push_back(warning);
}

}  // namespace veriflex
