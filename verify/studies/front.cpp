#include "studies/front.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "base/mutant.hpp"
#include "studies/table.hpp"

namespace veriflex::studies {

namespace {

using observe::Column;
using observe::Record;
using Rows = std::vector<std::size_t>;

constexpr double unlimited = std::numeric_limits<double>::infinity();

Rows front_of(const std::vector<Priced>& rows, Rows among) {
  std::erase_if(among,
                [&](std::size_t i) { return !std::isfinite(rows[i].error) || !std::isfinite(rows[i].work); });
  std::stable_sort(among.begin(), among.end(), [&](std::size_t a, std::size_t b) {
    return rows[a].work != rows[b].work ? rows[a].work < rows[b].work : rows[a].error < rows[b].error;
  });
  Rows best;
  for (const std::size_t i : among) {
    if (best.empty() || planted(Mutant::front_keeps_the_beaten) || rows[i].error < rows[best.back()].error)
      best.push_back(i);
  }
  return best;
}

// The cheapest row of a front with at most that error.
std::optional<std::size_t> reaching(const std::vector<Priced>& rows, const Rows& front, double error) {
  for (const std::size_t i : front) {
    if (rows[i].error <= error) return i;
  }
  return std::nullopt;
}

Record front_record(const std::string& name, const PricedGrid& grid, const Rows& best) {
  Record record{name + "_front", "Settings that no other beats in both error and " + grid.work.name,
                columns_of(grid.axes)};
  Column error = grid.error, work = grid.work;
  for (const std::size_t i : best) {
    append(record.columns, grid.axes, grid.cells[i]);
    error.values.push_back(grid.rows[i].error);
    work.values.push_back(grid.rows[i].work);
  }
  record.columns.insert(record.columns.end(), {error, work});
  return record;
}

Record settings_record(const std::string& name, const PricedGrid& grid, const Rows& best) {
  Column axis{"axis", "", "1", "key of the case", {}};
  Column value{"value", "", "1", "what it is set to", {}};
  Column from{"cheapest_from", "", grid.error.dimension, "the smallest error asked for, and", {}};
  Column to{"cheapest_below", "", grid.error.dimension, "the largest, for which the cheapest has it", {}};
  Column over{"work_over_cheapest", "", "1", "of the best setting with it, where that is least", {}};
  for (std::size_t a = 0; a < grid.axes.size(); ++a) {
    for (std::size_t v = 0; v < grid.axes[a].size(); ++v) {
      const auto has_it = [&](std::size_t i) { return grid.cells[i][a] == v; };
      double low = not_a_number, high = not_a_number, least = unlimited;
      for (std::size_t k = 0; k < best.size(); ++k) {
        if (!has_it(best[k])) continue;
        if (std::isnan(high)) high = k == 0 ? unlimited : grid.rows[best[k - 1]].error;
        low = grid.rows[best[k]].error;
      }
      Rows with_it(grid.rows.size());
      std::iota(with_it.begin(), with_it.end(), std::size_t{0});
      std::erase_if(with_it, [&](std::size_t i) { return !has_it(i); });
      for (const std::size_t i : front_of(grid.rows, with_it)) {
        const std::size_t cheapest = *reaching(grid.rows, best, grid.rows[i].error);
        least = std::min(least, grid.rows[i].work / grid.rows[cheapest].work);
      }
      axis.texts.push_back(grid.axes[a].name());
      value.texts.push_back(bare(grid.axes[a].values[v].front()));
      from.values.push_back(low);
      to.values.push_back(high);
      over.values.push_back(std::isfinite(least) ? least : not_a_number);
    }
  }
  return {
      name + "_settings", "Which values are worth their " + grid.work.name, {axis, value, from, to, over}};
}

struct Step {
  std::string to;  // `key = value`; "nothing on this grid"
  double error = not_a_number, work = not_a_number;
};

// The row one step along one axis from this one whose error is least, if that is less.
Step best_step(const PricedGrid& grid, std::size_t row) {
  Step best{.to = "nothing on this grid", .error = grid.rows[row].error};
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    std::size_t changed = 0, axis = 0, distance = 0;
    for (std::size_t a = 0; a < grid.axes.size(); ++a) {
      const std::size_t here = grid.cells[row][a], there = grid.cells[i][a];
      if (here == there) continue;
      ++changed;
      axis = a;
      distance = here < there ? there - here : here - there;
    }
    if (changed != 1 || distance != 1 || !(grid.rows[i].error < best.error)) continue;
    const Axis& along = grid.axes[axis];
    best = {fmt::format("{} = {}", along.name(), bare(along.values[grid.cells[i][axis]].front())),
            grid.rows[i].error, grid.rows[i].work};
  }
  if (std::isnan(best.work)) best.error = not_a_number;
  return best;
}

Record reached_record(const std::string& name, const PricedGrid& grid, const Rows& best) {
  std::vector<Column> leading = columns_of(grid.axes);
  Column asked{"asked", "", grid.error.dimension, "error that is asked for", {}};
  Column error = grid.error, work = grid.work;
  Column step{"next_step", "", "1", "what lowers the error most from there, along one axis", {}};
  Column next_error = grid.error, next_work = grid.work;
  next_error.name = "next_" + next_error.name;
  next_work.name = "next_" + next_work.name;
  constexpr int usual = 4, most = 16;  // decades that are always asked for, and that may be
  for (int decade = 1; decade <= most; ++decade) {
    const double wanted = std::pow(10.0, -decade);
    const std::optional<std::size_t> row = reaching(grid.rows, best, wanted);
    if (!row) {
      if (decade > usual) break;
      continue;  // not reached on this grid
    }
    asked.values.push_back(wanted);
    append(leading, grid.axes, grid.cells[*row]);
    error.values.push_back(grid.rows[*row].error);
    work.values.push_back(grid.rows[*row].work);
    const Step next = best_step(grid, *row);
    step.texts.push_back(next.to);
    next_error.values.push_back(next.error);
    next_work.values.push_back(next.work);
  }
  Record record{name + "_reached",
                fmt::format("The cheapest setting by {} for an error that is asked for", grid.work.name),
                {asked}};
  record.columns.insert(record.columns.end(), leading.begin(), leading.end());
  record.columns.insert(record.columns.end(), {error, work, step, next_error, next_work});
  return record;
}

}  // namespace

Rows front(const std::vector<Priced>& rows) {
  Rows all(rows.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return front_of(rows, all);
}

std::vector<Record> front_records(const std::string& name, const PricedGrid& grid) {
  const Rows best = front(grid.rows);
  return {front_record(name, grid, best), settings_record(name, grid, best),
          reached_record(name, grid, best)};
}

}  // namespace veriflex::studies
