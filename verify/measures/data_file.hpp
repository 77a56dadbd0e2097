/// Files of data that a case names.
#pragma once

#include <filesystem>
#include <string>

#include "io/document.hpp"

namespace veriflex::measures {

/// The file that `key` of a case's table names: beside the case first, then in `reference/`. Throws
/// InputError when in neither.
std::filesystem::path data_file(const io::Table& table, const std::string& key);

}  // namespace veriflex::measures
