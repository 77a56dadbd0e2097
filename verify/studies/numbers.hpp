/// Numbers of the table that a study leaves: of one of its rows, of all, of how one column follows another.
#pragma once

#include "engine/asked.hpp"
#include "observe/record.hpp"

namespace veriflex::studies {

/// Spacings that grids at these values of an axis have, up to a factor: values that rise count a resolution,
/// h = 1/x; values that fall are spacings. Axes go from coarse to fine. Empty when they do neither or one is
/// not positive.
std::vector<double> spacings(const std::vector<double>& axis);

/// What a check asks of the table. With h the spacings along the axis:
///   order       p of value ~ h^p, an error, between the two finest rows
///   richardson  limit h -> 0 from the three finest rows, or from two where the order is given; gci the
///               half-width within which it lies, likewise                            [roache-1994; celik-2008]
///   exponent    p of value ~ axis^p, least squares over all rows
///   ratio       the row of `where` over the one of `over`
/// Throws NumericalFailure when the rows do not give the number, and says why.
observe::Metric number(const engine::Asked& asked, const observe::Record& table);

/// That number for each value of the axis across: columns called after the axis's last part and the metric.
observe::Record numbers_across(const engine::Asked& asked, const observe::Record& table);

/// Refuses what no run could give: a column that the table will not have, an axis without numbers, values
/// that no row has. Throws InputError at the check.
void check_asked(const engine::Asked& asked, const observe::Record& empty_table, const io::Table& check);

}  // namespace veriflex::studies
