#include "engine/convergence.hpp"

#include <cmath>
#include <limits>

#include "base/interval.hpp"
#include "base/mutant.hpp"
#include "base/root.hpp"

namespace veriflex::engine {

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr Interval sought{0.05, 20.0};  // orders

// p with (f_0 - f_1)/(f_1 - f_2) = (h_0^p - h_1^p)/(h_1^p - h_2^p); the right side rises with p.
double order_of_three(const double* h, const double* f) {
  const double wanted = (f[0] - f[1]) / (f[1] - f[2]);
  const double r = h[0] / h[1], s = h[2] / h[1];
  const auto excess = [&](double p) {
    return std::log((std::pow(r, p) - 1.0) / (1.0 - std::pow(s, p))) - std::log(wanted);
  };
  const bool monotonic = wanted > 0.0 && std::isfinite(wanted);
  if (!monotonic || excess(sought.lo) > 0.0 || excess(sought.hi) < 0.0) return not_a_number;
  return bracketed_root(excess, sought.lo, sought.hi);
}

// f - f_0 of the finest grid.
double beyond_limit(const std::vector<double>& spacing, const std::vector<double>& value, double order) {
  const std::size_t last = value.size() - 1;
  const double ratio =
      std::pow(spacing[last - 1] / spacing[last], planted(Mutant::richardson_of_first_order) ? 1.0 : order);
  return (value[last - 1] - value[last]) / (ratio - 1.0);
}

}  // namespace

std::vector<double> orders(const std::vector<double>& spacing, const std::vector<double>& error) {
  std::vector<double> order;
  for (std::size_t i = 1; i < error.size(); ++i) {
    const bool known = error[i] > 0.0 && error[i - 1] > 0.0;
    order.push_back(known
                        ? std::log(error[i - 1] / error[i]) / std::log(planted(Mutant::order_of_swapped_grids)
                                                                           ? spacing[i] / spacing[i - 1]
                                                                           : spacing[i - 1] / spacing[i])
                        : not_a_number);
  }
  return order;
}

Convergence converge(const std::vector<double>& spacing, const std::vector<double>& value) {
  Convergence found{};
  for (std::size_t i = 2; i < value.size(); ++i) {
    found.order.push_back(order_of_three(&spacing[i - 2], &value[i - 2]));
  }
  const double rest = beyond_limit(spacing, value, found.order.back());
  found.richardson = value.back() - rest;
  found.gci = (planted(Mutant::gci_without_safety) ? 1.0 : 1.25) * std::abs(rest);
  return found;
}

double richardson(const std::vector<double>& spacing, const std::vector<double>& value, double order) {
  return value.back() - beyond_limit(spacing, value, order);
}

double gci(const std::vector<double>& spacing, const std::vector<double>& value, double order) {
  return 3.0 * std::abs(beyond_limit(spacing, value, order));
}

PowerLaw power_law(const std::vector<double>& x, const std::vector<double>& value) {
  const auto n = static_cast<double>(x.size());
  double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double a = std::log(x[i]), b = std::log(value[i]);
    sx += a;
    sy += b;
    sxx += a * a;
    sxy += a * b;
  }
  const double exponent = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return {exponent, std::exp((sy - exponent * sx) / n)};
}

}  // namespace veriflex::engine
