/// Running the cases of a command: each is judged, stored, and told of.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "engine/case.hpp"
#include "repository.hpp"
#include "studies/rows.hpp"

namespace veriflex {

/// What the commands about cases are given.
struct Options {
  std::vector<std::string> cases;
  std::vector<std::string> overrides;
  std::string case_folder = repository::cases().string();
  std::string tier;
  std::string topic;
  std::string out = "results";
  std::string report;
  int threads = 0;
  bool json = false;
  bool brief = false;         // without tables
  bool fail_fast = false;     // after a failure no other case is started
  int jobs = 1;               // cases side by side
  bool fresh = false;         // rows of studies that are kept are run again
  bool with_checks = true;    // else nothing is judged, as where a study was put over a case by a command
  bool is_row = false;        // of a study: the one run that the case describes
  int repeats = 0;            // of a row, for its time
  int shard = 0, shards = 1;  // of a study
  bool resume = false;        // a run goes on from its checkpoint
  std::string junit;          // file for a report in JUnit's form; empty: none
};

/// A case as the options have it.
engine::Case read_without_baseline(const std::filesystem::path& path, const Options& options);

/// The same with the checks against its baseline.
engine::Case read_case(const std::filesystem::path& path, const Options& options);

/// Runs the named cases, one after another or options.jobs side by side, and stores and prints each result:
/// side by side in the order in which they end. `expected`: how long each will take, for the progress line;
/// empty: not known. Returns the exit code: the first of 4, 2, 3, 1 that occurred. Throws InputError when two
/// of them would write the same result.
int run_cases(const std::vector<std::string>& names, const Options& options, bool with_tables,
              std::vector<std::optional<double>> expected = {});

/// Does what is left to do after the runs: whatever is wrong with it is said, and comes back as an exit code.
int attempted(const std::function<void()>& work);

/// Prints JSON; bytes that are no UTF-8, as file names may hold, are replaced.
void print_json(const nlohmann::ordered_json& json);

}  // namespace veriflex
