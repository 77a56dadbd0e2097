/// A case that has run, and its result file. Schema: verify/README.md.
#pragma once

#include <filesystem>
#include <string>

#include "engine/case.hpp"
#include "engine/verdict.hpp"

namespace veriflex::engine {

struct Provenance {
  std::string version, revision, compiler, flags, build_type, machine, operating_system, date;
  int threads;
};

/// Of this program, here and now.
Provenance provenance(int threads);

struct Result {
  Case c;
  Provenance provenance;
  observe::Observations seen;
  std::vector<Outcome> outcomes;  // one per check, unless the verdict is error
  Verdict verdict;
  std::string error_kind, error_message;
  std::vector<std::string> warnings;
  Cost cost;

  int findings() const;
  double worst_margin() const;  // over the checks that passed or failed
};

/// Runs the study and judges it. A NumericalFailure becomes the verdict `error`, and what an
/// observe::Interrupted has seen stays in the result, unjudged; other exceptions pass through.
Result run_case(const Case& c, int threads);

/// The result of a case that could not be read: verdict `error`.
Result unreadable(const std::filesystem::path& path, const std::string& message, int threads);

/// Writes `<folder>/<id>.h5`, aside and renamed. Throws OutputError.
void write_result(const Result& result, const std::filesystem::path& folder);

}  // namespace veriflex::engine
