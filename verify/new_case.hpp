/// `veriflex new`: a case to start from.
#pragma once

#include <filesystem>
#include <string>

namespace veriflex {

/// A case of the driver, called `id`, that validates and runs: the shortest of the folder, a quick one if
/// there is one, without its study, its references and all but its first check, with the meaning of each key
/// from the folder's README.md. Throws InputError when the folder has no case of that driver.
std::string new_case(const std::string& driver, const std::string& id, const std::filesystem::path& folder);

}  // namespace veriflex
