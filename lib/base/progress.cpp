#include "base/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "base/say.hpp"

namespace veriflex {

namespace {

std::string& lead() {
  static std::string words;
  return words;
}

}  // namespace

void lead_progress_with(const std::string& words) { lead() = words; }

Progress::Progress(std::string label)
    : label_(std::move(label)),
      terminal_(isatty(STDERR_FILENO) == 1),
      phase_start_(Clock::now()),
      seen_(phase_start_),
      last_(phase_start_) {}

Progress::~Progress() {
  if (shown_) say_to(stderr, "\r\033[K");
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
  if (done > 0 && done <= total) {
    const double seconds = std::chrono::duration<double>(now - phase_start_).count();
    const double rest = seconds * static_cast<double>(total - done) / static_cast<double>(done);
    const auto whole = static_cast<long>(std::min(rest, 3.6e8));  // ten thousand hours are as good as any
    left = fmt::format("{}:{:02}", whole / 60, whole % 60);
  }
  say_to(stderr, "\r\033[K{}{}: {} {}/{}, {} left", lead(), label_, phase, done, total, left);
  std::fflush(stderr);
}

void Progress::warn(const std::string& warning) {
  warnings_.push_back(warning);
  if (shown_) say_to(stderr, "\r\033[K");
  complain("{}: warning: {}", label_, warning);
}

}  // namespace veriflex
