/// Which stored sweeps can advise a case that was not swept itself.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/document.hpp"
#include "io/hdf5.hpp"
#include "studies/advise.hpp"
#include "studies/grid.hpp"

namespace veriflex {

struct Adviser {
  std::filesystem::path result;
  std::vector<std::string> differences;  // `key: theirs, here ...`, beside the sweep's own axes
};

/// Of the results in `out` the sweeps with an error, of the same driver, bond laws and words in the driver's
/// own table, the most alike first. What a case says of itself, its checks and its studies do not count.
std::vector<Adviser> advisers_of(const io::Table& top, const std::filesystem::path& out);

/// The axes of the own sweep of the case `top` that is stored in `file`; none where the sweep was put over it
/// by a command.
std::vector<studies::Axis> own_axes(const io::Table& top, const io::Hdf5File& file);

/// The metric that is the error of the sweep that is stored in `file`. Throws InputError where it has none.
std::string error_of_sweep(const io::Hdf5File& file);

/// The rows of the sweep that is stored in `file`. Throws InputError, with the path, where it has no error.
studies::SweptRows rows_of(const io::Hdf5File& file, const std::string& path);

}  // namespace veriflex
