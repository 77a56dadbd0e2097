#include "io/csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/error.hpp"
#include "base/mutant.hpp"

namespace veriflex::io {

namespace {

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

struct Field {
  std::string_view text;
  unsigned column;  // 1-based position in the line
};

std::vector<Field> fields_of(std::string_view line) {
  std::vector<Field> fields;
  std::size_t start = 0;
  for (;;) {
    const std::size_t comma = line.find(',', start);
    fields.push_back({trimmed(line.substr(start, comma - start)), static_cast<unsigned>(start + 1)});
    if (comma == std::string_view::npos) return fields;
    start = comma + 1;
  }
}

double number(const Field& field, const Place& place) {
  double value = 0.0;
  const std::string_view digits = without_plus(field.text);
  const char* end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, value);
  if (error != std::errc{} || stop != end || !std::isfinite(value)) {
    throw InputError(place, fmt::format("'{}' is not a finite number", field.text), "the table is numeric",
                     "Write it like 1.5e-3");
  }
  return planted(Mutant::csv_sign_lost) ? std::abs(value) : value;
}

}  // namespace

std::string_view without_plus(std::string_view text) {
  return text.size() > 1 && text[0] == '+' && text[1] != '-' ? text.substr(1) : text;
}

std::vector<CsvColumn> parse_csv(std::string_view text, const std::string& file) {
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
  std::vector<CsvColumn> columns;
  unsigned line_number = 0;
  while (!text.empty()) {
    const std::size_t newline = text.find('\n');
    const std::string_view line = trimmed(text.substr(0, newline));
    text.remove_prefix(newline == std::string_view::npos ? text.size() : newline + 1);
    ++line_number;
    if (line.empty() || line.front() == '#') continue;
    const std::vector<Field> fields = fields_of(line);
    if (columns.empty()) {
      for (const Field& field : fields) {
        const bool repeated = std::any_of(columns.begin(), columns.end(),
                                          [&](const CsvColumn& c) { return c.name == field.text; });
        if (field.text.empty() || repeated) {
          throw InputError(
              {file, line_number, field.column},
              field.text.empty() ? "a column has no name" : fmt::format("column '{}' twice", field.text),
              "the first line that is no comment names the columns", "Name every column once");
        }
        columns.push_back({std::string(field.text), {}});
      }
      continue;
    }
    if (fields.size() != columns.size()) {
      throw InputError({file, line_number, 1}, fmt::format("{} fields", fields.size()),
                       fmt::format("the table has {} columns", columns.size()), "Complete or remove the row");
    }
    for (std::size_t i = 0; i < fields.size(); ++i) {
      columns[i].values.push_back(number(fields[i], {file, line_number, fields[i].column}));
    }
  }
  if (columns.empty() || columns.front().values.empty()) {
    throw InputError({file}, "holds no table", "column names and at least one row are needed",
                     "Look at the file");
  }
  return columns;
}

}  // namespace veriflex::io
