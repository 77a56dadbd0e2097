/// Documents whose keys have other names, too.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "io/document.hpp"

namespace veriflex::io {

/// The key that `word` stands for in the tables called `table`, wherever they stand; empty where it is no
/// other name of a key. What is in the document under such a name is read under that key.
using Synonyms = std::function<std::string_view(std::string_view table, std::string_view word)>;

/// As parse_document() of io/document.hpp, in the text, in `overrides` and in Table::shown(). Throws
/// InputError, also where a key stands under two names, with both places.
Table parse_document(const std::string& text, const std::string& file,
                     const std::vector<std::string>& overrides, const Synonyms& synonyms);

}  // namespace veriflex::io
