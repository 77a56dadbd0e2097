/// The table that rows of a study make, and what a study adds to what one run of the case can measure.
#pragma once

#include <limits>

#include "engine/asked.hpp"
#include "studies/grid.hpp"
#include "studies/rows.hpp"

namespace veriflex::studies {

/// In the place of a number that there is none of.
inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Appends what was measured in each row to the columns that lead it: outcome, each metric of any row (not a
/// number where a row lacks it), work, message.
observe::Record table_of(std::string name, std::string title, std::vector<observe::Column> leading,
                         const std::vector<Row>& rows);

/// Record `<name>_cost`: wall and processor time and memory of each row. Times never enter a check, so they
/// stand in a table of their own.
observe::Record cost_table(const std::string& name, const Timing& timing,
                           std::vector<observe::Column> leading, const std::vector<Row>& rows);

/// What the checks of a case ask of its study.
struct Questions {
  std::vector<engine::Asked> asked;
  observe::Observations declares;  // the numbers, and the table without rows

  /// Adds the numbers to what was seen. Throws NumericalFailure when the table does not give one.
  void answer(const observe::Record& table, observe::Observations& seen) const;
};

/// Of these `[[check]]` of the case. `leading` are the columns that the study's table has before what one run
/// measures. Throws InputError at a check that asks for what the table cannot have.
Questions read_questions(const std::vector<io::Table>& checks, const std::string& name,
                         const std::vector<observe::Column>& leading,
                         const std::vector<observe::Metric>& measured_by_a_run);

/// Throws InputError when a reader has refused all rows: the study, not the scene, is then what cannot be
/// used.
void refuse_if_none_was_read(const std::vector<Row>& rows);

/// Metrics `rows` and `rows_completed`.
void count_rows(const std::vector<Row>& rows, observe::Observations& seen);

/// Warns of rows that did not come to their end.
void warn_of_failures(const std::vector<Row>& rows, Progress& progress);

/// Makes the study of one run one of these runs, which measures what its checks ask for, and those two
/// metrics.
void declare(engine::Study& study, const Questions& questions, std::vector<std::vector<std::string>> runs,
             const Timing& timing);

}  // namespace veriflex::studies
