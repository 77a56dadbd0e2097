#include "engine/stored_result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "base/error.hpp"
#include "engine/columns.hpp"
#include "engine/only.hpp"
#include "engine/result.hpp"
#include "io/hdf5.hpp"

namespace veriflex::engine {

namespace fs = std::filesystem;

namespace {

std::vector<StoredCheck> read_checks(const io::Hdf5File& file) {
  Columns columns(file, "/checks");
  std::vector<StoredCheck> checks(columns.words_of("metric").size());
  for (const auto& [name, member] : {std::pair{"metric", &StoredCheck::metric},
                                     {"kind", &StoredCheck::kind},
                                     {"statement", &StoredCheck::statement},
                                     {"verdict", &StoredCheck::verdict},
                                     {"holds", &StoredCheck::holds},
                                     {"reason", &StoredCheck::reason},
                                     {"tolerance_text", &StoredCheck::tolerance_text},
                                     {"reference", &StoredCheck::reference},
                                     {"target_kind", &StoredCheck::target_kind},
                                     {"source", &StoredCheck::source},
                                     {"claim", &StoredCheck::claim}}) {
    const std::vector<std::string> values = columns.words_of(name);
    for (std::size_t i = 0; i < checks.size(); ++i) checks[i].*member = values[i];
  }
  for (const auto& [name, member] : {std::pair{"measured", &StoredCheck::measured},
                                     {"target", &StoredCheck::target},
                                     {"tolerance", &StoredCheck::tolerance},
                                     {"error", &StoredCheck::error},
                                     {"margin", &StoredCheck::margin}}) {
    const std::vector<double> values = columns.numbers_of(name);
    for (std::size_t i = 0; i < checks.size(); ++i) checks[i].*member = values[i];
  }
  if (!file.holds("/checks/uncertainty_reference")) return checks;
  for (const auto& [name, member] : {std::pair{"uncertainty_reference", &StoredCheck::uncertainty_reference},
                                     {"uncertainty_numerical", &StoredCheck::uncertainty_numerical},
                                     {"uncertainty_input", &StoredCheck::uncertainty_input}}) {
    const std::vector<double> values = columns.numbers_of(name);
    for (std::size_t i = 0; i < checks.size(); ++i) checks[i].*member = values[i];
  }
  return checks;
}

std::vector<observe::Metric> read_work(const io::Hdf5File& file) {
  std::vector<observe::Metric> work;
  for (const work::Field& field : work::fields) {
    work.push_back({std::string("work.") + field.name, static_cast<double>(file.integer("/work", field.name)),
                    "1", field.meaning});
  }
  Columns parts(file, "/parts");
  const std::vector<std::string> names = parts.words_of("part");
  const std::vector<double> count = parts.numbers_of("count");
  for (std::size_t i = 0; i < names.size(); ++i) work.push_back({"built." + names[i], count[i], "1", ""});
  return work;
}

std::vector<StoredPart> read_plan(const io::Hdf5File& file) {
  std::vector<StoredPart> plan;
  Columns built(file, "/plan/built");
  const std::vector<std::string> modules = built.words_of("module"), what = built.words_of("what");
  const std::vector<double> bytes = built.numbers_of("memory_bytes");
  for (std::size_t i = 0; i < modules.size(); ++i) {
    plan.push_back({modules[i], fmt::format("{} ({} bytes)", what[i], bytes[i]), true});
  }
  Columns left_out(file, "/plan/left_out");
  const std::vector<std::string> absent = left_out.words_of("module"), why = left_out.words_of("why");
  for (std::size_t i = 0; i < absent.size(); ++i) plan.push_back({absent[i], why[i], false});
  return plan;
}

}  // namespace

StoredResult read_result(const fs::path& path) {
  const io::Hdf5File file(path);
  if (file.integer("/", "schema") != 2) {
    throw InputError({path.string()}, fmt::format("is of schema {}", file.integer("/", "schema")),
                     "this program reads schema 2", "Run the case again");
  }
  StoredResult r{};
  r.file = path;
  for (const auto& [name, member] : {std::pair{"id", &StoredResult::id},
                                     {"case_id", &StoredResult::case_id},
                                     {"variant", &StoredResult::variant},
                                     {"title", &StoredResult::title},
                                     {"equation", &StoredResult::equation},
                                     {"driver", &StoredResult::driver},
                                     {"tier", &StoredResult::tier},
                                     {"verdict", &StoredResult::verdict},
                                     {"outcome", &StoredResult::outcome}}) {
    r.*member = file.attribute("/", name);
  }
  if (r.verdict == "error" || r.verdict == "skipped") {
    r.error_kind = file.attribute("/", "error_kind");
    r.error_message = file.attribute("/", "error_message");
  }
  r.findings = file.integer("/", "findings");
  r.topics = file.attribute_texts("/", "topics");
  r.warnings = file.attribute_texts("/", "warnings");
  r.overrides = file.attribute_texts("/case", "overrides");
  r.case_text = only(file.texts("/case"), path.string(), "/case");
  r.plan = read_plan(file);
  for (const std::string& name : file.names("/records")) r.records.push_back(read_record(file, name));
  r.metrics = read_metrics(file, "/metrics");
  r.work = read_work(file);
  r.checks = read_checks(file);
  for (const std::string& id : file.names("/references")) {
    const std::string group = "/references/" + id;
    r.references.push_back({id, file.attribute(group, "kind"), file.attribute(group, "source"),
                            file.attribute(group, "sha256")});
  }
  for (const auto& [name, member] : {std::pair{"program", &StoredResult::program},
                                     {"compiler", &StoredResult::compiler},
                                     {"flags", &StoredResult::flags},
                                     {"build_type", &StoredResult::build_type},
                                     {"machine", &StoredResult::machine},
                                     {"date", &StoredResult::date}}) {
    r.*member = file.attribute("/provenance", name);
  }
  r.threads = file.integer("/provenance", "threads");
  const auto sum = [&](const char* column) {
    const std::vector<double> values = file.numbers(fmt::format("/timing/{}", column));
    return std::accumulate(values.begin(), values.end(), 0.0);
  };
  r.wall_seconds = sum("wall_seconds");
  r.cpu_seconds = sum("cpu_seconds");
  r.repeats = file.numbers("/repeats/wall_seconds");
  return r;
}

StoredRun read_results(const std::vector<fs::path>& files) {
  StoredRun run;
  for (const fs::path& file : files) {
    try {
      run.results.push_back(read_result(file));
    } catch (const InputError& error) {
      run.unreadable.emplace_back(error.what());
    }
  }
  return run;
}

std::vector<fs::path> result_files(const fs::path& folder) {
  std::error_code unknown;
  if (!fs::is_directory(folder, unknown)) {
    throw InputError({folder.string()}, "no folder of results",
                     fs::exists(folder, unknown) ? "it is a file" : "it does not exist",
                     "Name the folder that veriflex run or verify wrote to with --out");
  }
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const bool hidden = entry.path().filename().string().starts_with('.');
    if (entry.path().extension() == ".h5" && !hidden) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace veriflex::engine
