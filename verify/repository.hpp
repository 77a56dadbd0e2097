/// Where the repository keeps what the commands read.
#pragma once

#include <filesystem>

namespace veriflex::repository {

/// Folders of the case files, and of references, ledger and bibliography.
const std::filesystem::path& cases();
const std::filesystem::path& references();

}  // namespace veriflex::repository
