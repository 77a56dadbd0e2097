#include "print_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/say.hpp"

namespace veriflex {

namespace {

using observe::Column;
using observe::Record;

constexpr std::size_t most_metrics = 6;

std::string cell(const Column& column, std::size_t row) {
  if (!column.texts.empty()) return column.texts[row];
  return row < column.values.size() ? fmt::format("{:.6g}", column.values[row]) : std::string();
}

void print_columns(const std::vector<const Column*>& columns, const std::vector<std::size_t>& rows) {
  std::vector<std::size_t> widths;
  for (const Column* column : columns) {
    std::size_t width = column->name.size();
    for (const std::size_t row : rows) width = std::max(width, cell(*column, row).size());
    widths.push_back(width);
  }
  std::string line;
  for (std::size_t c = 0; c < columns.size(); ++c)
    line += fmt::format("  {:>{}}", columns[c]->name, widths[c]);
  say("      {}\n", line);
  for (const std::size_t row : rows) {
    line.clear();
    for (std::size_t c = 0; c < columns.size(); ++c)
      line += fmt::format("  {:>{}}", cell(*columns[c], row), widths[c]);
    say("      {}\n", line);
  }
}

std::vector<std::size_t> all_rows(const Record& record) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < record.columns.front().size(); ++row) rows.push_back(row);
  return rows;
}

bool is_error(const std::string& name) {
  return name.find("error") != std::string::npos || name.find("departure") != std::string::npos ||
         name.find("deviation") != std::string::npos;
}

// Between the outcome and the work stand the metrics.
std::vector<const Column*> shown_metrics(const Record& table) {
  std::vector<const Column*> metrics;
  bool inside = false;
  for (const Column& column : table.columns) {
    if (column.name == "node_updates") break;
    if (inside) metrics.push_back(&column);
    if (column.name == "outcome") inside = true;
  }
  std::stable_partition(metrics.begin(), metrics.end(), [](const Column* c) { return is_error(c->name); });
  if (metrics.size() > most_metrics) metrics.resize(most_metrics);
  return metrics;
}

void print_rows(const Record& table, const Record* cost, const std::vector<const Column*>& metrics) {
  std::vector<const Column*> columns;
  for (const Column& column : table.columns) {
    columns.push_back(&column);
    if (column.name == "outcome") break;
  }
  columns.insert(columns.end(), metrics.begin(), metrics.end());
  if (cost != nullptr) columns.push_back(cost->find("wall_seconds"));
  print_columns(columns, all_rows(table));
}

void print_orders(const Record& orders, const std::vector<const Column*>& metrics) {
  std::vector<std::size_t> rows;
  for (const std::size_t row : all_rows(orders)) {
    const std::string& metric = orders.find("metric")->texts[row];
    const bool shown =
        std::any_of(metrics.begin(), metrics.end(), [&](const Column* c) { return c->name == metric; });
    // What does not follow the axis, or not from coarse to fine, is left to the result.
    const bool converges = std::isfinite(orders.find("order_of_differences")->values[row]);
    const bool is_falling = is_error(metric) && std::isfinite(orders.find("order")->values[row]);
    if (shown && (converges || is_falling)) rows.push_back(row);
  }
  if (rows.empty()) return;
  std::vector<const Column*> columns;
  for (const Column& column : orders.columns) columns.push_back(&column);
  say("        {}\n", orders.title);
  print_columns(columns, rows);
}

}  // namespace

void print_study(const observe::Observations& seen) {
  if (const Record* boundary = seen.record("outcome_boundary")) {
    std::vector<const Column*> columns;
    for (const Column& column : boundary->columns) columns.push_back(&column);
    print_columns(columns, all_rows(*boundary));
  }
  for (const std::string name : {"sweep", "ablate"}) {
    const Record* table = seen.record(name);
    if (table == nullptr) continue;
    const std::vector<const Column*> metrics = shown_metrics(*table);
    print_rows(*table, seen.record(name + "_cost"), metrics);
    for (const Record& record : seen.records) {
      if (record.name.starts_with("orders_along_")) print_orders(record, metrics);
    }
  }
}

}  // namespace veriflex
