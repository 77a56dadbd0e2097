/// Where what comes with the program lies: in the repository, or where it was installed to.
#pragma once

#include <filesystem>

namespace veriflex::repository {

/// The folder of all below: `share/veriflex` beside the folder of an installed program, wherever that was
/// moved to; else the source's.
const std::filesystem::path& root();

/// Folders of the case files, and of references, ledger and bibliography.
const std::filesystem::path& cases();
const std::filesystem::path& references();

/// The script that draws the report.
const std::filesystem::path& report_script();

}  // namespace veriflex::repository
