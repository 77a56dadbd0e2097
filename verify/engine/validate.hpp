/// Checks cases, references, ledger and bibliography against each other, without running anything.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/case.hpp"

namespace veriflex::engine {

/// Everything wrong with these cases and the references they name, one message each. What cases cite is
/// looked up in the bibliography only for those in `case_folder`: a case elsewhere may have sources of its
/// own.
std::vector<std::string> problems_of(const std::vector<std::filesystem::path>& cases,
                                     const std::filesystem::path& case_folder,
                                     const std::filesystem::path& reference_folder, const Readers& readers);

/// Everything wrong with all cases and references of a repository: as problems_of(), and references that no
/// case uses, and where the ledger's `judged_by` and the claims cited by cases disagree.
std::vector<std::string> problems_of_repository(const std::filesystem::path& case_folder,
                                                const std::filesystem::path& reference_folder,
                                                const Readers& readers);

}  // namespace veriflex::engine
