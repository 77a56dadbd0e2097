#include "studies/grid.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace veriflex::studies {

namespace {

constexpr std::size_t most_rows = 100'000;

// A number as TOML writes it; a text in quotes or a list is none.
std::optional<double> number_in(const std::string& text) {
  try {
    return io::parse_document("value = " + text, "").number("value");
  } catch (const InputError&) {
    return std::nullopt;
  }
}

// A number, or those of a list; none of anything else.
std::vector<double> numbers_in(const std::string& text) {
  if (const std::optional<double> number = number_in(text)) return {*number};
  try {
    return io::parse_document("value = " + text, "").numbers("value");
  } catch (const InputError&) {
    return {};
  }
}

bool are_whole(const std::string& text) {
  return text.find_first_not_of("0123456789[], ") == std::string::npos;
}

std::vector<std::vector<std::string>> read_values(const io::Table& axis, std::size_t keys) {
  std::vector<std::vector<std::string>> values;
  for (const std::string& text : axis.shown_values("values")) {
    if (keys == 1) {
      values.push_back({text});
      continue;
    }
    const io::Table one = io::parse_document("value = " + text, "");
    std::vector<std::string> parts;
    if (one.has_list("value")) parts = one.shown_values("value");
    if (parts.size() != keys) {
      axis.fail("values", fmt::format("'values' holds {}", text),
                fmt::format("each value of these {} keys is a list of {}", keys, keys),
                "Write for example values = [[16, 100], [32, 400]]");
    }
    values.push_back(std::move(parts));
  }
  return values;
}

Axis read_axis(const io::Table& table) {
  Axis axis;
  axis.keys = table.has("keys") ? table.texts("keys") : std::vector{table.text("key")};
  if (axis.keys.empty()) table.fail("keys", "'keys' is empty", "an axis changes at least one", "Name one");
  axis.values = read_values(table, axis.keys.size());
  if (axis.values.empty()) {
    table.fail("values", fmt::format("no values for '{}'", axis.name()), "each gives a row", "Give some");
  }
  for (std::size_t i = 0; i < axis.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (axis.values[i] == axis.values[j]) {
        table.fail("values", fmt::format("'{}' stands there twice", fmt::join(axis.values[i], ", ")),
                   "a row is run once", "Remove one");
      }
    }
    if (const std::optional<double> number = number_in(axis.values[i].front()))
      axis.numbers.push_back(*number);
  }
  if (axis.numbers.size() != axis.size()) axis.numbers.clear();
  return axis;
}

}  // namespace

double as_even(double value, double below, double above, double least) {
  double shared = 32.0;
  for (const double beside : {below, above})
    while (shared > 1.0 && std::fmod(beside, shared) != 0.0) shared /= 2.0;
  const double multiple = std::max(0.5 * shared, std::min(shared, least));
  return std::max(multiple, multiple * std::round(value / multiple));
}

std::string bare(const std::string& value) {
  try {
    return io::parse_document("value = " + value, "").text("value");
  } catch (const InputError&) {
    return value;
  }
}

std::vector<Axis> read_axes(const io::Table& study, const std::string& key) {
  std::vector<Axis> axes;
  std::size_t rows = 1;
  for (const io::Table& table : study.tables(key)) {
    axes.push_back(read_axis(table));
    rows *= axes.back().size();
    for (std::size_t i = 0; i + 1 < axes.size(); ++i) {
      for (const std::string& one : axes.back().keys) {
        if (std::find(axes[i].keys.begin(), axes[i].keys.end(), one) != axes[i].keys.end()) {
          table.fail("key", fmt::format("'{}' belongs to two axes", one), "a row can set it once only",
                     "Remove one");
        }
      }
    }
    if (rows > most_rows) {
      study.fail(key, "too many rows", fmt::format("a study has at most {}", most_rows), "Give fewer values");
    }
  }
  return axes;
}

std::vector<Cell> cells(const std::vector<Axis>& axes) {
  std::vector<Cell> all{Cell{}};
  for (const Axis& axis : axes) {
    std::vector<Cell> longer;
    for (const Cell& cell : all) {
      for (std::size_t i = 0; i < axis.size(); ++i) {
        longer.push_back(cell);
        longer.back().push_back(i);
      }
    }
    all = std::move(longer);
  }
  return all;
}

std::vector<std::string> settings(const std::vector<Axis>& axes, const Cell& cell) {
  std::vector<std::string> all;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    for (std::size_t k = 0; k < axes[a].keys.size(); ++k) {
      all.push_back(axes[a].keys[k] + "=" + axes[a].values[cell[a]][k]);
    }
  }
  return all;
}

std::vector<observe::Column> columns_of(const std::vector<Axis>& axes) {
  std::vector<observe::Column> columns;
  for (const Axis& axis : axes) {
    columns.push_back({axis.name(), "", "1", "axis: this key of the case, in its unit", {}});
  }
  return columns;
}

void append(std::vector<observe::Column>& columns, const std::vector<Axis>& axes, const Cell& cell) {
  for (std::size_t a = 0; a < axes.size(); ++a) {
    if (axes[a].numbers.empty()) {
      columns[a].texts.push_back(bare(axes[a].values[cell[a]].front()));
    } else {
      columns[a].values.push_back(axes[a].numbers[cell[a]]);
    }
  }
}

std::vector<observe::Column> axes_of(const observe::Record& table) {
  const auto outcome = std::find_if(table.columns.begin(), table.columns.end(),
                                    [](const observe::Column& column) { return column.name == "outcome"; });
  return {table.columns.begin(), outcome};
}

std::string in_words(const std::vector<Axis>& axes) {
  constexpr std::size_t shown = 6;
  std::vector<std::string> parts;
  for (const Axis& axis : axes) {
    std::vector<std::string> values;
    for (std::size_t i = 0; i < std::min(shown, axis.size()); ++i)
      values.push_back(bare(axis.values[i].front()));
    if (axis.size() > shown) values.push_back(fmt::format("and {} more", axis.size() - shown));
    parts.push_back(fmt::format("{} = {}", fmt::join(axis.keys, " with "), fmt::join(values, ", ")));
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

std::optional<std::vector<std::string>> values_at(const Axis& axis, const std::string& first) {
  for (const std::vector<std::string>& listed : axis.values)
    if (bare(listed.front()) == first) return listed;
  if (axis.keys.size() == 1) return std::vector{first};
  const std::optional<double> x = number_in(first);
  if (!x || axis.numbers.size() < 2) return std::nullopt;
  const auto distance = [&](std::size_t i) { return std::abs(std::log(*x / axis.numbers[i])); };
  std::vector<std::size_t> order(axis.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return distance(a) < distance(b); });
  const double x_near = axis.numbers[order[0]], x_far = axis.numbers[order[1]];
  std::vector<std::string> values{first};
  for (std::size_t key = 1; key < axis.keys.size(); ++key) {
    const std::vector<double> near = numbers_in(axis.values[order[0]][key]);
    const std::vector<double> far = numbers_in(axis.values[order[1]][key]);
    if (near.empty() || near.size() != far.size()) return std::nullopt;
    const bool whole = std::all_of(axis.values.begin(), axis.values.end(),
                                   [&](const auto& listed) { return are_whole(listed[key]); });
    std::vector<std::string> parts;
    for (std::size_t i = 0; i < near.size(); ++i) {
      if (near[i] <= 0.0 || far[i] <= 0.0) return std::nullopt;
      const double at =
          near[i] * std::pow(*x / x_near, std::log(far[i] / near[i]) / std::log(x_far / x_near));
      parts.push_back(whole ? fmt::format("{:.0f}", as_even(at, near[i], far[i])) : io::toml_text(at));
    }
    values.push_back(number_in(axis.values[order[0]][key]) ? parts.front()
                                                           : fmt::format("[{}]", fmt::join(parts, ", ")));
  }
  return values;
}

}  // namespace veriflex::studies
