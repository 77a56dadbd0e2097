/// Columns of a table in a file, and counts, which may be anything: the checksum says that the file is as it
/// was written, not by whom.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "io/hdf5.hpp"
#include "observe/record.hpp"

namespace veriflex::engine {

/// The columns of one group, which must be of one length. Throws InputError, which names the file, where they
/// are not, and as Hdf5File does.
class Columns {
 public:
  Columns(const io::Hdf5File& file, std::string group) : file_(file), group_(std::move(group)) {}

  std::vector<std::string> words_of(const std::string& name) { return held(file_.texts(path_of(name))); }
  std::vector<double> numbers_of(const std::string& name) { return held(file_.numbers(path_of(name))); }
  std::string path_of(const std::string& name) const { return group_ + "/" + name; }
  std::size_t rows() const { return rows_.value_or(0); }

 private:
  template <class Values>
  Values held(Values values) {
    if (!rows_) rows_ = values.size();
    if (*rows_ == values.size()) return values;
    throw InputError({file_.name()}, fmt::format("the columns of {} differ in length", group_),
                     "the file is not as its schema says", "Run the case again");
  }

  const io::Hdf5File& file_;
  std::string group_;
  std::optional<std::size_t> rows_;
};

[[noreturn]] inline void lacks_column(const io::Hdf5File& file, const observe::Record& table,
                                      const std::string& what) {
  throw InputError({file.name()}, fmt::format("there are no {} in {}", what, table.name),
                   "the file is not as its schema says", "Run the case again");
}

/// The numbers of a column that a table of `file` is to have. Throws InputError, which names the file, where
/// there is none, or one of words.
inline const std::vector<double>& numbers_in(const observe::Record& table, const std::string& name,
                                             const io::Hdf5File& file) {
  const observe::Column* found = table.find(name);
  if (found == nullptr || !found->texts.empty()) lacks_column(file, table, fmt::format("numbers '{}'", name));
  return found->values;
}

/// The words of such a column, likewise.
inline const std::vector<std::string>& words_in(const observe::Record& table, const std::string& name,
                                                const io::Hdf5File& file) {
  const observe::Column* found = table.find(name);
  if (found == nullptr || !found->values.empty()) lacks_column(file, table, fmt::format("words '{}'", name));
  return found->texts;
}

/// The metrics that such a group holds.
inline std::vector<observe::Metric> read_metrics(const io::Hdf5File& file, const std::string& group) {
  Columns columns(file, group);
  const std::vector<std::string> names = columns.words_of("name"), dimensions = columns.words_of("dimension"),
                                 meanings = columns.words_of("meaning");
  const std::vector<double> values = columns.numbers_of("value");
  std::vector<observe::Metric> metrics;
  for (std::size_t i = 0; i < columns.rows(); ++i) {
    metrics.push_back({names[i], values[i], dimensions[i], meanings[i]});
  }
  return metrics;
}

/// A number that counts something. Throws InputError for a negative one or a fraction, and beyond 2^53.
inline std::uint64_t count_of(double number, const io::Hdf5File& file, const std::string& path) {
  if (number >= 0.0 && number <= 0x1p53 && number == static_cast<double>(static_cast<std::uint64_t>(number)))
    return static_cast<std::uint64_t>(number);
  throw InputError({file.name()}, fmt::format("{} in {}", number, path),
                   "that is no count, and the file is not as its schema says", "Run the case again");
}

}  // namespace veriflex::engine
