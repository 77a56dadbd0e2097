#include "engine/baseline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/document.hpp"

namespace veriflex::engine {

namespace fs = std::filesystem;

namespace {

void check_reading_back(const std::string& text, const fs::path& path, const observe::Observations& seen) {
  std::string why;
  try {
    const Reference back = read_reference(io::parse_document(text, path.string()), path);
    if (differ(changes(back, seen))) why = "values changed by writing and reading";
  } catch (const InputError& error) {
    why = error.what();
  }
  if (why.empty()) return;
  throw InputError({}, "a baseline of this could not be read again", why,
                   "Give a --reason in UTF-8, and mend what is named there");
}

}  // namespace

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
  const Origin& origin = *baseline.origin;
  const std::vector<std::string> measures = names_of(measured(c.study));
  for (const auto& [name, value] : baseline.values) {
    if (held_already(name)) continue;
    if (std::find(measures.begin(), measures.end(), name) == measures.end()) {
      throw InputError({path.string()}, fmt::format("holds '{}', which is no longer measured", name),
                       fmt::format("the driver '{}' has no such metric", c.driver),
                       "Renew it: veriflex accept --replace");
    }
    Check check{};
    check.place = {path.string()};
    check.kind = CheckKind::verification;
    check.statement = fmt::format("as accepted on {}: {}", origin.date, origin.reason);
    check.measure = name;
    check.target = value.value;
    check.tolerance.value = std::isinf(value.value) ? 1.0 : origin.allowed(value.value);
    check.tolerance.text = fmt::format("{} relative, but at least {}", origin.relative, origin.absolute);
    check.tolerance.reason = "stated in the baseline; another machine or compiler may round differently";
    check.reference = index;
    check.target_kind = baseline.kind;
    check.source = baseline.source;
    c.checks.push_back(std::move(check));
  }
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
  check_reading_back(text, path, result.seen);
  return text;
}

}  // namespace veriflex::engine
