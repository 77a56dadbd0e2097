#include "repository.hpp"

namespace veriflex::repository {

namespace fs = std::filesystem;

const fs::path& root() {
  static const fs::path folder = [] {
    std::error_code unknown;
    const fs::path program = fs::read_symlink("/proc/self/exe", unknown);
    const fs::path installed = program.parent_path().parent_path() / "share" / "veriflex";
    return !unknown && fs::is_directory(installed / "cases", unknown) ? installed
                                                                      : fs::path(VERIFLEX_SOURCE_DIR);
  }();
  return folder;
}

const fs::path& cases() {
  static const fs::path folder = root() / "cases";
  return folder;
}

const fs::path& references() {
  static const fs::path folder = root() / "reference";
  return folder;
}

const fs::path& report_script() {
  static const fs::path file = root() / "scripts" / "report.py";
  return file;
}

}  // namespace veriflex::repository
