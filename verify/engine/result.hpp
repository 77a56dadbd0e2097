/// A case that has run, and its result file. Schema: verify/README.md.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/parts.hpp"
#include "base/work.hpp"
#include "engine/case.hpp"
#include "engine/checkpoint.hpp"
#include "engine/verdict.hpp"
#include "io/hdf5.hpp"

namespace veriflex::engine {

struct Provenance {
  std::string version, revision, compiler, flags, build_type, machine, operating_system, date;
  int threads;
};

/// What tells this program from others: its revision, and where that leaves it open (a changed or unknown
/// source) the checksum of its file.
const std::string& program();

/// Of this program, here and now.
Provenance provenance(int threads);

/// Why a case has no answer. Kinds: input, numerical, memory, output, interrupted, internal; and of one that
/// was skipped, lacking.
struct Failure {
  std::string kind, message;
  std::string mode{};  // of a numerical one: which validity was left
};

/// The exception that is being handled.
Failure current_failure();

struct Result {
  Case c;
  Provenance provenance;
  observe::Observations seen;
  std::vector<Outcome> outcomes;  // one per check, unless the verdict is error
  Verdict verdict;
  std::string error_kind, error_message, error_mode;
  std::vector<std::string> warnings;
  Cost cost;
  work::Counts work{};           // of the run
  parts::AllMade parts{};        // that the run built, and
  parts::Peak peak{};            // their memory together
  std::vector<Phase> repeats{};  // time of each further run, made for its time alone

  /// How the run ended: completed; or refused (by a reader), one of to_string(FailureMode), memory, output,
  /// interrupted, internal, skipped.
  std::string outcome() const;
  void fail(const Failure& failure);  // verdict error, or skipped, without outcomes
  bool has_answer() const { return verdict != Verdict::error && verdict != Verdict::skipped; }
  int findings() const;
  double worst_margin() const;  // over the checks that passed or failed
};

/// Runs the study and judges it. Any exception becomes the verdict `error`, and what was seen until then
/// stays in the result, unjudged; what this program lacks, the verdict `skipped`. A run that came to its end
/// is made `repeats` times more for its time: what the clock resolves badly as often as it takes, and the
/// mean counts. With `checkpoints` the run leaves some behind, and goes on from one if they say so.
Result run_case(const Case& c, int threads, int repeats = 0, Checkpoints* checkpoints = nullptr);

/// The result of a case that was not run: verdict `error`.
Result not_run(const std::filesystem::path& path, const std::vector<std::string>& overrides,
               const Failure& failure, int threads);

/// A table of a result file ("/checks"), with what it says of its columns and their values. Throws InputError
/// when the file has none there.
observe::Record read_table(const io::Hdf5File& file, const std::string& group);

/// The record of that name.
observe::Record read_record(const io::Hdf5File& file, const std::string& name);

/// `<folder>/<name>.h5`.
std::filesystem::path result_path(const Case& c, const std::filesystem::path& folder);

/// Writes result_path(), aside and renamed. Throws OutputError, and std::runtime_error for what an HDF5 file
/// cannot hold.
void write_result(const Result& result, const std::filesystem::path& folder);

}  // namespace veriflex::engine
