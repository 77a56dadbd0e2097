#include "junit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "io/file.hpp"

namespace veriflex {

namespace {

/// As XML 1.0 may hold it: bytes that are no UTF-8 are replaced, and control characters, which it cannot
/// hold.
std::string xml(const std::string& text) {
  using Json = nlohmann::json;
  const std::string valid =
      Json::parse(Json(text).dump(-1, ' ', false, Json::error_handler_t::replace)).get<std::string>();
  std::string safe;
  for (const char c : valid) {
    if (c == '&') {
      safe += "&amp;";
    } else if (c == '<') {
      safe += "&lt;";
    } else if (c == '>') {
      safe += "&gt;";
    } else if (c == '"') {
      safe += "&quot;";
    } else if (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') {
      safe += '?';
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

struct Numbers {
  double measured, target, tolerance, margin;
};

/// A line on a check.
std::string judged(const std::string& verdict, const std::string& metric, bool outside,
                   const std::string& statement, const Numbers& numbers) {
  return fmt::format("{}: {} measured {:.17g}, {} {:.17g}, tolerance {:.3g}, margin {:.3g}. {}\n", verdict,
                     metric, numbers.measured, outside ? "must lie outside of" : "target", numbers.target,
                     numbers.tolerance, numbers.margin, statement);
}

bool was_skipped(const JunitCase& c) { return c.error_kind == "lacking"; }

std::string testcase(const JunitCase& c) {
  std::string text = fmt::format("  <testcase classname=\"{}\" name=\"{}\" time=\"{:.3f}\">", xml(c.driver),
                                 xml(c.name), c.seconds);
  if (was_skipped(c)) {
    text += fmt::format("\n    <skipped message=\"{}\"/>", xml(c.error));
  } else if (!c.error_kind.empty()) {
    text += fmt::format("\n    <error type=\"{}\" message=\"{}\">{}</error>", xml(c.error_kind),
                        xml(first_line(c.error)), xml(c.error));
  } else if (!c.failed.empty()) {
    text += fmt::format("\n    <failure type=\"check\" message=\"{}\">{}</failure>",
                        xml(first_line(c.failed)), xml(c.failed));
  }
  if (!c.notes.empty()) text += fmt::format("\n    <system-out>{}</system-out>", xml(c.notes));
  return text + "</testcase>\n";
}

}  // namespace

JunitCase junit_case(const engine::Result& r) {
  JunitCase made{
      r.c.name(), r.c.driver.empty() ? "unreadable" : r.c.driver, r.cost.wall_seconds(), {}, {}, {}, {}};
  if (!r.has_answer()) {
    made.error_kind = r.error_kind;
    made.error = r.error_message;
  }
  if (r.verdict == engine::Verdict::measured) made.notes = "nothing was judged\n";
  for (std::size_t i = 0; i < r.outcomes.size(); ++i) {
    const engine::Outcome& o = r.outcomes[i];
    const bool failed = o.verdict == engine::Verdict::fail;
    if (!failed && o.verdict != engine::Verdict::finding) continue;
    (failed ? made.failed : made.notes) +=
        judged(to_string(o.verdict), o.measure, o.outside, r.c.checks[i].statement,
               {o.measured, o.target, o.tolerance, o.margin});
  }
  return made;
}

JunitCase junit_case(const engine::StoredResult& r) {
  JunitCase made{
      r.id, r.driver.empty() ? "unreadable" : r.driver, r.wall_seconds, {}, r.error_kind, r.error_message,
      {}};
  if (r.verdict == "measured") made.notes = "nothing was judged\n";
  for (const engine::StoredCheck& c : r.checks) {
    if (c.verdict != "fail" && c.verdict != "finding") continue;
    (c.verdict == "fail" ? made.failed : made.notes) +=
        judged(c.verdict, c.metric, c.holds == "outside", c.statement,
               {c.measured, c.target, c.tolerance, c.margin});
  }
  return made;
}

void write_junit(const std::filesystem::path& file, const std::vector<JunitCase>& cases) {
  const auto failures =
      std::count_if(cases.begin(), cases.end(), [](const JunitCase& c) { return !c.failed.empty(); });
  const auto skipped = std::count_if(cases.begin(), cases.end(), was_skipped);
  const auto errors = std::count_if(cases.begin(), cases.end(), [](const JunitCase& c) {
    return !c.error_kind.empty() && !was_skipped(c);
  });
  double seconds = 0.0;
  for (const JunitCase& c : cases) seconds += c.seconds;
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<testsuite name=\"veriflex\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\" "
      "time=\"{:.3f}\">\n",
      cases.size(), failures, errors, skipped, seconds);
  for (const JunitCase& c : cases) text += testcase(c);
  io::write_file(file, text + "</testsuite>\n");
}

}  // namespace veriflex
