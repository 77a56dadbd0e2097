/// The symbols of the field as other names of a case's keys: `fluid.tau` for `fluid.relaxation_time`.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "io/document.hpp"

namespace veriflex::engine {

/// A symbol, and the key that it stands for in the tables called `table`. A bond law's are its own
/// (bond::ParameterInfo), in `bond` and `compared_bond`.
struct Symbol {
  std::string table, symbol, key;
};
const std::vector<Symbol>& symbols();

/// The document of a case: io::parse_document() that knows these symbols, in the file and in `overrides`.
io::Table parse_case(const std::string& text, const std::string& file,
                     const std::vector<std::string>& overrides = {});

}  // namespace veriflex::engine
