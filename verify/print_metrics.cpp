#include "print_metrics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "base/say.hpp"

namespace veriflex {

namespace {

using observe::Metric;

constexpr std::array<std::string_view, 4> of_time{".last", ".mean", ".min", ".max"};

std::string column_of(const Metric& last) {
  return last.name.substr(0, last.name.size() - of_time[0].size());
}

// Whether the four from the i-th on are those of one column in time.
bool is_column_in_time(const std::vector<Metric>& metrics, std::size_t i) {
  if (i + of_time.size() > metrics.size() || !metrics[i].name.ends_with(of_time[0])) return false;
  const std::string column = column_of(metrics[i]);
  for (std::size_t k = 0; k < of_time.size(); ++k) {
    if (metrics[i + k].name != column + std::string(of_time[k])) return false;
  }
  return true;
}

}  // namespace

void print_metrics(const std::vector<Metric>& metrics, const std::string& indent) {
  std::vector<std::size_t> alone, in_time;
  std::size_t width = 6, width_in_time = 14;
  for (std::size_t i = 0; i < metrics.size(); ++i) {
    if (is_column_in_time(metrics, i)) {
      in_time.push_back(i);
      width_in_time = std::max(width_in_time, column_of(metrics[i]).size());
      i += of_time.size() - 1;
    } else {
      alone.push_back(i);
      width = std::max(width, metrics[i].name.size());
    }
  }
  for (const std::size_t i : alone) {
    const Metric& m = metrics[i];
    say("{}{:<{}}  {:>24.17g}  [{}] {}\n", indent, m.name, width, m.value, m.dimension, m.meaning);
  }
  if (in_time.empty()) return;
  say("{}{:<{}}  {:>17}  {:>17}  {:>17}  {:>17}\n", indent, "column in time", width_in_time, "last", "mean",
      "min", "max");
  for (const std::size_t i : in_time) {
    const Metric* of = &metrics[i];
    say("{}{:<{}}  {:>17.10g}  {:>17.10g}  {:>17.10g}  {:>17.10g}  [{}] {}\n", indent, column_of(of[0]),
        width_in_time, of[0].value, of[1].value, of[2].value, of[3].value, of[0].dimension, of[0].meaning);
  }
}

void print_names(const std::vector<Metric>& metrics, const std::string& indent) {
  for (std::size_t i = 0; i < metrics.size(); ++i) {
    if (is_column_in_time(metrics, i)) {
      say("{}{}.last, .mean, .min, .max\n", indent, column_of(metrics[i]));
      i += of_time.size() - 1;
      continue;
    }
    const Metric& m = metrics[i];
    say("{}{}{}\n", indent, m.name,
        m.meaning.empty() ? "" : fmt::format("  [{}] {}", m.dimension, m.meaning));
  }
}

}  // namespace veriflex
