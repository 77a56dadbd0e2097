/// A case: one question, the study that answers it, and the checks that judge the answer. Schema:
/// cases/README.md.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/reference.hpp"
#include "engine/study.hpp"

namespace veriflex::engine {

enum class CheckKind {
  verification,  // does the program satisfy the mathematics?
  claim,         // does the published statement hold?
};
std::string to_string(CheckKind kind);

struct Tolerance {
  bool relative;
  double value;
  double floor;  // for curves: relative to max(|reference|, floor)
  std::string text;
  std::string reason;
};

/// In the place of a tolerance, against a published value: how far each side may be off, in the unit of the
/// value and all at one level of confidence (some 95 %: half-widths).
/// [asme-vv20-2009]
struct Uncertainty {
  double reference;  // of the target
  double numerical;  // of the measured value: spacing, step, box; where `gci` is given the study says it
  double input;      // of what is put in, such as material and size of what was measured
  std::optional<std::string> gci{};  // number of the study

  double combined() const;  // root of the sum of their squares
};

/// Which columns of a record to hold against the reference's columns of the same names.
struct Curve {
  std::string record, x, y;
};

/// What a refuted claim was measured to be when the refutation was recorded.
struct Recorded {
  double value;
  double relative;  // how far a later measurement may depart from it
};

struct Check {
  CheckKind kind;
  std::string statement;
  std::string measure;  // metric, or record.column for a curve or a table
  std::optional<Curve> curve;
  bool of_table = false;  // counts the rows of record.column that depart from the baseline's table
  double target;          // 0 for a curve, whose measure is its largest error
  bool outside;  // the statement holds when the measured value is *not* within the tolerance of the target
  Tolerance tolerance;  // its value means nothing where an uncertainty stands in its place
  std::optional<Uncertainty> uncertainty;
  std::optional<std::size_t>
      reference;  // index in Case::references; none when the case states the target itself
  std::string target_kind;
  std::string source;
  std::vector<std::string> claims;  // entries of the ledger, or of the benchmarks, that it judges
  std::optional<Recorded> refuted;  // given: the claim is expected not to hold
  Place place;
};

/// A value that the source does not give.
struct Assumption {
  std::string path;   // dotted, of a value in the case
  std::string value;  // as TOML
  std::string why;
};

struct Case {
  std::string id, title, question, equation, driver, tier;
  std::vector<std::string> topics, sources;
  Place sources_at;
  std::vector<Assumption> assumed;
  std::string text;  // of the file
  std::filesystem::path path;
  std::vector<std::string> overrides;
  Study study;
  std::vector<Check> checks;
  std::vector<Reference> references;

  /// What the result is called: the id, and for a case changed by `--set` what was set, in characters that
  /// suit a file name: `id+bond.epsilon=2`, with a part of its checksum where that does not say it all.
  std::string name() const;
};

/// What the result of a case is called that was changed by these settings; see Case::name().
std::string name_of_variant(const std::string& id, const std::vector<std::string>& overrides);

const std::vector<std::string>& tiers();

/// Makes one run of a case a study of many, if the case has a table of one: [sweep], [boundary], [ablate].
/// `checks`: those that ask for its numbers.
using StudyReader = std::function<Study(const io::Table& top, const std::vector<io::Table>& checks,
                                        const Case& c, Study measure)>;

/// What reads a case.
struct Readers {
  std::vector<Driver> drivers;
  StudyReader study{};
  bool with_checks = true;  // without: one run is measured, nothing is judged
};

/// Reads a case and the references it names (beside it, or in `reference_folder`, which also holds the ledger
/// of claims). Throws InputError, the first of what read_parts() finds.
Case read_case(const std::filesystem::path& path, const std::vector<std::string>& overrides,
               const Readers& readers, const std::filesystem::path& reference_folder);

/// What can be read of the case in `top`, which stands at `path`; what cannot is added to `problems`: per
/// table of the case the first problem in it, and every key that nobody knows.
Case read_parts(const io::Table& top, const std::filesystem::path& path, const Readers& readers,
                const std::filesystem::path& reference_folder, std::vector<InputError>& problems);

/// What a listing needs, without the study: readable even when the rest of the case is not. `problem` is
/// empty or says why it is no case.
struct CaseHead {
  std::string id, title, tier, driver;
  std::vector<std::string> topics;
  std::filesystem::path path;
  std::string problem;
};
CaseHead read_head(const std::filesystem::path& path);

/// The case file that `name` means: a path, or an id in `folder`. Throws InputError, with the nearest id
/// suggested.
std::filesystem::path case_named(const std::string& name, const std::filesystem::path& folder);

/// Heads of all `*.toml` files in a folder, sorted by id.
std::vector<CaseHead> find_cases(const std::filesystem::path& folder);

}  // namespace veriflex::engine
