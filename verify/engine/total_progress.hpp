/// How far a command with many cases is, and how long the rest will take.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace veriflex::engine {

/// What works take that are not done yet  [s]. `expected`: of each work; one whose time nobody knows takes
/// the mean of those that are known. Those that are done correct the expectation by the factor that they took
/// longer. Nothing where nothing is known. `spent`: of each that is done.
std::optional<double> seconds_left(const std::vector<std::optional<double>>& expected,
                                   const std::vector<std::optional<double>>& spent);

/// "0:07", "12:05", "3:02:11".
std::string clock_text(double seconds);

/// The line of it on standard error, where that is a terminal: `12/80 cases, about 2:10 left`.
class TotalProgress {
 public:
  /// `side_by_side`: works that run at the same time.
  TotalProgress(std::vector<std::optional<double>> expected, int side_by_side);
  ~TotalProgress();
  TotalProgress(const TotalProgress&) = delete;
  TotalProgress& operator=(const TotalProgress&) = delete;

  /// That work is done after so many seconds.
  void done(std::size_t i, double seconds);
  /// Writes the line, `now` behind it; every Progress line begins with it from then on.
  void show(const std::string& now);
  /// Takes the line away before other words are written.
  void clear();
  std::string text() const;

 private:
  std::vector<std::optional<double>> expected_, spent_;
  int side_by_side_;
  bool terminal_;
  bool shown_ = false;
};

}  // namespace veriflex::engine
