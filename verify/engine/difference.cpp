#include "engine/difference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "base/mutant.hpp"

namespace veriflex::engine {

namespace {

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

double relative_change(double before, double after) {
  if (before == after) return 0.0;
  if (!std::isfinite(before) || !std::isfinite(after)) return INFINITY;
  return std::abs(after - before) / std::max(std::abs(before), std::abs(after));
}

/// Of a record or a metric: it is of this machine and this hour.
bool tells_time(const std::string& name) {
  return name.find("_cost") != std::string::npos || name.find("_seconds") != std::string::npos;
}

bool same_check(const StoredCheck& a, const StoredCheck& b) {
  return a.verdict == b.verdict && a.holds == b.holds && a.statement == b.statement &&
         (same_bits(a.measured, b.measured) || planted(Mutant::moved_check_is_same)) &&
         same_bits(a.target, b.target) && same_bits(a.tolerance, b.tolerance);
}

/// Pairs what is the same check: of the same metric and statement, then of the same metric, in their order.
std::vector<CheckChange> paired(const std::vector<StoredCheck>& before,
                                const std::vector<StoredCheck>& after) {
  std::vector<CheckChange> pairs;
  for (const StoredCheck& check : after) pairs.push_back({{}, check});
  std::vector<bool> taken(before.size(), false);
  for (const bool by_statement : {true, false}) {
    for (CheckChange& pair : pairs) {
      for (std::size_t i = 0; i < before.size() && !pair.before; ++i) {
        if (taken[i] || before[i].metric != pair.after->metric) continue;
        if (by_statement && before[i].statement != pair.after->statement) continue;
        pair.before = before[i];
        taken[i] = true;
      }
    }
  }
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (!taken[i]) pairs.push_back({before[i], {}});
  }
  return pairs;
}

void compare_checks(const StoredResult& before, const StoredResult& after, CaseDifference& d) {
  for (CheckChange& pair : paired(before.checks, after.checks)) {
    if (pair.before && pair.after && same_check(*pair.before, *pair.after)) {
      ++d.same_checks;
      continue;
    }
    const std::string& metric = pair.either().metric;
    // Where there was no answer, a failure is none that is new.
    const bool fails = pair.after && pair.after->verdict == "fail" && before.verdict != "error";
    if (fails && !(pair.before && pair.before->verdict == "fail")) {
      d.worse.push_back(
          fmt::format("{} fails, margin {:.3g}: {}", metric, pair.after->margin, pair.after->statement));
    }
    // A run that ended in an error judged nothing, which is told as that.
    if (!pair.after && after.verdict != "error") {
      d.worse.push_back(fmt::format("{} is no longer judged: {}", metric, pair.before->statement));
    }
    d.checks.push_back(std::move(pair));
  }
}

void compare_metrics(const std::vector<observe::Metric>& before, const std::vector<observe::Metric>& after,
                     CaseDifference& d) {
  const auto named = [](const std::vector<observe::Metric>& all, const std::string& name) {
    return std::find_if(all.begin(), all.end(), [&](const observe::Metric& m) { return m.name == name; });
  };
  for (const observe::Metric& metric : after) {
    if (tells_time(metric.name)) continue;
    const auto earlier = named(before, metric.name);
    if (earlier == before.end()) {
      d.new_metrics.push_back(metric.name);
    } else if (same_bits(earlier->value, metric.value)) {
      ++d.same_metrics;
    } else {
      d.metrics.push_back(
          {metric.name, earlier->value, metric.value, relative_change(earlier->value, metric.value)});
    }
  }
  for (const observe::Metric& metric : before) {
    if (!tells_time(metric.name) && named(after, metric.name) == after.end()) {
      d.lost_metrics.push_back(metric.name);
    }
  }
}

RecordChange compare_columns(const std::string& record, const observe::Column& a, const observe::Column& b) {
  RecordChange change{record, b.name, {}};
  if (a.size() != b.size()) {
    change.what = fmt::format("{} rows, now {}", a.size(), b.size());
  } else if (a.texts != b.texts) {
    change.what = "other words";
  } else {
    double largest = 0.0, most = 0.0;
    for (std::size_t i = 0; i < a.values.size(); ++i) {
      if (same_bits(a.values[i], b.values[i])) continue;
      const double moved = std::abs(a.values[i] - b.values[i]);
      most = std::max(most, std::isfinite(moved) ? moved : INFINITY);
    }
    for (const double value : b.values) largest = std::max(largest, std::abs(value));
    change.relative = most == 0.0 ? 0.0 : most / largest;
  }
  return change;
}

bool same_column(const observe::Column& a, const observe::Column& b) {
  return a.texts == b.texts &&
         std::equal(a.values.begin(), a.values.end(), b.values.begin(), b.values.end(), same_bits);
}

void compare_records(const StoredResult& before, const StoredResult& after, CaseDifference& d) {
  const auto named = [](const std::vector<observe::Record>& all, const std::string& name) {
    return std::find_if(all.begin(), all.end(), [&](const observe::Record& r) { return r.name == name; });
  };
  for (const observe::Record& record : after.records) {
    if (tells_time(record.name)) continue;
    const auto earlier = named(before.records, record.name);
    if (earlier == before.records.end()) {
      d.records.push_back({record.name, "", "is new"});
      continue;
    }
    std::vector<RecordChange> found = record_changes(*earlier, record);
    if (found.empty()) ++d.same_records;
    std::move(found.begin(), found.end(), std::back_inserter(d.records));
  }
  for (const observe::Record& record : before.records) {
    if (!tells_time(record.name) && named(after.records, record.name) == after.records.end()) {
      d.records.push_back({record.name, "", "is gone"});
    }
  }
  std::stable_sort(d.records.begin(), d.records.end(),
                   [](const RecordChange& a, const RecordChange& b) { return a.relative > b.relative; });
}

void compare_references(const StoredResult& before, const StoredResult& after, CaseDifference& d) {
  const auto sum = [](const StoredResult& of, const std::string& id) -> std::optional<std::string> {
    for (const StoredReference& one : of.references) {
      if (one.id == id) return one.sha256.empty() ? "none" : one.sha256;
    }
    return std::nullopt;
  };
  for (const StoredReference& one : after.references) {
    const std::string now = *sum(after, one.id);
    const std::optional<std::string> then = sum(before, one.id);
    if (then != now) d.references.push_back({one.id, then.value_or("not there"), now});
  }
  for (const StoredReference& one : before.references) {
    if (!sum(after, one.id)) d.references.push_back({one.id, *sum(before, one.id), "not there"});
  }
}

/// What stands in one list alone, as "- " and "+ " lines.
std::vector<std::string> changed_lines(const std::vector<std::string>& before,
                                       const std::vector<std::string>& after) {
  std::vector<std::string> lines;
  const auto has = [](const std::vector<std::string>& all, const std::string& one) {
    return std::find(all.begin(), all.end(), one) != all.end();
  };
  for (const std::string& one : before) {
    if (!has(after, one)) lines.push_back("- " + one);
  }
  for (const std::string& one : after) {
    if (!has(before, one)) lines.push_back("+ " + one);
  }
  return lines;
}

std::vector<std::string> plan_lines(const StoredResult& r) {
  std::vector<std::string> lines;
  for (const StoredPart& part : r.plan) {
    lines.push_back(
        fmt::format("{} {}: {}", part.is_built ? "builds" : "leaves out", part.module, part.text));
  }
  return lines;
}

std::optional<SlowDown> slow_down(const StoredResult& before, const StoredResult& after) {
  constexpr std::size_t enough_repeats = 3;
  constexpr double long_enough = 1.0;  // [s]
  constexpr double noise = 1.5;        // of single runs, to either side
  if (before.machine != after.machine || before.threads != after.threads) return std::nullopt;
  if (before.outcome != "completed" || after.outcome != "completed") return std::nullopt;
  if (std::min(before.repeats.size(), after.repeats.size()) >= enough_repeats) {
    const double slowest = *std::max_element(before.repeats.begin(), before.repeats.end());
    const double fastest = *std::min_element(after.repeats.begin(), after.repeats.end());
    if (fastest <= slowest) return std::nullopt;
    return SlowDown{slowest, fastest,
                    fmt::format("the fastest of {} repeats against the slowest of {}", after.repeats.size(),
                                before.repeats.size())};
  }
  const bool is_slower = before.wall_seconds >= long_enough &&
                         after.wall_seconds > noise * before.wall_seconds &&
                         after.cpu_seconds > noise * before.cpu_seconds;
  if (!is_slower) return std::nullopt;
  return SlowDown{before.wall_seconds, after.wall_seconds, "single runs, in wall and processor time"};
}

/// What a case says of its error; of a run that was stopped it holds a date and a step, which mean nothing.
bool same_error(const StoredResult& a, const StoredResult& b) {
  return a.error_kind == b.error_kind &&
         (a.error_kind == "interrupted" || a.error_message == b.error_message);
}

}  // namespace

bool CheckChange::verdict_changed() const { return !before || !after || before->verdict != after->verdict; }

bool CheckChange::is_finding() const {
  return (before && before->verdict == "finding") || (after && after->verdict == "finding");
}

bool CheckChange::requirement_changed() const {
  return before && after &&
         !(same_bits(before->target, after->target) && same_bits(before->tolerance, after->tolerance) &&
           before->holds == after->holds);
}

double CheckChange::margin_change() const {
  if (!before || !after || same_bits(before->margin, after->margin)) return 0.0;
  const double change = std::abs(after->margin - before->margin);
  return std::isfinite(change) ? change : INFINITY;
}

bool CaseDifference::is_same() const {
  return verdict_before == verdict_after && error_before == error_after && !text_changed && checks.empty() &&
         metrics.empty() && lost_metrics.empty() && new_metrics.empty() && records.empty() &&
         references.empty() && plan.empty() && warnings.empty();
}

bool RunDifference::is_same() const {
  return lost.empty() && added.empty() &&
         std::all_of(cases.begin(), cases.end(), [](const CaseDifference& d) { return d.is_same(); });
}

std::vector<RecordChange> record_changes(const observe::Record& before, const observe::Record& after) {
  std::vector<RecordChange> found;
  for (const observe::Column& column : after.columns) {
    const observe::Column* was = before.find(column.name);
    if (was == nullptr) {
      found.push_back({after.name, column.name, "is new"});
    } else if (!same_column(*was, column)) {
      found.push_back(compare_columns(after.name, *was, column));
    }
  }
  for (const observe::Column& column : before.columns) {
    if (after.find(column.name) == nullptr) found.push_back({after.name, column.name, "is gone"});
  }
  return found;
}

CaseDifference difference(const StoredResult& before, const StoredResult& after) {
  CaseDifference d{};
  d.id = after.id;
  d.verdict_before = before.verdict;
  d.verdict_after = after.verdict;
  if (!same_error(before, after)) {
    d.error_before = before.error_message;
    d.error_after = after.error_message;
  }
  d.text_changed = before.case_text != after.case_text || before.overrides != after.overrides;
  if (after.verdict == "error" && before.verdict != "error") {
    d.worse.push_back(fmt::format("error ({}): {}", after.outcome, after.error_message));
  }
  compare_checks(before, after, d);
  compare_metrics(before.metrics, after.metrics, d);
  compare_metrics(before.work, after.work, d);
  std::stable_sort(d.metrics.begin(), d.metrics.end(),
                   [](const NumberChange& a, const NumberChange& b) { return a.relative > b.relative; });
  compare_records(before, after, d);
  compare_references(before, after, d);
  d.plan = changed_lines(plan_lines(before), plan_lines(after));
  d.warnings = changed_lines(before.warnings, after.warnings);
  d.slow_down = slow_down(before, after);
  return d;
}

RunDifference difference(const std::vector<StoredResult>& before, const std::vector<StoredResult>& after) {
  RunDifference all;
  const auto named = [](const std::vector<StoredResult>& in, const std::string& id) {
    return std::find_if(in.begin(), in.end(), [&](const StoredResult& r) { return r.id == id; });
  };
  for (const StoredResult& now : after) {
    const auto then = named(before, now.id);
    if (then != before.end()) {
      all.cases.push_back(difference(*then, now));
      for (const std::string& one : all.cases.back().worse) {
        all.worse.push_back(fmt::format("{}: {}", now.id, one));
      }
      continue;
    }
    all.added.push_back(now.id);
    if (now.verdict == "fail") all.worse.push_back(fmt::format("{}: is new and fails", now.id));
    if (now.verdict == "error") {
      all.worse.push_back(fmt::format("{}: is new and ends in an error: {}", now.id, now.error_message));
    }
  }
  for (const StoredResult& then : before) {
    if (named(after, then.id) != after.end()) continue;
    all.lost.push_back(then.id);
    all.worse.push_back(fmt::format("{}: has no result any more", then.id));
  }
  return all;
}

}  // namespace veriflex::engine
