/// Reference values: numbers or a table, with where they come from. Schema: reference/README.md.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/csv.hpp"
#include "io/document.hpp"
#include "observe/record.hpp"

namespace veriflex::engine {

struct ReferenceValue {
  double value;
  double uncertainty;  // absolute; 0 for a number that is exact to double precision
  std::string dimension;
  std::string meaning;
};

/// What made a baseline, and how far a later result may depart from it.
struct Origin {
  std::string revision, compiler, machine, date;
  std::string reason;  // why this result was accepted
  double relative = 1e-9;
  double absolute = 1e-12;  // for values that are round-off, or zero

  double allowed(double value) const;
};

struct Reference {
  std::string id;
  std::string kind;  // one of reference_kinds()
  std::string source;
  std::string obtained;
  std::string command;                 // makes it again; empty for published numbers
  std::vector<std::string> citations;  // each begins with a key of the bibliography
  Place citations_at;
  std::optional<Origin> origin;  // of a baseline
  std::filesystem::path path;
  std::map<std::string, ReferenceValue> values;
  std::vector<io::CsvColumn> columns;    // of its data file, if it has one
  std::string sha256;                    // of the data file
  std::optional<observe::Record> table;  // of a baseline: what a study found, row by row
};

const std::vector<std::string>& reference_kinds();

/// What a target stated by a case may be beside that: `reading`, a number that the case reads into words
/// without one.
const std::vector<std::string>& target_kinds();

/// Reads `<id>.toml` and its data file. Throws InputError, also when the data do not match their checksum.
Reference read_reference(const std::filesystem::path& path);

/// The same of the document in `top`, which stands at `path`.
Reference read_reference(const io::Table& top, const std::filesystem::path& path);

/// The reference `id`: beside the case first, then in `shared`. Throws InputError at `asked_at` when in
/// neither.
Reference find_reference(const std::string& id, const std::filesystem::path& beside,
                         const std::filesystem::path& shared, const Place& asked_at);

/// Throws InputError at `key` of `asks` when the reference's data lack one of these columns.
void need_columns(const Reference& reference, const std::vector<std::string>& names, const io::Table& asks,
                  const std::string& key);

}  // namespace veriflex::engine
