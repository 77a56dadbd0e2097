/// Integral of a smooth function by GSL.
#pragma once

#include "base/root.hpp"

namespace veriflex {

/// Integral of f from a to b by Gauss-Legendre quadrature with 512 points, which does not evaluate the ends.
/// For functions that are smooth inside; near the ends they may lose digits. Throws NumericalFailure when the
/// result is not finite.
double integral(const Function& f, double a, double b);

}  // namespace veriflex
