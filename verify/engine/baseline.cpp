#include "engine/baseline.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/work.hpp"
#include "engine/difference.hpp"
#include "io/document.hpp"

namespace veriflex::engine {

namespace fs = std::filesystem;

namespace {

void check_reading_back(const std::string& text, const fs::path& path, const Result& result) {
  std::string why;
  try {
    const Reference back = read_reference(io::parse_document(text, path.string()), path);
    const std::optional<observe::Record> table = table_to_keep(result);
    if (differ(changes(back, result.seen)) ||
        (table && (!back.table || !record_changes(*back.table, *table).empty()))) {
      why = "values changed by writing and reading";
    }
  } catch (const InputError& error) {
    why = error.what();
  }
  if (why.empty()) return;
  throw InputError({}, "a baseline of this could not be read again", why,
                   "Give a --reason in UTF-8, and mend what is named there");
}

Check check_of(const Reference& baseline, std::size_t index) {
  const Origin& origin = *baseline.origin;
  Check check{};
  check.place = {baseline.path.string()};
  check.kind = CheckKind::verification;
  check.statement = fmt::format("as accepted on {}: {}", origin.date, origin.reason);
  check.tolerance.reason = "stated in the baseline; another machine or compiler may round differently";
  check.reference = index;
  check.target_kind = baseline.kind;
  check.source = baseline.source;
  return check;
}

std::string allowed_text(const Origin& origin) {
  return fmt::format("{} relative, but at least {}", origin.relative, origin.absolute);
}

void compare_table(Case& c, const Reference& baseline, std::size_t index) {
  for (const observe::Column& column : baseline.table->columns) {
    Check check = check_of(baseline, index);
    check.measure = baseline.table->name + "." + column.name;
    check.of_table = true;
    check.tolerance.value = 0.5;
    check.tolerance.text = fmt::format("no row departs by more than {}", allowed_text(*baseline.origin));
    c.checks.push_back(std::move(check));
  }
}

// As lists of a line each, so that a change of a column shows as one.
std::string text_of(const observe::Record& table) {
  std::string text = fmt::format("\n[table]\nrecord = {}\n", io::toml_text(table.name));
  for (const observe::Column& column : table.columns) {
    std::vector<std::string> cells;
    for (const double value : column.values) cells.push_back(io::toml_text(value));
    for (const std::string& word : column.texts) cells.push_back(io::toml_text(word));
    text += fmt::format("\n[[table.column]]\nname = {}\n{} = [{}]\n", io::toml_text(column.name),
                        column.texts.empty() ? "numbers" : "texts", fmt::join(cells, ", "));
  }
  return text;
}

}  // namespace

std::optional<observe::Record> table_to_keep(const Result& result) {
  if (!result.c.study.runs || result.seen.records.empty()) return std::nullopt;
  observe::Record table = result.seen.records.front();
  std::erase_if(table.columns, [](const observe::Column& column) {
    const bool is_work = std::any_of(work::fields.begin(), work::fields.end(),
                                     [&](const work::Field& field) { return column.name == field.name; });
    return is_work || column.name == "message" || column.name == "parts_bytes";
  });
  return table;
}

std::vector<Change> changes(const Reference& earlier, const observe::Observations& now) {
  std::vector<Change> all;
  for (const observe::Metric& metric : now.metrics) {
    const auto found = earlier.values.find(metric.name);
    all.push_back({metric.name,
                   found == earlier.values.end() ? std::nullopt : std::optional(found->second.value),
                   metric.value});
  }
  for (const auto& [name, value] : earlier.values) {
    if (now.metric(name) == nullptr) all.push_back({name, value.value, std::nullopt});
  }
  return all;
}

bool differ(const std::vector<Change>& changes) {
  return std::any_of(changes.begin(), changes.end(), [](const Change& c) { return c.earlier != c.now; });
}

fs::path baseline_path(const Case& c, const fs::path& case_folder, const fs::path& reference_folder) {
  std::error_code unknown;
  const fs::path folder = fs::weakly_canonical(c.path, unknown).parent_path();
  const bool of_repository = !unknown && folder == fs::weakly_canonical(case_folder, unknown);
  return (of_repository ? reference_folder : folder) / (c.id + "-baseline.toml");
}

void compare_with_baseline(Case& c, const fs::path& case_folder, const fs::path& reference_folder) {
  const fs::path path = baseline_path(c, case_folder, reference_folder);
  std::error_code impossible;
  if (!c.overrides.empty() || !fs::exists(path, impossible)) return;
  const Reference baseline = read_reference(path);
  if (!baseline.origin) return;
  const auto known = std::find_if(c.references.begin(), c.references.end(),
                                  [&](const Reference& r) { return r.id == baseline.id; });
  const auto index = static_cast<std::size_t>(known - c.references.begin());
  if (known == c.references.end()) c.references.push_back(baseline);
  const auto held_already = [&](const std::string& name) {
    return std::any_of(c.checks.begin(), c.checks.end(),
                       [&](const Check& k) { return k.reference == index && k.measure == name; });
  };
  const std::vector<std::string> measures = names_of(measured(c.study));
  for (const auto& [name, value] : baseline.values) {
    if (held_already(name)) continue;
    if (std::find(measures.begin(), measures.end(), name) == measures.end()) {
      throw InputError({path.string()}, fmt::format("holds '{}', which is no longer measured", name),
                       fmt::format("the driver '{}' has no such metric", c.driver),
                       "Renew it: veriflex accept --replace");
    }
    Check check = check_of(baseline, index);
    check.measure = name;
    check.target = value.value;
    check.tolerance.value = std::isinf(value.value) ? 1.0 : baseline.origin->allowed(value.value);
    check.tolerance.text = allowed_text(*baseline.origin);
    c.checks.push_back(std::move(check));
  }
  if (baseline.table) compare_table(c, baseline, index);
}

std::string baseline_text(const Result& result, const fs::path& path, const std::string& reason,
                          const std::string& command, const std::optional<Reference>& earlier) {
  const Provenance& p = result.provenance;
  const Origin kept = earlier && earlier->origin ? *earlier->origin : Origin{};
  std::string text = fmt::format(
      "# What this program measured earlier. Guards against unnoticed change; verifies nothing.\n"
      "schema = 1\n"
      "id = {}\n"
      "kind = \"baseline\"\n"
      "source = {}\n"
      "obtained = {}\n"
      "command = {}\n"
      "\n"
      "# Later runs of the case are held against these values within the larger of both.\n"
      "[tolerance]\n"
      "relative = {}\n"
      "absolute = {}\n"
      "\n"
      "[provenance]\n"
      "revision = {}\n"
      "compiler = {}\n"
      "machine = {}\n"
      "date = {}\n"
      "reason = {}\n",
      io::toml_text(path.stem().string()), io::toml_text("case " + result.c.id),
      io::toml_text("accepted: " + reason), io::toml_text(command), io::toml_text(kept.relative),
      io::toml_text(kept.absolute), io::toml_text(p.revision), io::toml_text(p.compiler),
      io::toml_text(p.machine), io::toml_text(p.date), io::toml_text(reason));
  for (const observe::Metric& metric : result.seen.metrics) {
    if (std::isnan(metric.value)) {
      throw InputError({result.c.path.string()}, fmt::format("metric '{}' was measured as nan", metric.name),
                       "a baseline holds numbers", "Mend the case first");
    }
    text += fmt::format("\n[values.{}]\nvalue = {}\ndimension = {}\nmeaning = {}\n",
                        io::toml_text(metric.name), io::toml_text(metric.value),
                        io::toml_text(metric.dimension), io::toml_text(metric.meaning));
  }
  if (const std::optional<observe::Record> table = table_to_keep(result)) text += text_of(*table);
  check_reading_back(text, path, result);
  return text;
}

}  // namespace veriflex::engine
