/// From the rows of a sweep to the setting for an error that is asked for.
///
/// For each combination of an axis's words, error and run time are fitted in logarithms by
///
///   error = B + sum_a A_a x_a^(-p_a),   time = T + C product_a x_a^(q_a)
///
/// over the axes x_a that take numbers, of a relaxation time tau - 1/2; B = 0 where that predicts better. A
/// time is corrected by what the law misses at the rows around. How far that may be trusted is measured: each
/// row is predicted from the others.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "observe/record.hpp"

namespace veriflex::studies {

/// What a sweep has measured.
struct SweptRows {
  std::vector<observe::Column> axes;
  std::vector<double> error;    // 0 or more; not a number where the run did not complete
  std::vector<double> seconds;  // run time, the shortest of the repeats
  std::vector<double> memory;   // peak  [bytes]
};

/// Of a result's records `sweep` and `sweep_cost`.
SweptRows swept_rows(const observe::Record& sweep, const observe::Record& cost, const std::string& error);

/// Those with this value of this axis, a number or a word, which is a word then. Throws BadParameter("where")
/// where there are none.
SweptRows only(const SweptRows& rows, const std::string& axis, const std::string& value);

struct Wanted {
  double error;
  std::optional<double> budget;  // [s]
};

struct Advice {
  std::vector<std::string> setting;  // `key=value` of each axis
  double error, seconds, memory;     // as predicted; memory is that of the nearest row  [bytes]
  bool is_within;                    // the range of the sweep; else beyond it by a factor of two at most
  bool is_measured;                  // a row of the sweep
  double error_factor, time_factor;  // worst of each row of this combination predicted from the others
  std::size_t rows;                  // of this combination
  std::vector<std::string>
      failures;            // rows of these words that did not complete, the nearest first, at most two
  std::string limited_by;  // the axis whose term is most of the error; `nothing` for what no axis lowers
};

/// A fit that misses a left-out row by more than a factor of two is not used between rows: then each line
/// along the axis with the most values is fitted by itself, all other axes as they were swept, and where that
/// misses too only the rows themselves are offered. Of all rows that have, and of all that is predicted,
/// times error_factor, to have at most the wanted error the setting with the least time; no farther than a
/// factor of two beyond the swept range, there only where the error falls and the time rises, only along
/// axes of three values and more, and not in a cell of the grid of which a corner did not complete or is
/// tau = 1, where the fluid's algorithm is another. Whole numbers are taken by as_even(). Throws
/// NumericalFailure, with what can be reached instead, when there is none or it exceeds the budget, and when
/// the rows are too few for a fit.
Advice advise(const SweptRows& rows, const Wanted& wanted);

}  // namespace veriflex::studies
