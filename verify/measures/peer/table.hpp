/// The table that another program computed, and how far this one is off.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/reduce.hpp"
#include "base/vec.hpp"
#include "engine/reference.hpp"
#include "io/document.hpp"
#include "observe/record.hpp"

namespace veriflex::measures::peer {

/// The largest magnitude of what was added; a NaN stays.
struct Largest {
  double value = 0.0;
  void add(double x) { value = worse(value, std::abs(x)); }
};

/// Errors of one quantity over the rows, relative to the largest magnitude that the peer has in a row that
/// counts; 0 where both have nothing.
struct Errors {
  std::vector<double> by_row;
  double largest = 0.0;                   // over the rows that count
  std::optional<double> largest_clamped;  // over the others that have an answer here; none without any
};

/// A row that is flagged as clamped and has no answer here has a difference that is not a number.
Errors relative_errors(const std::vector<double>& difference, const std::vector<double>& peer,
                       const std::vector<bool>& clamped);

/// The table of a reference, whose columns are asked for by name. A row in which the other program is known
/// not to compute the stated potential carries `clamped` = 1: it does not enter the errors, and need not have
/// an answer here.
class PeerTable {
 public:
  /// The reference `id`, which the case names as `key`. Throws InputError when it has no table, or none of
  /// its rows is compared.
  PeerTable(const io::Table& peer, const std::string& key, const std::string& id);

  /// All columns that a kind needs, or an InputError at the case's key.
  void need(const std::vector<std::string>& names) const;

  const std::vector<double>& operator[](const std::string& name) const { return *find(name); }
  std::size_t rows() const { return reference_.columns.front().values.size(); }

  /// Columns `prefix` + x, y, z + `suffix` as vectors.
  Positions vectors(const std::string& prefix, const std::string& suffix) const;

  /// Columns of whole numbers from 0 that count something. Throws InputError at the case's key.
  std::vector<std::int64_t> counts(const std::string& name) const;

  /// Of what was computed here for each row, against that column.
  Errors errors(const std::vector<double>& ours, const std::string& column) const;

  bool clamped(std::size_t row) const;
  std::vector<bool> clamped() const;  // of all rows
  bool has_clamped() const;           // any
  [[noreturn]] void fail(const std::string& problem, const std::string& why,
                         const std::string& suggestion) const;

 private:
  const std::vector<double>* find(const std::string& name) const;

  io::Table peer_;
  std::string key_;
  engine::Reference reference_;
};

/// Names of the columns that vectors() reads.
std::vector<std::string> xyz(const std::string& prefix, const std::string& suffix);

std::vector<std::string> joined(std::vector<std::string> names,
                                const std::vector<std::vector<std::string>>& more);

/// What stands where a row that is left out has no answer.
inline constexpr double unanswered = std::numeric_limits<double>::quiet_NaN();

inline constexpr const char* of_the_largest = "largest error over the largest magnitude in the peer's table";

std::vector<double> plus(std::vector<double> a, const std::vector<double>& b);
std::vector<double> minus(std::vector<double> a, const std::vector<double>& b);
std::vector<double> lengths(const Positions& vectors);

/// What every comparison counts, `rows` and `clamped_rows`, declared and set.
void declare_rows(observe::Observations& all);
void count_rows(const PeerTable& table, observe::Observations& seen);

}  // namespace veriflex::measures::peer
