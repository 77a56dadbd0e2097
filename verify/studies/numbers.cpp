#include "studies/numbers.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "base/reduce.hpp"
#include "engine/convergence.hpp"
#include "studies/grid.hpp"

namespace veriflex::studies {

namespace {

using engine::Asked;
using engine::Pinned;
using observe::Column;
using observe::Record;
using Rows = std::vector<std::size_t>;

[[noreturn]] void fail(const Asked& asked, const std::string& why) {
  throw NumericalFailure(fmt::format("no {}: {}", asked.name(), why));
}

bool holds(const Column& column, std::size_t row, const std::string& value) {
  if (!column.texts.empty()) return column.texts[row] == bare(value);
  const io::Table given = io::parse_document("value = " + value, "");
  return column.values[row] == given.number("value");
}

Rows matching(const Asked& asked, const Record& table, const Pinned& where) {
  Rows rows;
  const std::size_t count = table.columns.front().size();
  for (std::size_t row = 0; row < count; ++row) {
    const bool all = std::all_of(where.begin(), where.end(), [&](const auto& pin) {
      return holds(*table.find(pin.first), row, pin.second);
    });
    if (all) rows.push_back(row);
  }
  if (rows.empty()) fail(asked, "the table has no such row");
  return rows;
}

double only(const Asked& asked, const Record& table, const Pinned& where) {
  const Rows rows = matching(asked, table, where);
  if (rows.size() > 1) fail(asked, fmt::format("{} rows are meant: pin more axes with 'where'", rows.size()));
  return table.find(asked.metric)->values[rows.front()];
}

// The rows of `where`, with what `over` says instead.
Pinned pinned_over(const Asked& asked) {
  Pinned pinned = asked.over;
  for (const auto& pin : asked.where) {
    const bool said =
        std::any_of(pinned.begin(), pinned.end(), [&](const auto& p) { return p.first == pin.first; });
    if (!said) pinned.push_back(pin);
  }
  return pinned;
}

// Values of the metric, and of the axis, over the rows.
struct Curve {
  std::vector<double> x, y;
};

// The values of an axis. One that is no number, `nan` among them, makes all of them words.
const std::vector<double>& numbers_of_axis(const Asked& asked, const Record& table, const std::string& axis) {
  const std::vector<double>& values = table.find(axis)->values;
  if (values.empty()) fail(asked, fmt::format("not all values of {} are numbers", axis));
  return values;
}

Curve curve_of(const Asked& asked, const Record& table) {
  Curve curve;
  const std::vector<double>& axis = numbers_of_axis(asked, table, asked.along);
  for (const std::size_t row : matching(asked, table, asked.where)) {
    const double x = axis[row];
    if (std::find(curve.x.begin(), curve.x.end(), x) != curve.x.end()) {
      fail(asked, fmt::format("several rows at {} = {}: pin the other axes with 'where'", asked.along, x));
    }
    curve.x.push_back(x);
    curve.y.push_back(table.find(asked.metric)->values[row]);
    if (std::isnan(curve.y.back()))
      fail(asked, fmt::format("the row at {} = {} has no value", asked.along, x));
  }
  return curve;
}

double along_axis(const Asked& asked, const Record& table) {
  const Curve curve = curve_of(asked, table);
  const bool three = (asked.of == "gci" || asked.of == "richardson") && asked.order == 0.0;
  const std::size_t needed = three ? 3 : 2;
  if (curve.x.size() < needed) fail(asked, fmt::format("{} rows, {} are needed", curve.x.size(), needed));
  if (asked.of == "exponent") {
    const auto positive = [](double v) { return v > 0.0; };
    if (!std::all_of(curve.x.begin(), curve.x.end(), positive) ||
        !std::all_of(curve.y.begin(), curve.y.end(), positive)) {
      fail(asked, "not all values are positive");
    }
    return engine::power_law(curve.x, curve.y).exponent;
  }
  const std::vector<double> h = spacings(curve.x);
  if (h.empty()) fail(asked, "the axis does not go from coarse to fine");
  double value = 0.0;
  if (asked.of == "order") {
    value = engine::orders(h, curve.y).back();
    if (std::isnan(value)) fail(asked, "an error is zero or negative");
  } else if (asked.order > 0.0) {
    value = asked.of == "gci" ? engine::gci(h, curve.y, asked.order)
                              : engine::richardson(h, curve.y, asked.order);
  } else {
    const engine::Convergence found = engine::converge(h, curve.y);
    value = asked.of == "richardson" ? found.richardson : found.gci;
    if (std::isnan(value)) fail(asked, "the three finest rows do not converge monotonically");
  }
  return value;
}

double over_rows(const Asked& asked, const Record& table) {
  double result = asked.of == "min" ? INFINITY : asked.of == "max" ? -INFINITY : 0.0;
  const Rows rows = matching(asked, table, asked.where);
  for (const std::size_t row : rows) {
    const double value = table.find(asked.metric)->values[row];
    if (asked.of == "min") {
      result = lesser(result, value);
    } else if (asked.of == "max") {
      result = planted(Mutant::largest_is_last) ? value : worse(result, value);
    } else {
      result += value / static_cast<double>(rows.size());
    }
  }
  return result;
}

double value_of(const Asked& asked, const Record& table) {
  if (asked.of == "value") return only(asked, table, asked.where);
  if (asked.of == "ratio")
    return only(asked, table, planted(Mutant::ratio_of_a_row_to_itself) ? pinned_over(asked) : asked.where) /
           only(asked, table, pinned_over(asked));
  return asked.along.empty() ? over_rows(asked, table) : along_axis(asked, table);
}

}  // namespace

std::vector<double> spacings(const std::vector<double>& axis) {
  if (axis.size() < 2 || !(*std::min_element(axis.begin(), axis.end()) > 0.0)) return {};
  if (std::is_sorted(axis.begin(), axis.end(), std::greater_equal<>())) return axis;
  if (!std::is_sorted(axis.begin(), axis.end(), std::less_equal<>())) return {};
  std::vector<double> h;
  for (const double x : axis) h.push_back(planted(Mutant::spacings_not_inverted) ? x : 1.0 / x);
  return h;
}

observe::Metric number(const Asked& asked, const Record& table) {
  const Column* metric = table.find(asked.metric);
  if (metric == nullptr || metric->values.empty()) fail(asked, "no row measured it");
  const bool pure = asked.of == "order" || asked.of == "exponent" || asked.of == "ratio";
  return {asked.name(), value_of(asked, table), pure ? "1" : metric->dimension, metric->meaning};
}

Record numbers_across(const Asked& asked, const Record& table) {
  const Column& axis = *table.find(asked.across);
  const Column* metric = table.find(asked.metric);
  Record curve{asked.name(),
               fmt::format("{} over {}", asked.name(), asked.across),
               {{engine::last_part(asked.across), "", axis.dimension, axis.meaning, {}},
                {asked.metric, "", metric == nullptr ? "1" : metric->dimension, asked.name(), {}}}};
  for (const double x : numbers_of_axis(asked, table, asked.across)) {
    std::vector<double>& done = curve.columns[0].values;
    if (std::find(done.begin(), done.end(), x) != done.end()) continue;
    Asked here = asked;
    here.where.emplace_back(asked.across, fmt::format("{}", x));
    const double y = number(here, table).value;
    curve.append({x, y});
  }
  return curve;
}

void check_asked(const Asked& asked, const Record& empty_table, const io::Table& check) {
  std::vector<std::string> names;
  for (const Column& column : empty_table.columns) names.push_back(column.name);
  const auto need = [&](const std::string& key, const std::string& name) {
    if (empty_table.find(name) != nullptr) return;
    const std::string near = nearest_name(name, names);
    check.fail(key, fmt::format("the study's table has no '{}'", name),
               fmt::format("it has: {}", fmt::join(names, ", ")),
               near.empty() ? "Choose one of these" : fmt::format("Did you mean '{}'?", near));
  };
  need(asked.across.empty() ? "metric" : "curve", asked.metric);
  if (!asked.along.empty()) need("along", asked.along);
  if (!asked.across.empty()) need("curve", asked.across);
  for (const auto& pin : asked.where) need("where", pin.first);
  for (const auto& pin : asked.over) need("over", pin.first);
}

}  // namespace veriflex::studies
