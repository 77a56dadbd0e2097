/// How fast a sequence of results converges with the spacing, and to what.
#pragma once

#include <vector>

namespace veriflex::engine {

/// Of errors against a known answer: the order between each grid and the next, log(e_i/e_i+1)/log(h_i/h_i+1).
/// Not a number where an error is zero. The spacings fall.
std::vector<double> orders(const std::vector<double>& spacing, const std::vector<double>& error);

/// Of values whose limit is not known, from grids three at a time: f = f_0 + C h^p.     [roache-1994;
/// celik-2008]
struct Convergence {
  std::vector<double>
      order;          // p of grids (i, i+1, i+2); not a number where they do not converge monotonically
  double richardson;  // f_0 from the two finest grids with the last order
  double gci;         // grid convergence index of the finest grid, in the unit of the value:
                      // 1.25 |f - f_0|, within which the limit is taken to lie
};

/// At least three grids, the spacings falling.
Convergence converge(const std::vector<double>& spacing, const std::vector<double>& value);

/// f_0 from the two finest grids, where p is known, and the grid convergence index of the finest: 3 |f -
/// f_0|,
/// for that the order is what the grids show is not seen.                                        [roache-1994]
double richardson(const std::vector<double>& spacing, const std::vector<double>& value, double order);
double gci(const std::vector<double>& spacing, const std::vector<double>& value, double order);

/// value = factor * x^exponent, by least squares of the logarithms. Everything must be positive.
struct PowerLaw {
  double exponent, factor;
};
PowerLaw power_law(const std::vector<double>& x, const std::vector<double>& value);

}  // namespace veriflex::engine
