#include "engine/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/mutant.hpp"
#include "base/reduce.hpp"

namespace veriflex::engine {

double max_curve_error(const Curve& curve, double floor, const Reference& reference,
                       const observe::Observations& seen) {
  const std::string measure = curve.record + "." + curve.y;
  const auto column = [&](const std::string& name) -> const std::vector<double>& {
    return std::find_if(reference.columns.begin(), reference.columns.end(),
                        [&](const io::CsvColumn& c) { return c.name == name; })
        ->values;
  };
  const observe::Record* record = seen.record(curve.record);
  const observe::Column* x = record == nullptr ? nullptr : record->find(curve.x);
  const observe::Column* y = record == nullptr ? nullptr : record->find(curve.y);
  if (x == nullptr || y == nullptr) {
    throw NumericalFailure(fmt::format("the run recorded no {} against {}", measure, curve.x));
  }
  const std::vector<double>& x_wanted = column(curve.x);
  const std::vector<double>& y_wanted = column(curve.y);
  double largest = 0.0;
  for (std::size_t i = 0; i < x_wanted.size(); ++i) {
    const auto at = std::find(x->values.begin(), x->values.end(), x_wanted[i]);
    if (at == x->values.end()) {
      throw NumericalFailure(
          fmt::format("the run did not measure {} at {} = {}, where reference '{}' has a point", measure,
                      curve.x, x_wanted[i], reference.id));
    }
    if (std::find(at + 1, x->values.end(), x_wanted[i]) != x->values.end()) {
      throw NumericalFailure(
          fmt::format("the run measured {} more than once at {} = {}: the curve is not one", measure, curve.x,
                      x_wanted[i]));
    }
    const double measured = y->values[static_cast<std::size_t>(at - x->values.begin())];
    const double scale = std::max(std::abs(y_wanted[i]), floor);
    largest = planted(Mutant::curve_loses_nan)
                  ? std::fmax(largest, relative_to(measured - y_wanted[i], scale))
                  : worse(largest, relative_to(measured - y_wanted[i], scale));
  }
  return largest;
}

namespace {

double metric(const std::string& name, const observe::Observations& seen) {
  const observe::Metric* found = seen.metric(name);
  if (found == nullptr) throw NumericalFailure(fmt::format("the run yields no '{}' for this scene", name));
  return found->value;
}

bool departs(const observe::Column& now, const observe::Column& accepted, std::size_t row,
             const Origin& origin) {
  if (!accepted.texts.empty()) return now.texts[row] != accepted.texts[row];
  const double value = now.values[row], was = accepted.values[row];
  if (value == was || (std::isnan(value) && std::isnan(was))) return false;
  return !(std::abs(value - was) <= origin.allowed(was));
}

double measure(const Check& check, const Case& c, const observe::Observations& seen) {
  if (check.of_table) return rows_departing(check.measure, c.references[*check.reference], seen);
  if (check.curve)
    return max_curve_error(*check.curve, check.tolerance.floor, c.references[*check.reference], seen);
  return metric(check.measure, seen);
}

}  // namespace

double rows_departing(const std::string& measure, const Reference& baseline,
                      const observe::Observations& seen) {
  const observe::Record& accepted = *baseline.table;
  const std::string column = measure.substr(accepted.name.size() + 1);
  const observe::Record* record = seen.record(accepted.name);
  const observe::Column* now = record == nullptr ? nullptr : record->find(column);
  const observe::Column& was = *accepted.find(column);
  if (now == nullptr || now->size() != was.size() || now->texts.size() != was.texts.size()) {
    return static_cast<double>(std::max(now == nullptr ? 0 : now->size(), was.size()));
  }
  double departing = 0.0;
  for (std::size_t row = 0; row < was.size(); ++row) {
    if (departs(*now, was, row, *baseline.origin)) departing += 1.0;
  }
  return departing;
}

double Uncertainty::combined() const { return std::hypot(reference, numerical, input); }

std::string to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass:
      return "pass";
    case Verdict::fail:
      return "fail";
    case Verdict::finding:
      return "finding";
    case Verdict::measured:
      return "measured";
    case Verdict::skipped:
      return "skipped";
    case Verdict::error:
      break;
  }
  return "error";
}

Outcome judge(const Check& check, const Case& c, const observe::Observations& seen) {
  Outcome outcome{};
  outcome.measure = check.measure;
  outcome.measured = planted(Mutant::target_taken_as_measured) ? check.target : measure(check, c, seen);
  // Only a baseline says that a number is infinite.
  if (std::isnan(outcome.measured) || (std::isinf(outcome.measured) && !std::isinf(check.target))) {
    throw NumericalFailure(fmt::format("'{}' was measured as {}", check.measure, outcome.measured));
  }
  outcome.target = check.target;
  if (check.uncertainty) {
    outcome.uncertainty = check.uncertainty;
    if (check.uncertainty->gci) outcome.uncertainty->numerical = metric(*check.uncertainty->gci, seen);
    outcome.tolerance = outcome.uncertainty->combined();
  } else {
    const bool of_target =
        (check.tolerance.relative || planted(Mutant::tolerance_always_relative)) && !check.curve;
    outcome.tolerance = check.tolerance.value * (of_target ? std::abs(check.target) : 1.0);
  }
  outcome.outside = check.outside;
  outcome.error = outcome.measured == outcome.target ? 0.0
                  : planted(Mutant::error_with_sign) ? std::max(0.0, outcome.measured - outcome.target)
                                                     : std::abs(outcome.measured - outcome.target);
  const double margin = outcome.error / outcome.tolerance;
  outcome.margin = check.outside && !planted(Mutant::outside_taken_as_within) ? 1.0 / margin : margin;
  const bool holds = outcome.margin <= 1.0;
  if (!check.refuted) {
    outcome.verdict = holds ? Verdict::pass : Verdict::fail;
  } else {
    // A refutation is as much a result as any other: it must stay what it was.
    const double departure = std::abs(outcome.measured - check.refuted->value);
    const bool as_recorded = departure <= check.refuted->relative * std::abs(check.refuted->value);
    outcome.verdict =
        !holds && (as_recorded || planted(Mutant::refutation_unchecked)) ? Verdict::finding : Verdict::fail;
  }
  return outcome;
}

Verdict overall(const std::vector<Outcome>& outcomes) {
  if (outcomes.empty()) return Verdict::measured;
  const bool failed =
      std::any_of(planted(Mutant::verdict_of_last_check) ? outcomes.end() - 1 : outcomes.begin(),
                  outcomes.end(), [](const Outcome& o) { return o.verdict == Verdict::fail; });
  return failed ? Verdict::fail : Verdict::pass;
}

}  // namespace veriflex::engine
