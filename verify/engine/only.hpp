/// The only value of a data set that is to have one.
#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

#include "base/error.hpp"

namespace veriflex::engine {

/// Throws InputError, which names the file, for none or several: the checksum says that it is as it was
/// written, not by whom.
template <class Value>
Value only(const std::vector<Value>& values, const std::string& file, const std::string& path) {
  if (values.size() == 1) return values.front();
  throw InputError({file}, fmt::format("{} values in {}", values.size(), path),
                   "the file is not as its schema says", "Run the case again");
}

}  // namespace veriflex::engine
