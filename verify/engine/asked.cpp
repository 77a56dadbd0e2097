#include "engine/asked.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace veriflex::engine {

namespace {

Pinned read_pinned(const io::Table& check, const std::string& key) {
  Pinned pinned;
  if (!check.has(key)) return pinned;
  const io::Table table = check.table(key);
  for (const std::string& axis : table.keys()) pinned.emplace_back(axis, table.shown_value(axis));
  return pinned;
}

double read_order(const io::Table& table, const std::string& key) {
  const double order = table.number(key);
  if (!(order > 0.0)) {
    table.fail(key, fmt::format("'{}' is {}", key, order), "errors fall with the spacing",
               "Give for example 2, or leave it out: three rows then say it");
  }
  return order;
}

}  // namespace

std::string Asked::name() const {
  std::string text = of == "value" ? metric : fmt::format("{}({})", of, metric);
  const auto add = [&text](std::string separator, const Pinned& pins) {
    for (const auto& [axis, value] : pins) {
      text += fmt::format("{}{} = {}", separator, axis, value);
      separator = ", ";
    }
  };
  if (!along.empty()) text += " along " + along;
  if (of == "gci" && order > 0.0) text += fmt::format(" of order {}", order);  // there may be one of each
  add(" at ", where);
  add(" over ", over);
  return text;
}

const std::vector<std::string>& numbers_of_studies() {
  static const std::vector<std::string> names{"value",      "min", "max",      "mean", "order",
                                              "richardson", "gci", "exponent", "ratio"};
  return names;
}

bool is_curve_of_numbers(const io::Table& check) { return check.has("curve") && check.has("of"); }

std::string last_part(const std::string& path) { return path.substr(path.rfind('.') + 1); }

Asked read_asked(const io::Table& check) {
  Asked asked{.of = "value", .metric = {}, .along = {}, .order = 0.0, .across = {}, .where = {}, .over = {}};
  if (is_curve_of_numbers(check)) {
    asked.metric = check.table("curve").text("y");
    asked.across = check.table("curve").text("x");
  } else {
    asked.metric = check.text("metric");
  }
  if (check.has("of")) asked.of = check.choice("of", numbers_of_studies());
  const std::vector<std::string> with_axis{"order", "richardson", "gci", "exponent"};
  if (std::find(with_axis.begin(), with_axis.end(), asked.of) != with_axis.end()) {
    asked.along = check.text("along");
  }
  if (asked.of == "richardson" && check.has("order")) asked.order = read_order(check, "order");
  asked.where = read_pinned(check, "where");
  if (asked.of == "ratio") {
    asked.over = read_pinned(check, "over");
    if (asked.over.empty()) {
      check.fail("of", "a ratio without 'over'", "it says which row stands below the line",
                 "Write for example over = { \"fluid.storage\" = \"double\" }");
    }
  }
  return asked;
}

std::optional<Asked> read_asked_gci(const io::Table& check) {
  if (!check.has("uncertainty") || !check.table("uncertainty").has("gci_along")) return std::nullopt;
  const io::Table uncertainty = check.table("uncertainty");
  Asked asked = read_asked(check);
  if (asked.of != "value" && asked.of != "richardson") return std::nullopt;
  asked.of = "gci";
  asked.along = uncertainty.text("gci_along");
  asked.order = uncertainty.has("gci_order") ? read_order(uncertainty, "gci_order") : 0.0;
  std::erase_if(asked.where, [&](const auto& pin) { return pin.first == asked.along; });
  return asked;
}

}  // namespace veriflex::engine
