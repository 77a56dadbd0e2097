/// The axes of a study: which keys of a case take which values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/document.hpp"
#include "observe/record.hpp"

namespace veriflex::studies {

/// One key of the case and its values, or several keys that change together. The first key names the axis.
struct Axis {
  std::vector<std::string> keys;
  std::vector<std::vector<std::string>> values;  // per value one TOML text per key
  std::vector<double> numbers;                   // of the first key; empty where it takes no numbers

  const std::string& name() const { return keys.front(); }
  std::size_t size() const { return values.size(); }
};

/// `axes` of a study's table: entries with `key` (or `keys`) and `values`. Throws InputError: no value, a
/// value or key that stands there twice, more than 100,000 rows.
std::vector<Axis> read_axes(const io::Table& study, const std::string& key = "axes");

/// One combination of values: where each axis stands. The last axis runs fastest.
using Cell = std::vector<std::size_t>;
std::vector<Cell> cells(const std::vector<Axis>& axes);

/// What sets a case to that combination, as `--set` takes it.
std::vector<std::string> settings(const std::vector<Axis>& axes, const Cell& cell);

/// The multiple next to a value of half of the power of two that two whole numbers share, of 16 at most, of
/// no less than `least` where they share that: a fluid's row of nodes that vectors do not divide takes up to
/// six times as long.
double as_even(double value, double below, double above, double least = 4.0);

/// The values of an axis's keys where the first has this value: as they are listed, or between and beyond
/// listed ones by the power law through the two nearest, whole numbers by as_even(); of a list each number.
/// Nothing where a key takes no positive numbers.
std::optional<std::vector<std::string>> values_at(const Axis& axis, const std::string& first);

/// Columns for the axes of a table, without rows, and their values in one row.
std::vector<observe::Column> columns_of(const std::vector<Axis>& axes);
void append(std::vector<observe::Column>& columns, const std::vector<Axis>& axes, const Cell& cell);

/// Of a study's table: its axes are the columns before the outcome.
std::vector<observe::Column> axes_of(const observe::Record& table);

/// The word that a TOML text is, `double` of `"double"`; other values as they stand.
std::string bare(const std::string& value);

/// `relaxation_time = 0.6, 1 and 2 more; nodes = 16, 32`.
std::string in_words(const std::vector<Axis>& axes);

}  // namespace veriflex::studies
