#include "diff_runs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace veriflex {

namespace {

using engine::CaseDifference;
using engine::CheckChange;

std::string number(double value) { return fmt::format("{:.10g}", value); }

std::string signed_relative(double value) {
  return std::isfinite(value) ? fmt::format("{:.2g}", value) : std::string("not finite");
}

/// A row that is sorted by how much it says.
struct Weighed {
  double weight;
  DiffRow row;
};

std::vector<DiffRow> largest_first(std::vector<Weighed> weighed) {
  std::stable_sort(weighed.begin(), weighed.end(),
                   [](const Weighed& a, const Weighed& b) { return a.weight > b.weight; });
  std::vector<DiffRow> rows;
  for (Weighed& one : weighed) rows.push_back(std::move(one.row));
  return rows;
}

std::string in_words(const std::optional<engine::StoredCheck>& check) {
  return check ? fmt::format("{} ({})", check->verdict, number(check->measured)) : std::string("not judged");
}

std::vector<DiffRow> verdicts(const std::vector<CaseDifference>& cases) {
  std::vector<DiffRow> rows;
  for (const CaseDifference& d : cases) {
    if (d.verdict_before != d.verdict_after || d.error_before != d.error_after) {
      const std::string why = d.error_after.empty() ? d.error_before : d.error_after;
      rows.push_back({d.id, "the case", d.verdict_before, d.verdict_after, why});
    }
    for (const CheckChange& check : d.checks) {
      if (!check.verdict_changed()) continue;
      rows.push_back({d.id, check.either().metric, in_words(check.before), in_words(check.after),
                      check.either().statement});
    }
  }
  return rows;
}

std::vector<DiffRow> findings(const std::vector<CaseDifference>& cases) {
  std::vector<DiffRow> rows;
  for (const CaseDifference& d : cases) {
    for (const CheckChange& check : d.checks) {
      if (!check.is_finding()) continue;
      rows.push_back({d.id, check.either().metric, in_words(check.before), in_words(check.after),
                      check.either().statement});
    }
  }
  return rows;
}

std::vector<DiffRow> requirements(const std::vector<CaseDifference>& cases) {
  const auto words = [](const engine::StoredCheck& check) {
    return fmt::format("{} {} +- {:.3g}", check.holds, number(check.target), check.tolerance);
  };
  std::vector<DiffRow> rows;
  for (const CaseDifference& d : cases) {
    for (const CheckChange& check : d.checks) {
      if (!check.requirement_changed()) continue;
      const double ratio = check.after->tolerance / check.before->tolerance;
      rows.push_back({d.id, check.after->metric, words(*check.before), words(*check.after),
                      ratio == 1.0 ? "same tolerance" : fmt::format("tolerance times {:.3g}", ratio)});
    }
  }
  return rows;
}

std::vector<DiffRow> margins(const std::vector<CaseDifference>& cases) {
  std::vector<Weighed> rows;
  for (const CaseDifference& d : cases) {
    for (const CheckChange& check : d.checks) {
      const double change = check.margin_change();
      if (change == 0.0) continue;
      const double now = check.after->margin, then = check.before->margin;
      rows.push_back({change,
                      {d.id, check.after->metric, fmt::format("{:.3g}", then), fmt::format("{:.3g}", now),
                       fmt::format("{:+.2g}", now - then)}});
    }
  }
  return largest_first(std::move(rows));
}

std::vector<DiffRow> metrics(const std::vector<CaseDifference>& cases) {
  std::vector<Weighed> rows;
  for (const CaseDifference& d : cases) {
    for (const engine::NumberChange& m : d.metrics) {
      rows.push_back({m.relative,
                      {d.id, m.name, fmt::format("{:.17g}", m.before), fmt::format("{:.17g}", m.after),
                       signed_relative(m.relative)}});
    }
    for (const std::string& name : d.lost_metrics)
      rows.push_back({INFINITY, {d.id, name, "", "", "is gone"}});
    for (const std::string& name : d.new_metrics) rows.push_back({0.0, {d.id, name, "", "", "is new"}});
  }
  return largest_first(std::move(rows));
}

std::vector<DiffRow> records(const std::vector<CaseDifference>& cases) {
  std::vector<Weighed> rows;
  for (const CaseDifference& d : cases) {
    for (const engine::RecordChange& r : d.records) {
      const std::string name = r.column.empty() ? r.record : r.record + "." + r.column;
      rows.push_back({r.what.empty() ? r.relative : INFINITY,
                      {d.id, name, "", "", r.what.empty() ? signed_relative(r.relative) : r.what}});
    }
  }
  return largest_first(std::move(rows));
}

std::vector<DiffRow> texts(const std::vector<CaseDifference>& cases) {
  std::vector<DiffRow> rows;
  for (const CaseDifference& d : cases) {
    if (d.text_changed) rows.push_back({d.id, "case text or settings", "", "", "changed"});
    for (const engine::ReferenceChange& r : d.references) {
      rows.push_back({d.id, "reference " + r.id, r.before.substr(0, 12), r.after.substr(0, 12), "sha256"});
    }
    for (const std::string& line : d.plan) rows.push_back({d.id, "plan", "", "", line});
    for (const std::string& line : d.warnings) rows.push_back({d.id, "warning", "", "", line});
  }
  return rows;
}

std::vector<DiffRow> slow_downs(const std::vector<CaseDifference>& cases) {
  std::vector<Weighed> rows;
  for (const CaseDifference& d : cases) {
    if (!d.slow_down) continue;
    const engine::SlowDown& s = *d.slow_down;
    rows.push_back({s.after / s.before,
                    {d.id, "wall seconds", fmt::format("{:.3g}", s.before), fmt::format("{:.3g}", s.after),
                     fmt::format("times {:.2g}; {}", s.after / s.before, s.why)}});
  }
  return largest_first(std::move(rows));
}

std::vector<DiffRow> ids(const std::vector<std::string>& all) {
  std::vector<DiffRow> rows;
  for (const std::string& id : all) rows.push_back({id, "", "", "", ""});
  return rows;
}

}  // namespace

std::vector<DiffTable> tables_of(const engine::RunDifference& difference) {
  const std::vector<CaseDifference>& cases = difference.cases;
  std::vector<DiffTable> all{{"changed verdicts", verdicts(cases)},
                             {"changed findings", findings(cases)},
                             {"changed targets and tolerances", requirements(cases)},
                             {"changed margins", margins(cases)},
                             {"changed metrics", metrics(cases)},
                             {"changed records", records(cases)},
                             {"changed texts, references, plans and warnings", texts(cases)},
                             {"only in the earlier run", ids(difference.lost)},
                             {"only in the later run", ids(difference.added)},
                             {"slower", slow_downs(cases)}};
  std::erase_if(all, [](const DiffTable& table) { return table.rows.empty(); });
  return all;
}

std::string summary_of(const Diff& diff) {
  std::size_t checks = 0, metrics = 0, same_metrics = 0, records = 0, same_records = 0;
  std::size_t same = 0;
  for (const CaseDifference& d : diff.difference.cases) {
    same += d.is_same() ? 1 : 0;
    checks += d.same_checks + d.checks.size();
    same_metrics += d.same_metrics;
    metrics += d.same_metrics + d.metrics.size();
    same_records += d.same_records;
    std::vector<std::string> changed;
    for (const engine::RecordChange& r : d.records) changed.push_back(r.record);
    std::sort(changed.begin(), changed.end());
    records += d.same_records +
               static_cast<std::size_t>(std::unique(changed.begin(), changed.end()) - changed.begin());
  }
  return fmt::format(
      "{} of {} cases, {} of {} metrics and counts, {} of {} records the same bit for bit; {} checks", same,
      diff.difference.cases.size(), same_metrics, metrics, same_records, records, checks);
}

}  // namespace veriflex
