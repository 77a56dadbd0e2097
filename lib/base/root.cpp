#include "base/root.hpp"

#include <fmt/format.h>
#include <gsl/gsl_deriv.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_min.h>
#include <gsl/gsl_roots.h>

#include <cmath>
#include <memory>

#include "base/error.hpp"
#include "base/mutant.hpp"

namespace veriflex {

namespace {

// GSL's default handler aborts the process; every status is looked at here instead.
[[maybe_unused]] const auto errors_are_returned = gsl_set_error_handler_off();

double call(double x, void* f) { return (*static_cast<const Function*>(f))(x); }

gsl_function wrap(const Function& f) { return {&call, const_cast<Function*>(&f)}; }

// Brent's method needs about 10 evaluations; bisection to the last bit needs about 60 for a bracket of
// ordinary width. Both are far below this.
constexpr int max_iterations = 400;

}  // namespace

double bracketed_root(const Function& f, double lo, double hi) {
  if (f(lo) == 0.0) return lo;
  if (f(hi) == 0.0) return hi;
  const std::unique_ptr<gsl_root_fsolver, void (*)(gsl_root_fsolver*)> solver(
      gsl_root_fsolver_alloc(gsl_root_fsolver_brent), &gsl_root_fsolver_free);
  gsl_function wrapped = wrap(f);
  int status = gsl_root_fsolver_set(solver.get(), &wrapped, lo, hi);
  for (int i = 0; status == GSL_SUCCESS && i < (planted(Mutant::root_stops_early) ? 3 : max_iterations);
       ++i) {
    const double a = gsl_root_fsolver_x_lower(solver.get());
    const double b = gsl_root_fsolver_x_upper(solver.get());
    if (a == b || std::nextafter(a, b) == b) break;
    const double before = gsl_root_fsolver_root(solver.get());
    status = gsl_root_fsolver_iterate(solver.get());
    if (f(gsl_root_fsolver_root(solver.get())) == 0.0) break;
    const bool same_bracket =
        a == gsl_root_fsolver_x_lower(solver.get()) && b == gsl_root_fsolver_x_upper(solver.get());
    if (same_bracket && before == gsl_root_fsolver_root(solver.get())) break;
  }
  if (status != GSL_SUCCESS) {
    throw NumericalFailure(fmt::format("no root found between {} and {} ({})", lo, hi, gsl_strerror(status)),
                           FailureMode::NotConverged);
  }
  return gsl_root_fsolver_root(solver.get());
}

double bracketed_minimum(const Function& f, double lo, double guess, double hi) {
  const std::unique_ptr<gsl_min_fminimizer, void (*)(gsl_min_fminimizer*)> minimizer(
      gsl_min_fminimizer_alloc(gsl_min_fminimizer_brent), &gsl_min_fminimizer_free);
  gsl_function wrapped = wrap(f);
  int status = gsl_min_fminimizer_set(minimizer.get(), &wrapped, guess, lo, hi);
  for (int i = 0; status == GSL_SUCCESS && i < max_iterations; ++i) {
    const double width =
        gsl_min_fminimizer_x_upper(minimizer.get()) - gsl_min_fminimizer_x_lower(minimizer.get());
    // Below the square root of the precision the values no longer differ.
    if (width <= 1e-9 * std::abs(gsl_min_fminimizer_x_minimum(minimizer.get()))) break;
    status = gsl_min_fminimizer_iterate(minimizer.get());
  }
  if (status != GSL_SUCCESS && status != GSL_FAILURE) {  // GSL_FAILURE: it cannot improve any more
    throw NumericalFailure(
        fmt::format("no minimum found between {} and {} ({})", lo, hi, gsl_strerror(status)),
        FailureMode::NotConverged);
  }
  return gsl_min_fminimizer_x_minimum(minimizer.get());
}

Derivative central_derivative(const Function& f, double x, double h) {
  gsl_function wrapped = wrap(f);
  Derivative derivative{};
  if (gsl_deriv_central(&wrapped, x, h, &derivative.value, &derivative.error) != GSL_SUCCESS ||
      !std::isfinite(derivative.value)) {
    throw NumericalFailure(fmt::format("no derivative at {} with width {}", x, h), FailureMode::NotConverged);
  }
  return derivative;
}

}  // namespace veriflex
