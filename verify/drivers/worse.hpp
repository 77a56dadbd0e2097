#pragma once

#include <cmath>

namespace veriflex::drivers {

/// The larger of two errors; not a number when one of them is not, which std::max may lose.
inline double worse(double a, double b) { return std::isnan(a) || a >= b ? a : b; }

}  // namespace veriflex::drivers
