/// Judging what was measured. This is the only place where a verdict is made.
#pragma once

#include <string>
#include <vector>

#include "engine/case.hpp"

namespace veriflex::engine {

enum class Verdict {
  pass,
  fail,
  finding,   // of a check: a published claim is refuted, by as much as was recorded
  error,     // of a case: it could not answer
  measured,  // of a case without checks: there was nothing to judge
  skipped,   // of a case: this program was built without what it needs (Study::lacks)
};
std::string to_string(Verdict verdict);

struct Outcome {
  std::string measure;
  double measured;
  double target;
  double tolerance;  // absolute; the combined uncertainty, where one stands in its place
  bool outside;      // the statement holds beyond the tolerance of the target, not within it
  double error;      // |measured - target|
  double
      margin;  // error / tolerance, or its inverse for holds = "outside": at most 1 where the statement holds
  Verdict verdict;
  std::optional<Uncertainty> uncertainty;
};

/// The largest error of a curve over the reference's points, each over max(|reference|, floor). Throws
/// NumericalFailure unless every point of the reference was measured once at exactly its x.
double max_curve_error(const Curve& curve, double floor, const Reference& reference,
                       const observe::Observations& seen);

/// How many rows of that `record.column` are not what the baseline's table says, within what it allows; all
/// of them where there are more or fewer rows, or no such column.
double rows_departing(const std::string& measure, const Reference& baseline,
                      const observe::Observations& seen);

/// Judges one check of the case. Throws NumericalFailure when the observations lack what it asks for or hold
/// a NaN there.
Outcome judge(const Check& check, const Case& c, const observe::Observations& seen);

/// `fail` if any check failed, else `pass`; `measured` without checks.
Verdict overall(const std::vector<Outcome>& outcomes);

}  // namespace veriflex::engine
