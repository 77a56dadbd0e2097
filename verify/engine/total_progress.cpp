#include "engine/total_progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "base/progress.hpp"
#include "base/say.hpp"

namespace veriflex::engine {

std::optional<double> seconds_left(const std::vector<std::optional<double>>& expected,
                                   const std::vector<std::optional<double>>& spent) {
  double known = 0.0, foreseen = 0.0, took = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (expected[i] && spent[i]) {
      foreseen += *expected[i];
      took += *spent[i];
    }
    if (!expected[i] && !spent[i]) continue;
    known += spent[i] ? *spent[i] : *expected[i];
    ++count;
  }
  if (count == 0) return std::nullopt;
  const double factor = foreseen > 0.0 && took > 0.0 ? took / foreseen : 1.0;
  const double mean = known / static_cast<double>(count);
  double left = 0.0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (!spent[i]) left += expected[i] ? *expected[i] * factor : mean;
  }
  return left;
}

std::string clock_text(double seconds) {
  const auto whole = static_cast<long>(std::min(std::max(seconds, 0.0), 3.6e8));
  if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

TotalProgress::TotalProgress(std::vector<std::optional<double>> expected, int side_by_side)
    : expected_(std::move(expected)),
      spent_(expected_.size()),
      side_by_side_(side_by_side),
      terminal_(expected_.size() > 1 && isatty(STDERR_FILENO) == 1) {}

TotalProgress::~TotalProgress() {
  clear();
  lead_progress_with("");
}

void TotalProgress::done(std::size_t i, double seconds) { spent_[i] = seconds; }

std::string TotalProgress::text() const {
  const auto is_done = [](const std::optional<double>& spent) { return spent.has_value(); };
  const auto done = std::count_if(spent_.begin(), spent_.end(), is_done);
  const std::optional<double> left = seconds_left(expected_, spent_);
  const std::string time = left ? fmt::format(", about {} left", clock_text(*left / side_by_side_)) : "";
  return fmt::format("{}/{} cases{}", done, spent_.size(), time);
}

void TotalProgress::show(const std::string& now) {
  if (!terminal_) return;
  const std::string before = fmt::format("[{}] ", text());
  lead_progress_with(before);
  say_to(stderr, "\r\033[K{}{}", before, now);
  std::fflush(stderr);
  shown_ = true;
}

void TotalProgress::clear() {
  if (shown_) say_to(stderr, "\r\033[K");
  shown_ = false;
}

}  // namespace veriflex::engine
