#include "engine/audit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace veriflex::engine {

namespace {

constexpr double too_loose = 100.0, too_close = 3.0;

/// Largest distance of a check's number from that of other runs of the same case.
std::optional<double> spread_of(const std::string& id, const StoredCheck& check,
                                const std::vector<StoredResult>& others) {
  std::optional<double> most;
  for (const StoredResult& other : others) {
    if (other.id != id) continue;
    for (const StoredCheck& there : other.checks) {
      if (there.metric != check.metric || there.statement != check.statement) continue;
      const bool same = there.measured == check.measured;  // infinities too
      most = std::max(most.value_or(0.0), same ? 0.0 : std::abs(there.measured - check.measured));
    }
  }
  return most;
}

/// Nothing, or what means nothing where a check stands alone.
bool says_nothing(const std::string& text) {
  return text.find_first_not_of(" \t\n") == std::string::npos || text == "none" || text == "as above";
}

std::string name_of(const Case& c, const Check& check) { return fmt::format("{}: {}", c.id, check.measure); }

void audit_case(const Case& c, AuditOfCases& found) {
  bool has_claim = false;
  for (const Check& check : c.checks) {
    has_claim = has_claim || check.kind == CheckKind::claim;
    if (says_nothing(check.tolerance.reason)) {
      found.without_reason.push_back(
          {name_of(c, check), fmt::format("reason \"{}\"", check.tolerance.reason)});
    }
    if (check.target_kind == "baseline") found.own_targets.push_back({name_of(c, check), check.source});
  }
  if (!has_claim && says_nothing(c.equation)) {
    found.without_question.push_back({c.id, "neither an equation nor a claim of the ledger"});
  }
}

}  // namespace

double AuditedCheck::observed() const { return std::max(check.error, spread.value_or(0.0)); }

double AuditedCheck::looseness() const { return check.tolerance / observed(); }

AuditOfResults audit(const std::vector<StoredResult>& results, const std::vector<StoredResult>& others) {
  AuditOfResults found;
  for (const StoredResult& result : results) {
    for (const StoredCheck& check : result.checks) {
      found.all.push_back({result.id, check, spread_of(result.id, check, others)});
      const AuditedCheck& one = found.all.back();
      if (check.verdict == "finding") continue;
      const bool within = check.holds == "within";
      if (within && one.observed() == 0.0) ++found.exact;
      if (within && one.observed() > 0.0 && one.looseness() > too_loose) found.loose.push_back(one);
      if (check.margin * too_close > 1.0) found.close.push_back(one);
      if (one.spread && *one.spread * too_close > check.tolerance) found.noisy.push_back(one);
    }
  }
  std::stable_sort(found.loose.begin(), found.loose.end(), [](const AuditedCheck& a, const AuditedCheck& b) {
    return a.looseness() > b.looseness();
  });
  std::stable_sort(found.close.begin(), found.close.end(), [](const AuditedCheck& a, const AuditedCheck& b) {
    return a.check.margin > b.check.margin;
  });
  return found;
}

AuditOfCases audit(const std::vector<Case>& cases, const std::vector<std::filesystem::path>& references,
                   const Ledger& ledger) {
  AuditOfCases found;
  std::set<std::string> used;
  for (const Case& c : cases) {
    audit_case(c, found);
    for (const Reference& reference : c.references) used.insert(reference.id);
  }
  for (const std::filesystem::path& path : references) {
    if (!used.contains(path.stem().string())) {
      found.unused.push_back({path.stem().string(), "no check is held against it"});
    }
  }
  for (const Entry& entry : ledger.entries) {
    if (entry.judged_by.empty()) found.undecided.push_back({entry.id, entry.kind + ": " + entry.notes});
  }
  return found;
}

}  // namespace veriflex::engine
