/// Cases side by side, each in a program of its own.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "engine/total_progress.hpp"
#include "run_cases.hpp"

namespace veriflex {

/// A case of a command, by its number there.
struct Job {
  std::size_t number;
  std::filesystem::path path;
};

/// Runs options.jobs cases at once, each with its part of options.threads, and hands on what they say as they
/// end: text at once, JSON into all[number]. Cases whose times are measured run alone with all threads, after
/// the others. `code` becomes the gravest exit code. Returns the numbers of those that were not started,
/// because a signal or options.fail_fast was against it.
std::vector<std::size_t> run_side_by_side(const std::vector<Job>& jobs, const Options& options,
                                          bool with_tables, engine::TotalProgress& progress,
                                          nlohmann::ordered_json& all, int& code);

}  // namespace veriflex
