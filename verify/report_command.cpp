#include "report_command.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <vector>

#include "base/error.hpp"
#include "base/say.hpp"
#include "claims_command.hpp"
#include "engine/child.hpp"
#include "engine/result.hpp"
#include "exit_code.hpp"
#include "repository.hpp"
#include "results_json.hpp"
#include "run_cases.hpp"

namespace veriflex {

namespace fs = std::filesystem;

// The report is drawn by a script from the result files and the ledger; it inherits standard output and ends
// with its parent.
int report_command(const std::string& results, const std::string& report, bool json) {
  int code = exit_code::success;
  std::vector<std::string> words{repository::report_script().string(), results};
  std::optional<engine::FileInMemory> ledger;
  std::error_code unknown;
  try {
    // The script names files and folders that cannot be read.
    if (fs::is_directory(results, unknown)) ledger.emplace(claims_json({results}));
    if (ledger) words.insert(words.end(), {"--claims", ledger->path()});
  } catch (const std::exception&) {
    // The results are worth a page even when the ledger cannot be read.
    const engine::Failure why = engine::current_failure();
    complain("{}. The report goes without the ledger of claims", why.message);
    code = exit_code::of_error(why.kind);
  }
  if (fs::is_directory(results, unknown)) {
    const fs::path beside = report.empty() ? fs::path(results) : fs::path(report).parent_path();
    code = exit_code::first_of(code, attempted([&] { write_results_json(results, beside); }));
  }
  if (json) words.emplace_back("--json");
  if (!report.empty()) words.insert(words.end(), {"--out", report});
  words.insert(words.end(), {"--parent", std::to_string(getpid())});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::fflush(stdout);
  pid_t child = 0;
  const int failed = posix_spawn(&child, words[0].c_str(), nullptr, nullptr, arguments.data(), environ);
  if (failed != 0) {
    throw OutputError(words[0], fmt::format("cannot be run ({})", std::strerror(failed)),
                      "It needs Debian's python3; scripts/install-deps installs all that is needed");
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  if (!WIFEXITED(status))
    throw OutputError(words[0], "was killed before the report was complete", "Run it again");
  // A script that breaks off (a missing Python module) exits with 1, which here would mean a failed check.
  const int drawn = WEXITSTATUS(status);
  return exit_code::first_of(code, drawn == exit_code::check_failed ? exit_code::output : drawn);
}

}  // namespace veriflex
