/// A report of the cases of one command in the form of JUnit, which servers of continuous integration read.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/result.hpp"
#include "engine/stored_result.hpp"

namespace veriflex {

/// What such a report says of a case.
struct JunitCase {
  std::string name, driver;
  double seconds;
  std::string failed;      // the checks that did, a line each
  std::string error_kind;  // empty unless the case has no answer
  std::string error;
  std::string notes;  // findings, and that nothing was judged
};

JunitCase junit_case(const engine::Result& result);
JunitCase junit_case(const engine::StoredResult& result);

/// Writes the file, aside and renamed. Throws OutputError.
void write_junit(const std::filesystem::path& file, const std::vector<JunitCase>& cases);

}  // namespace veriflex
