/// What is in a group of an HDF5 file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace veriflex::io {

/// The groups and data sets in a group, by name; of a file that Hdf5File has opened, and so verified. Throws
/// InputError where there is no such group.
std::vector<std::string> hdf5_names(const std::filesystem::path& file, const std::string& group);

}  // namespace veriflex::io
