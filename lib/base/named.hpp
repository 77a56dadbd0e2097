/// The values of an enumeration with the names that a user gives them: one table for each, read by whoever
/// reads or prints a value.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace veriflex {

template <class Enum>
struct Named {
  Enum value;
  std::string_view name;  // in a case file
  std::string_view id;    // the same where only letters, digits and underscores may stand
  std::string_view text;  // in words
};

/// Of a table of Named, in its order.
template <class Table>
std::vector<std::string> names_of(const Table& table) {
  std::vector<std::string> names;
  for (const auto& row : table) names.emplace_back(row.name);
  return names;
}

/// The row of that name, which is one of names_of(table).
template <class Table>
const auto& row_named(const Table& table, std::string_view name) {
  auto row = table.begin();
  while (row->name != name) ++row;
  return *row;
}

/// The row of a value; every value has one.
template <class Table, class Enum>
const auto& row_of(const Table& table, Enum value) {
  auto row = table.begin();
  while (row->value != value) ++row;
  return *row;
}

}  // namespace veriflex
