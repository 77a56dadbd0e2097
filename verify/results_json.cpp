#include "results_json.hpp"

#include <nlohmann/json.hpp>
#include <sstream>

#include "base/error.hpp"
#include "engine/result.hpp"
#include "engine/stored_result.hpp"
#include "io/file.hpp"

namespace veriflex {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const engine::StoredCheck& check) {
  Json claims = Json::array();
  std::istringstream cited(check.claim);
  for (std::string claim; cited >> claim;) claims.push_back(claim);
  Json uncertainty = nullptr;
  if (check.has_uncertainty()) {
    uncertainty = {{"reference", check.uncertainty_reference},
                   {"numerical", check.uncertainty_numerical},
                   {"input", check.uncertainty_input}};
  }
  return {{"metric", check.metric},       {"kind", check.kind},           {"statement", check.statement},
          {"verdict", check.verdict},     {"measured", check.measured},   {"target", check.target},
          {"holds", check.holds},         {"tolerance", check.tolerance}, {"error", check.error},
          {"margin", check.margin},       {"reason", check.reason},       {"target_kind", check.target_kind},
          {"reference", check.reference}, {"source", check.source},       {"claims", claims},
          {"uncertainty", uncertainty}};
}

Json json_of(const engine::StoredResult& r) {
  Json checks = Json::array();
  Json metrics = Json::array();
  for (const engine::StoredCheck& check : r.checks) checks.push_back(json_of(check));
  for (const observe::Metric& m : r.metrics) {
    metrics.push_back(
        {{"name", m.name}, {"value", m.value}, {"dimension", m.dimension}, {"meaning", m.meaning}});
  }
  Json error = nullptr;
  if (!r.error_kind.empty()) error = {{"kind", r.error_kind}, {"message", r.error_message}};
  return {{"id", r.id},
          {"case_id", r.case_id},
          {"overrides", r.overrides},
          {"title", r.title},
          {"driver", r.driver},
          {"tier", r.tier},
          {"topics", r.topics},
          {"verdict", r.verdict},
          {"outcome", r.outcome},
          {"error", error},
          {"findings", r.findings},
          {"warnings", r.warnings},
          {"wall_seconds", r.wall_seconds},
          {"cpu_seconds", r.cpu_seconds},
          {"checks", checks},
          {"metrics", metrics},
          {"file", r.file.filename().string()},
          {"made_by",
           {{"program", r.program},
            {"compiler", r.compiler},
            {"build_type", r.build_type},
            {"machine", r.machine},
            {"threads", r.threads},
            {"date", r.date}}}};
}

}  // namespace

void write_results_json(const std::filesystem::path& folder, const std::filesystem::path& beside) {
  Json results = Json::array();
  Json unreadable = Json::array();
  Json counts{{"pass", 0}, {"fail", 0}, {"error", 0}, {"measured", 0}, {"skipped", 0}};
  for (const std::filesystem::path& file : engine::result_files(folder)) {
    try {
      const engine::StoredResult result = engine::read_result(file);
      counts[result.verdict] = counts.value(result.verdict, 0) + 1;
      results.push_back(json_of(result));
    } catch (const InputError& error) {
      unreadable.push_back(error.what());
    }
  }
  const Json all{{"format", "veriflex-results"},
                 {"schema", 1},
                 {"date", engine::provenance(1).date},
                 {"counts", counts},
                 {"results", results},
                 {"unreadable", unreadable}};
  io::write_file(beside / "results.json", all.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace veriflex
