/// Two runs that are compared, as `veriflex diff` tells of them.
#pragma once

#include <string>
#include <vector>

#include "engine/difference.hpp"

namespace veriflex {

/// A run: where it stands, and what made it.
struct DiffSide {
  std::string where;
  std::size_t results;
  std::vector<std::string> made_by;     // program, compiler, threads and machine; each once
  std::vector<std::string> unreadable;  // a message per file
};

struct Diff {
  DiffSide before, after;
  engine::RunDifference difference;

  /// All results could be read, and nothing but times differs.
  bool is_same() const {
    return before.unreadable.empty() && after.unreadable.empty() && difference.is_same();
  }
};

/// The lines of a table, largest first: of which case, and what changed.
struct DiffRow {
  std::string id, what, before, after, change;
};
/// One question to the difference of two runs, with its answer.
struct DiffTable {
  std::string title;
  std::vector<DiffRow> rows;
};

/// All that differs, in the order in which it matters; tables without rows are left out.
std::vector<DiffTable> tables_of(const engine::RunDifference& difference);

/// How many numbers and cases there are, and how many are the same.
std::string summary_of(const Diff& diff);

/// One page that needs nothing else.
std::string html_of(const Diff& diff);

}  // namespace veriflex
