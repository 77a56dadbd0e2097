#include "engine/baseline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace veriflex::engine {

namespace {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out + '"';
}

// A TOML float: never without point or exponent, lest it read as an integer too large for one.
std::string float_text(double value) {
  std::string text = fmt::format("{:.17g}", value);
  if (std::isfinite(value) && text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
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

std::string baseline_text(const Result& result, const std::string& id, const std::string& reason,
                          const std::string& command) {
  const Provenance& p = result.provenance;
  std::string text = fmt::format(
      "# What this program measured earlier. Guards against unnoticed change; verifies nothing.\n"
      "schema = 1\n"
      "id = {}\n"
      "kind = \"baseline\"\n"
      "source = {}\n"
      "obtained = {}\n"
      "command = {}\n"
      "\n"
      "[provenance]\n"
      "revision = {}\n"
      "compiler = {}\n"
      "machine = {}\n"
      "date = {}\n"
      "reason = {}\n",
      quoted(id), quoted("case " + result.c.id), quoted("accepted: " + reason), quoted(command),
      quoted(p.revision), quoted(p.compiler), quoted(p.machine), quoted(p.date), quoted(reason));
  for (const observe::Metric& metric : result.seen.metrics) {
    if (std::isnan(metric.value)) {
      throw InputError({result.c.path.string()}, fmt::format("metric '{}' was measured as nan", metric.name),
                       "a baseline holds numbers", "Mend the case first");
    }
    text += fmt::format("\n[values.{}]\nvalue = {}\ndimension = {}\nmeaning = {}\n", quoted(metric.name),
                        float_text(metric.value), quoted(metric.dimension), quoted(metric.meaning));
  }
  return text;
}

}  // namespace veriflex::engine
