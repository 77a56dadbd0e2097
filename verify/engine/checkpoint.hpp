/// What a long run leaves behind from time to time, so that a run that was killed goes on from there bit by
/// bit. The file: verify/README.md.
#pragma once

#include <chrono>
#include <ctime>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "base/work.hpp"
#include "engine/cost.hpp"
#include "io/hdf5.hpp"

namespace veriflex::engine {

struct Case;

class Checkpoints {
 public:
  /// Of a run of that case by this program that begins now, in that file. With `resume` the run goes on from
  /// the file if it is there; throws InputError when it is damaged, or of another case text, other settings
  /// or another program: its numbers would not be those of this run.
  Checkpoints(std::filesystem::path file, const Case& c, bool resume);

  /// What the run goes on from; null: it begins at its start.
  const io::Hdf5File* earlier() const { return earlier_ ? &*earlier_ : nullptr; }
  /// The run stands where `earlier` stood: work and time count on from there. Frees `earlier`.
  void resumed(std::int64_t step, Cost& cost);

  /// Whether so many seconds have gone by since the last one, or since the run began, and a hundred times
  /// what writing it took: checkpoints cost less than 1 % of a run.
  bool is_due(double seconds) const;
  /// Writes what `put` puts into the file, with what says of which run it is, aside and renamed. A disk that
  /// is full, or memory, does not end the run: it is said once.
  void write(std::int64_t step, const std::function<void(io::Hdf5Image&)>& put);
  /// Nothing is to be gone on from any more.
  void remove() const;

  const std::filesystem::path& file() const { return file_; }

 private:
  using Clock = std::chrono::steady_clock;

  void say_whose(io::Hdf5Image& image, std::int64_t step) const;

  std::filesystem::path file_;
  std::string text_, settings_;
  std::optional<io::Hdf5File> earlier_;
  work::Counts before_ = work::done();           // what the process had done when the run would have begun
  double wall_before_ = 0.0, cpu_before_ = 0.0;  // of earlier programs  [s]
  Clock::time_point began_ = Clock::now(), last_ = began_;
  std::clock_t cpu_began_ = std::clock();
  double took_ = 0.0;  // to write the last one  [s]
  bool has_complained_ = false;
};

/// `<folder>/<name>.checkpoint`.
std::filesystem::path checkpoint_path(const Case& c, const std::filesystem::path& folder);

}  // namespace veriflex::engine
