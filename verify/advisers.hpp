/// Which stored sweeps can advise a case that was not swept itself.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/document.hpp"

namespace veriflex {

struct Adviser {
  std::filesystem::path result;
  std::string id;
  std::vector<std::string> differences;  // `key: theirs, here ...`, beside the sweep's own axes
};

/// Of the results in `out` the sweeps with an error, of the same driver, bond laws and words in the driver's
/// own table, the most alike first. What a case says of itself, its checks and its studies do not count.
std::vector<Adviser> advisers_of(const io::Table& top, const std::filesystem::path& out);

}  // namespace veriflex
