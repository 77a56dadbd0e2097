/// Numeric tables as comma-separated text: `#` comments, one line of column names, rows of numbers. A
/// byte order mark before it all is passed over.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace veriflex::io {

struct CsvColumn {
  std::string name;
  std::vector<double> values;
};

/// `text` without its sign where that is a plus, which std::from_chars does not know.
std::string_view without_plus(std::string_view text);

/// The table in `text`; `file` is only for messages.
/// Throws InputError: no columns, repeated or empty names, rows of another length, anything that is not a
/// finite number.
std::vector<CsvColumn> parse_csv(std::string_view text, const std::string& file);

}  // namespace veriflex::io
