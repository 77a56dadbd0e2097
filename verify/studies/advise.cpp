#include "studies/advise.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gsl/gsl_multifit_nlinear.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <set>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "base/reduce.hpp"
#include "studies/grid.hpp"

namespace veriflex::studies {

namespace {

using observe::Column;
using Point = std::vector<double>;  // where the axes of numbers stand

constexpr double trusted = 2.0;  // factor within which left-out rows must be predicted

// Rows that differ in numbers only.
struct Family {
  std::vector<std::string> words;  // of the axes of words
  std::vector<Point> points;
  std::vector<double> error, seconds, memory;
  std::vector<bool> completed;
  std::vector<std::size_t> rows;  // of the sweep
};

// What a power law can be in: of a relaxation time the part that is viscosity.
double variable(const std::string& axis, double value) {
  return axis.ends_with("relaxation_time") && !planted(Mutant::advice_by_tau) ? value - 0.5 : value;
}
double value_of(const std::string& axis, double variable) {
  return axis.ends_with("relaxation_time") ? variable + 0.5 : variable;
}

std::vector<const Column*> numeric(const SweptRows& rows) {
  std::vector<const Column*> axes;
  for (const Column& axis : rows.axes)
    if (axis.texts.empty()) axes.push_back(&axis);
  return axes;
}

std::vector<Family> families(const SweptRows& rows) {
  std::vector<Family> all;
  for (std::size_t i = 0; i < rows.error.size(); ++i) {
    std::vector<std::string> words;
    Point point;
    for (const Column& axis : rows.axes) {
      if (axis.texts.empty()) {
        point.push_back(variable(axis.name, axis.values[i]));
      } else {
        words.push_back(axis.texts[i]);
      }
    }
    auto family = std::find_if(all.begin(), all.end(), [&](const Family& f) { return f.words == words; });
    if (family == all.end()) {
      all.push_back({words, {}, {}, {}, {}, {}, {}});
      family = all.end() - 1;
    }
    family->rows.push_back(i);
    family->points.push_back(point);
    family->error.push_back(rows.error[i]);
    family->seconds.push_back(rows.seconds[i]);
    family->memory.push_back(rows.memory[i]);
    family->completed.push_back(std::isfinite(rows.error[i]) && rows.error[i] > 0.0 && rows.seconds[i] > 0.0);
  }
  return all;
}

// A positive quantity of a point, with parameters.
using Law = std::function<double(const Eigen::VectorXd& parameters, const Point&)>;

// exp(p) of a parameter, so that what it stands for is positive; sums and products of some stay finite.
double positive(double parameter) { return std::exp(std::clamp(parameter, -300.0, 300.0)); }

double term(const Eigen::VectorXd& p, const Point& x, std::size_t axis) {
  const auto at = static_cast<Eigen::Index>(2 * axis);
  return positive(p[at] - p[at + 1] * std::log(x[axis]));
}

// What no axis lowers, B, is the last parameter of an odd number of them; of an even number there is none.
double floor_of(const Eigen::VectorXd& p) { return p.size() % 2 == 1 ? positive(p[p.size() - 1]) : 0.0; }

double error_law(const Eigen::VectorXd& p, const Point& x) {
  double sum = floor_of(p);
  for (std::size_t axis = 0; axis < x.size(); ++axis) sum += term(p, x, axis);
  return sum;
}

double time_law(const Eigen::VectorXd& p, const Point& x) {
  double exponent = p[0];
  for (std::size_t axis = 0; axis < x.size(); ++axis)
    exponent += p[static_cast<Eigen::Index>(axis + 1)] * std::log(x[axis]);
  return positive(exponent) + positive(p[p.size() - 1]);
}

struct Fitted {
  Eigen::VectorXd parameters;
  double misfit;  // sum of squared logarithms
};

// Least squares of the logarithms by GSL's Levenberg-Marquardt method, from this start.
Fitted fit(const Law& law, const std::vector<Point>& points, const std::vector<double>& values,
           const Eigen::VectorXd& start) {
  struct Problem {
    const Law& law;
    const std::vector<Point>& points;
    const std::vector<double>& values;
  } problem{law, points, values};
  gsl_multifit_nlinear_fdf residuals{};
  residuals.f = [](const gsl_vector* p, void* given, gsl_vector* r) {
    const auto& of = *static_cast<const Problem*>(given);
    const Eigen::VectorXd parameters = Eigen::Map<const Eigen::VectorXd, 0, Eigen::InnerStride<>>(
        p->data, static_cast<Eigen::Index>(p->size),
        Eigen::InnerStride<>(static_cast<Eigen::Index>(p->stride)));
    for (std::size_t i = 0; i < of.points.size(); ++i)
      gsl_vector_set(r, i, std::log(of.law(parameters, of.points[i]) / of.values[i]));
    return static_cast<int>(GSL_SUCCESS);
  };
  residuals.n = points.size();
  residuals.p = static_cast<std::size_t>(start.size());
  residuals.params = &problem;
  gsl_multifit_nlinear_parameters settings = gsl_multifit_nlinear_default_parameters();
  const std::unique_ptr<gsl_multifit_nlinear_workspace, decltype(&gsl_multifit_nlinear_free)> solver(
      gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &settings, residuals.n, residuals.p),
      &gsl_multifit_nlinear_free);
  const gsl_vector_const_view from = gsl_vector_const_view_array(start.data(), residuals.p);
  gsl_multifit_nlinear_init(&from.vector, &residuals, solver.get());
  int why = 0;
  constexpr std::size_t most_steps = 200;
  gsl_multifit_nlinear_driver(most_steps, 1e-10, 1e-10, 0.0, nullptr, nullptr, &why, solver.get());
  Fitted found{start, 0.0};
  for (std::size_t i = 0; i < residuals.p; ++i)
    found.parameters[static_cast<Eigen::Index>(i)] = gsl_vector_get(solver->x, i);
  const double norm =
      Eigen::Map<const Eigen::VectorXd>(solver->f->data, static_cast<Eigen::Index>(points.size())).norm();
  found.misfit = norm * norm;
  return found;
}

std::size_t parameters_of(std::size_t axes, bool has_floor) { return 2 * axes + (has_floor ? 1 : 0); }

// So that both laws can be fitted with a row left out; that of the time has a parameter per axis and two
// more.
std::size_t least_rows(std::size_t axes, bool has_floor) {
  return std::max(parameters_of(axes, has_floor), axes + 2) + 1;
}

// From several starts the best: each axis may be what the error comes from.
Eigen::VectorXd fit_error(const std::vector<Point>& points, const std::vector<double>& values,
                          bool has_floor) {
  const std::size_t axes = points.front().size();
  const double most = *std::max_element(values.begin(), values.end());
  const double least = *std::min_element(values.begin(), values.end());
  Fitted best{{}, INFINITY};
  for (std::size_t main = 0; main < axes; ++main) {
    for (const double order : {1.0, 2.0, 4.0, -1.0}) {
      Eigen::VectorXd start(static_cast<Eigen::Index>(parameters_of(axes, has_floor)));
      for (std::size_t axis = 0; axis < axes; ++axis) {
        double first = points.front()[axis];
        for (const Point& x : points)
          first = order > 0.0 ? std::min(first, x[axis]) : std::max(first, x[axis]);
        const double share = axis == main ? 0.9 : 0.01;
        start[static_cast<Eigen::Index>(2 * axis)] = std::log(share * most) + order * std::log(first);
        start[static_cast<Eigen::Index>(2 * axis + 1)] = order;
      }
      if (has_floor) start[start.size() - 1] = std::log(0.1 * least);
      const Fitted found = fit(error_law, points, values, start);
      if (best.parameters.size() == 0 || found.misfit < best.misfit) best = found;
    }
  }
  return best.parameters;
}

Eigen::VectorXd fit_time(const std::vector<Point>& points, const std::vector<double>& values) {
  const std::size_t axes = points.front().size();
  Eigen::VectorXd start = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(axes + 2), 1.0);
  const double least = *std::min_element(values.begin(), values.end());
  start[start.size() - 1] = std::log(0.1 * least);
  start[0] = std::log(least);
  for (std::size_t axis = 0; axis < axes; ++axis) start[0] -= std::log(points.front()[axis]);
  return fit(time_law, points, values, start).parameters;
}

// Squared, in logarithms.
double distance(const Point& a, const Point& b) {
  double squares = 0.0;
  for (std::size_t axis = 0; axis < a.size(); ++axis) squares += std::pow(std::log(a[axis] / b[axis]), 2);
  return squares;
}

// By the law, times what it misses at the rows around: caches, threads and vectors of the machine make steps
// that no law of powers follows.
double time_at(const Eigen::VectorXd& of_time, const std::vector<Point>& points,
               const std::vector<double>& seconds, const Point& x) {
  double weights = 0.0, missed = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double away = distance(x, points[i]);
    if (away == 0.0) return seconds[i];
    const double weight = 1.0 / (away * away);
    weights += weight;
    missed += weight * std::log(seconds[i] / time_law(of_time, points[i]));
  }
  return time_law(of_time, x) * std::exp(missed / weights);
}

double factor(double a, double b) { return std::max(a / b, b / a); }

// Completed rows of a family, and its laws.
struct Model {
  std::vector<Point> points;
  std::vector<double> error, seconds;
  Eigen::VectorXd of_error, of_time;
  double error_factor = 1.0, time_factor = 1.0;  // worst of rows predicted from the others

  double time(const Point& x) const { return time_at(of_time, points, seconds, x); }
};

// With a floor, or without; nothing when the rows are too few.
std::optional<Model> model_of(const Family& family, bool has_floor) {
  Model model;
  for (std::size_t i = 0; i < family.points.size(); ++i) {
    if (!family.completed[i]) continue;
    model.points.push_back(family.points[i]);
    model.error.push_back(family.error[i]);
    model.seconds.push_back(family.seconds[i]);
  }
  const std::size_t axes = model.points.empty() ? 0 : model.points.front().size();
  if (axes == 0 || model.points.size() < least_rows(axes, has_floor)) return std::nullopt;
  model.of_error = fit_error(model.points, model.error, has_floor);
  model.of_time = fit_time(model.points, model.seconds);
  for (std::size_t left_out = 0; left_out < model.points.size(); ++left_out) {
    auto points = model.points;
    auto error = model.error, seconds = model.seconds;
    const auto at = static_cast<std::ptrdiff_t>(left_out);
    points.erase(points.begin() + at);
    error.erase(error.begin() + at);
    seconds.erase(seconds.begin() + at);
    const Point& x = model.points[left_out];
    const Eigen::VectorXd of_error = fit_error(points, error, has_floor);
    model.error_factor = worse(model.error_factor, factor(error_law(of_error, x), model.error[left_out]));
    model.time_factor =
        worse(model.time_factor,
              factor(time_at(fit_time(points, seconds), points, seconds, x), model.seconds[left_out]));
  }
  return model;
}

// That of both which predicts left-out rows better.
std::optional<Model> model_of(const Family& family) {
  std::optional<Model> with = model_of(family, true), without = model_of(family, false);
  if (!with || (without && !(with->error_factor <= without->error_factor))) return without;
  return with;
}

std::size_t nearest(const Family& family, const Point& x) {
  std::size_t best = 0;
  double least = INFINITY;
  for (std::size_t i = 0; i < family.points.size(); ++i) {
    const double away = distance(x, family.points[i]);
    if (away < least) {
      least = away;
      best = i;
    }
  }
  return best;
}

// At tau = 1 the fluid is stored as moments and errs otherwise: nothing beside it follows from there.
bool from_moments_alone(const std::string& axis, double x, double from, double to) {
  const double moments = variable(axis, 1.0);
  return axis.ends_with("relaxation_time") && x != moments && (from == moments || to == moments);
}

// Whether rows have so many values along each axis, less that of moments, as it takes to see a law.
std::vector<bool> axes_of_laws(const std::vector<const Column*>& axes, const Family& family) {
  constexpr std::size_t least_values = 3;
  std::vector<bool> all;
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    std::set<double> values;
    for (const Point& row : family.points) values.insert(row[axis]);
    if (axes[axis]->name.ends_with("relaxation_time")) values.erase(variable(axes[axis]->name, 1.0));
    all.push_back(values.size() >= least_values);
  }
  return all;
}

// Whether a point may be advised: every row at the corners of its cell of the grid has completed, and beyond
// the grid it lies where the error falls, so that a limit of stability is not stepped over, and the time
// rises: what were better and cheaper than all rows is the luck of some of them.
bool is_usable(const std::vector<const Column*>& axes, const std::vector<bool>& have_laws,
               const Family& family, const Model& model, const Point& x) {
  std::vector<std::pair<double, double>> cell;  // the grid's neighbours of x along each axis
  for (std::size_t axis = 0; axis < x.size(); ++axis) {
    double below = -INFINITY, above = INFINITY;
    for (const Point& row : family.points) {
      if (row[axis] <= x[axis]) below = std::max(below, row[axis]);
      if (row[axis] >= x[axis]) above = std::min(above, row[axis]);
    }
    if (below != x[axis] && !have_laws[axis]) return false;
    const double falls = model.of_error[static_cast<Eigen::Index>(2 * axis + 1)];
    const double rises = model.of_time[static_cast<Eigen::Index>(axis + 1)];
    if (std::isinf(above) && !(falls > 0.0 && rises > 0.0)) return false;
    if (std::isinf(below) && !(falls < 0.0 && rises < 0.0)) return false;
    const auto [from, to] =
        cell.emplace_back(std::isinf(below) ? above : below, std::isinf(above) ? below : above);
    if (from_moments_alone(axes[axis]->name, x[axis], from, to)) return false;
  }
  for (std::size_t i = 0; i < family.points.size(); ++i) {
    bool is_corner = true;
    for (std::size_t axis = 0; axis < x.size(); ++axis) {
      const double at = family.points[i][axis];
      is_corner = is_corner && (at == cell[axis].first || at == cell[axis].second);
    }
    if (is_corner && !family.completed[i]) return false;
  }
  return true;
}

constexpr double vector = 8.0;  // nodes of a row that one holds, of 16 in float

// Of a number that was not swept, by those around it or, beyond all, the two next to it.
double as_even_as_beside(const std::vector<double>& swept, double value) {
  if (swept.size() < 2) return std::max(1.0, std::round(value));
  const auto above = std::upper_bound(swept.begin() + 1, swept.end() - 1, value);
  return as_even(value, *(above - 1), *above, vector);
}

// Values to try along an axis, up to a factor of two beyond what was swept; whole numbers where all were.
std::vector<double> tries(const Column& axis) {
  std::vector<double> values;
  for (const double value : axis.values) values.push_back(variable(axis.name, value));
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  const std::vector<double> swept = values;
  const bool whole =
      std::all_of(axis.values.begin(), axis.values.end(), [](double v) { return v == std::round(v); });
  constexpr int count = 65;
  for (int i = 0; i < count; ++i) {
    const double value =
        0.5 * swept.front() * std::pow(4.0 * swept.back() / swept.front(), i / (count - 1.0));
    values.push_back(whole ? as_even_as_beside(swept, value) : value);
  }
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  return values;
}

void for_each_point(const std::vector<const Column*>& axes, const std::function<void(const Point&)>& use) {
  std::vector<std::vector<double>> values;
  for (const Column* axis : axes) values.push_back(tries(*axis));
  Point point(axes.size());
  const std::function<void(std::size_t)> along = [&](std::size_t axis) {
    if (axis == axes.size()) {
      use(point);
      return;
    }
    for (const double value : values[axis]) {
      point[axis] = value;
      along(axis + 1);
    }
  };
  along(0);
}

std::string limit_of(const Model& model, const std::vector<const Column*>& axes, const Point& x) {
  std::string name = "nothing";
  double most = floor_of(model.of_error);
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    const double part = term(model.of_error, x, axis);
    if (part <= most) continue;
    most = part;
    name = axes[axis]->name;
  }
  return name;
}

// Rows of the family that did not complete, the nearest two.
std::vector<std::string> failures_near(const std::vector<const Column*>& axes, const Family& family,
                                       const Point& x) {
  std::vector<std::pair<double, std::string>> all;
  for (std::size_t i = 0; i < family.points.size(); ++i) {
    if (family.completed[i] || family.error[i] == 0.0) continue;
    std::vector<std::string> words;
    for (std::size_t axis = 0; axis < axes.size(); ++axis)
      words.push_back(
          fmt::format("{}={:.6g}", axes[axis]->name, value_of(axes[axis]->name, family.points[i][axis])));
    all.emplace_back(distance(x, family.points[i]), fmt::format("{}", fmt::join(words, " ")));
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string> nearest_two;
  for (std::size_t i = 0; i < std::min<std::size_t>(2, all.size()); ++i) nearest_two.push_back(all[i].second);
  return nearest_two;
}

Advice advice_at(const SweptRows& rows, const Family& family, const Model& model, const Point& x) {
  const std::vector<const Column*> axes = numeric(rows);
  Advice advice{.setting = {},
                .error = error_law(model.of_error, x),
                .seconds = model.time(x),
                .memory = family.memory[nearest(family, x)],
                .is_within = true,
                .is_measured = false,
                .error_factor = model.error_factor,
                .time_factor = model.time_factor,
                .rows = model.points.size(),
                .failures = failures_near(axes, family, x),
                .limited_by = limit_of(model, axes, x)};
  std::size_t number = 0, word = 0;
  for (const Column& axis : rows.axes) {
    if (!axis.texts.empty()) {
      advice.setting.push_back(fmt::format("{}={}", axis.name, family.words[word++]));
      continue;
    }
    const double value = value_of(axis.name, x[number++]);
    const auto swept = std::find_if(axis.values.begin(), axis.values.end(),
                                    [&](double v) { return std::abs(v - value) <= 1e-12 * std::abs(v); });
    advice.setting.push_back(swept == axis.values.end() ? fmt::format("{}={:.6g}", axis.name, value)
                                                        : fmt::format("{}={}", axis.name, *swept));
    const auto [low, high] = std::minmax_element(axis.values.begin(), axis.values.end());
    if (value < *low || value > *high) advice.is_within = false;
  }
  return advice;
}

}  // namespace

SweptRows swept_rows(const observe::Record& sweep, const observe::Record& cost, const std::string& error) {
  SweptRows rows;
  rows.axes = axes_of(sweep);
  for (const double value : sweep.find(error)->values) rows.error.push_back(std::abs(value));
  rows.seconds = cost.find("min_wall_seconds")->values;  // whatever disturbs a run makes it longer
  rows.memory = cost.find("peak_memory_bytes")->values;
  return rows;
}

SweptRows only(const SweptRows& rows, const std::string& axis, const std::string& value) {
  const auto given = std::find_if(rows.axes.begin(), rows.axes.end(),
                                  [&](const Column& column) { return column.name == axis; });
  std::vector<std::string> names, values;
  for (const Column& column : rows.axes) names.push_back(column.name);
  SweptRows kept;
  for (const Column& column : rows.axes)
    kept.axes.push_back({column.name, column.symbol, column.dimension, column.meaning, {}});
  for (std::size_t i = 0; given != rows.axes.end() && i < rows.error.size(); ++i) {
    const std::string here = given->texts.empty() ? fmt::format("{}", given->values[i]) : given->texts[i];
    if (std::find(values.begin(), values.end(), here) == values.end()) values.push_back(here);
    if (here != value) continue;
    for (std::size_t a = 0; a < rows.axes.size(); ++a) {
      const Column& column = rows.axes[a];
      if (&column == &*given) {
        kept.axes[a].texts.push_back(value);
      } else if (column.texts.empty()) {
        kept.axes[a].values.push_back(column.values[i]);
      } else {
        kept.axes[a].texts.push_back(column.texts[i]);
      }
    }
    kept.error.push_back(rows.error[i]);
    kept.seconds.push_back(rows.seconds[i]);
    kept.memory.push_back(rows.memory[i]);
  }
  if (kept.error.empty()) {
    throw BadParameter("where", fmt::format("no row of the sweep has {}={}", axis, value),
                       given == rows.axes.end()
                           ? fmt::format("its axes are {}", fmt::join(names, ", "))
                           : fmt::format("this axis was swept over {}", fmt::join(values, ", ")),
                       "Name an axis and one of its values");
  }
  return kept;
}

namespace {

struct Search {
  Wanted wanted;
  std::optional<Advice> best, most_accurate, in_budget;
  std::size_t too_few = 0;  // combinations of words

  template <class Make>
  void consider(double error, double seconds, double safety, const Make& make) {
    if (!most_accurate || error < most_accurate->error) most_accurate = make();
    if (wanted.budget && seconds <= *wanted.budget && (!in_budget || error < in_budget->error))
      in_budget = make();
    if (error * safety <= wanted.error && (!best || seconds < best->seconds)) best = make();
  }
};

// The rows of one family, all axes of numbers but that with the most values taken as words.
SweptRows along_one_axis(const SweptRows& rows, const Family& family) {
  const auto count = [](const Column& axis) {
    return std::set<double>(axis.values.begin(), axis.values.end()).size();
  };
  const std::vector<const Column*> axes = numeric(rows);
  const Column* main = *std::max_element(
      axes.begin(), axes.end(), [&](const Column* p, const Column* q) { return count(*p) < count(*q); });
  SweptRows one;
  for (const Column& axis : rows.axes)
    one.axes.push_back({axis.name, axis.symbol, axis.dimension, axis.meaning, {}});
  for (const std::size_t row : family.rows) {
    for (std::size_t a = 0; a < rows.axes.size(); ++a) {
      const Column& axis = rows.axes[a];
      if (!axis.texts.empty()) {
        one.axes[a].texts.push_back(axis.texts[row]);
      } else if (&axis == main) {
        one.axes[a].values.push_back(axis.values[row]);
      } else {
        one.axes[a].texts.push_back(fmt::format("{}", axis.values[row]));
      }
    }
    one.error.push_back(rows.error[row]);
    one.seconds.push_back(rows.seconds[row]);
    one.memory.push_back(rows.memory[row]);
  }
  return one;
}

void search(const SweptRows& rows, Search& found) {
  const std::vector<const Column*> axes = numeric(rows);
  for (const Family& family : families(rows)) {
    const std::optional<Model> model = model_of(family);
    const bool is_trusted = model && model->error_factor <= trusted;
    const auto consider_rows = [&] {
      for (std::size_t i = 0; i < model->points.size(); ++i) {
        found.consider(model->error[i], model->seconds[i], 1.0, [&] {
          Advice row = advice_at(rows, family, *model, model->points[i]);
          row.error = model->error[i];
          row.is_measured = true;
          return row;
        });
      }
    };
    if (is_trusted) {
      consider_rows();
      const std::vector<bool> have_laws = axes_of_laws(axes, family);
      for_each_point(axes, [&](const Point& x) {
        if (distance(x, family.points[nearest(family, x)]) == 0.0 ||
            !is_usable(axes, have_laws, family, *model, x))
          return;
        found.consider(error_law(model->of_error, x), model->time(x), model->error_factor,
                       [&] { return advice_at(rows, family, *model, x); });
      });
      continue;
    }
    // Where the axes do not add up, each line along one of them may still follow a law of its own.
    if (axes.size() > 1) search(along_one_axis(rows, family), found);
    if (!model) {
      ++found.too_few;
      continue;
    }
    consider_rows();
  }
}

}  // namespace

Advice advise(const SweptRows& rows, const Wanted& wanted) {
  const std::vector<const Column*> axes = numeric(rows);
  for (const Column* axis : axes) {
    if (!std::all_of(axis->values.begin(), axis->values.end(),
                     [&](double v) { return variable(axis->name, v) > 0.0; }))
      throw NumericalFailure(
          fmt::format("the axis {} has values that are not positive: no power law", axis->name),
          FailureMode::NotConverged);
  }
  Search found{.wanted = wanted, .best = {}, .most_accurate = {}, .in_budget = {}};
  search(rows, found);
  if (!found.most_accurate) {
    throw NumericalFailure(
        fmt::format(
            "the sweep has too few completed rows for a fit: {} along {} axes of numbers need at least {} "
            "in each of {} combinations",
            rows.error.size(), axes.size(), least_rows(axes.size(), false), found.too_few),
        FailureMode::NotConverged);
  }
  if (!found.best) {
    throw NumericalFailure(
        fmt::format(
            "no setting up to a factor of two beyond the sweep is predicted to have an error of {:.3g}; "
            "the least is {:.3g} (times {:.3g} for what the fit is worth) at {}, limited by {}",
            wanted.error, found.most_accurate->error, found.most_accurate->error_factor,
            fmt::join(found.most_accurate->setting, " "), found.most_accurate->limited_by),
        FailureMode::NotConverged);
  }
  if (wanted.budget && found.best->seconds > *wanted.budget) {
    throw NumericalFailure(fmt::format("an error of {:.3g} takes {:.3g} s, more than {:.3g} s{}",
                                       wanted.error, found.best->seconds, *wanted.budget,
                                       found.in_budget ? fmt::format("; these buy an error of {:.3g} at {}",
                                                                     found.in_budget->error,
                                                                     fmt::join(found.in_budget->setting, " "))
                                                       : std::string()),
                           FailureMode::NotConverged);
  }
  return *found.best;
}

}  // namespace veriflex::studies
