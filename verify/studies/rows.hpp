/// The rows of a study: runs of one case with other values, each in a program of its own.
///
/// A row is a result file like any other, in a folder beside the study's own result. One that is there
/// already, of the same case, settings and program, is not run again. A row that fails, even one that the
/// system kills, is a row whose outcome says so.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/parts.hpp"
#include "base/progress.hpp"
#include "base/work.hpp"
#include "engine/case.hpp"

namespace veriflex::studies {

/// Where rows are kept, and what runs them.
struct Workspace {
  std::filesystem::path program;  // this one
  std::filesystem::path results;  // folder of the study's result
  int threads = 1;
  bool fresh = false;         // runs rows again that are kept
  int shard = 0, shards = 1;  // of the rows this machine runs every `shards`-th, from `shard` on
};

/// Whether this machine runs the i-th of the parts that a study can be divided into.
inline bool is_mine(const Workspace& workspace, std::size_t i) {
  return static_cast<int>(i % static_cast<std::size_t>(workspace.shards)) == workspace.shard;
}

/// The case that the rows vary.
struct Base {
  std::filesystem::path path;
  std::string id, text;
  std::vector<std::string> overrides;      // without those of the study's own table
  std::string name;                        // of the study's result
  std::vector<observe::Record> records{};  // that a run declares, without rows
};

struct Row {
  std::vector<std::string> settings;                      // of this row
  std::string outcome;                                    // Result::outcome(); `killed` by a signal
  std::string message;                                    // why it is not complete, else empty
  observe::Observations seen;                             // its metrics
  double wall_seconds = 0.0, cpu_seconds = 0.0;           // of the run; with repeats their medians
  double min_wall_seconds = 0.0, max_wall_seconds = 0.0;  // of the repeats, or as wall_seconds
  work::Counts work;
  parts::AllMade parts{};
  double parts_bytes = 0.0;  // of all parts together, at most
  double peak_memory_bytes = 0.0;
};

/// Folder of the rows of a study; timed and untimed ones do not mix.
std::filesystem::path folder_of_rows(const Base& base, const Workspace& workspace, bool timed);

/// How rows are run: side by side with a thread each, or one after another with all threads for the sake of
/// their times, which may be those of further runs, one in each round over all rows.
struct Timing {
  bool timed = false;
  int repeats = 0;
};

/// `timed` and `repeats` of a study's table. Throws InputError: repeats of what is not timed.
Timing read_timing(const io::Table& study);

/// One row per list of settings, in that order. Throws Stopped when a signal asks for it, after all rows that
/// ran have ended; OutputError when a row cannot be stored.
std::vector<Row> run_rows(const Base& base, const std::vector<std::vector<std::string>>& settings,
                          const Workspace& workspace, const Timing& timing, const std::string& phase,
                          Progress& progress);

/// What the declared records of the case hold in a row that came to its end.
std::vector<observe::Record> records_of(const Base& base, const Row& row, const Workspace& workspace,
                                        bool timed);

}  // namespace veriflex::studies
