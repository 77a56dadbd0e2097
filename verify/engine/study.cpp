#include "engine/study.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>

#include "base/mutant.hpp"

namespace veriflex::engine {

std::vector<observe::Metric> measured(const Study& study) {
  std::vector<observe::Metric> all = study.declares.metrics;
  for (const observe::Record& record : study.declares.records) {
    for (const observe::Column& column : record.columns)
      all.push_back({record.name + "." + column.name, {}, column.dimension, column.meaning});
  }
  for (const std::string& name : study.measures) all.push_back({name, {}, "", ""});
  return all;
}

std::vector<std::string> names_of(const std::vector<observe::Metric>& metrics) {
  std::vector<std::string> names;
  for (const observe::Metric& metric : metrics) names.push_back(metric.name);
  return names;
}

observe::Observations begin(const Study& study) {
  return {.records = study.declares.records, .metrics = {}, .declared = study.declares.metrics};
}

void hold_to_declaration(const Study& study, const observe::Observations& seen) {
  for (const observe::Metric& metric : study.declares.metrics) {
    if (seen.metric(metric.name) == nullptr)
      throw std::logic_error(fmt::format("metric '{}' is declared and was not measured", metric.name));
  }
  if (study.declares.metrics.empty()) return;
  for (const observe::Metric& metric : seen.metrics) {
    if (study.declares.metric(metric.name) == nullptr)
      throw std::logic_error(fmt::format("metric '{}' was measured and is not declared", metric.name));
  }
}

void hold_to_plan(const Study& study) {
  if (study.runs || planted(Mutant::plan_not_held)) return;
  const std::vector<std::string> broken = scene::broken_promises(study.plan, parts::made());
  if (!broken.empty())
    throw std::logic_error(fmt::format("the run is not what its plan says: {}", fmt::join(broken, "; ")));
}

}  // namespace veriflex::engine
