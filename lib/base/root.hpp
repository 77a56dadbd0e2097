/// One-dimensional root, minimum and derivative by GSL, behind plain functions.
#pragma once

#include <functional>

namespace veriflex {

using Function = std::function<double(double)>;

/// The root of f in [lo, hi] by Brent's method, iterated until the bracket no longer shrinks in double
/// precision. f(lo) and f(hi) must differ in sign (either may be zero). Throws NumericalFailure when they do
/// not, or when f is not finite inside.
double bracketed_root(const Function& f, double lo, double hi);

/// Where f is least in [lo, hi], by Brent's method, given an interior point `guess` with f(guess) below both
/// ends.
double bracketed_minimum(const Function& f, double lo, double guess, double hi);

struct Derivative {
  double value;
  double error;  // GSL's own estimate of the absolute error
};

/// f'(x) by GSL's adaptive central difference of width h.
Derivative central_derivative(const Function& f, double x, double h);

}  // namespace veriflex
