/// What a run measured: tables of named, dimensioned columns, and single numbers.
#pragma once

#include <string>
#include <vector>

namespace veriflex::observe {

struct Column {
  std::string name;
  std::string symbol;
  std::string dimension;  // such as "M L^-1 T^-2"; "1" for a pure number
  std::string meaning;
  std::vector<double> values;
  std::vector<std::string> texts{};  // of a column of words, which has no values

  std::size_t size() const { return texts.empty() ? values.size() : texts.size(); }
};

struct Record {
  std::string name;
  std::string title;
  std::vector<Column> columns;  // of equal length

  /// The column of that name, or null.
  const Column* find(const std::string& column) const;
  /// Appends one row; as many values as columns.
  void append(const std::vector<double>& row);
};

struct Metric {
  std::string name;
  double value;
  std::string dimension;
  std::string meaning;
};

struct Observations {
  std::vector<Record> records;
  std::vector<Metric> metrics;
  std::vector<Metric> declared{};  // what set() may set; their values mean nothing

  const Record* record(const std::string& name) const;
  const Metric* metric(const std::string& name) const;

  /// Gives a declared metric its value, once. Throws std::logic_error for any other name.
  void set(const std::string& name, double value);
  /// The record of that name, to be filled. Throws std::logic_error when there is none.
  Record& open(const std::string& name);
};

}  // namespace veriflex::observe
