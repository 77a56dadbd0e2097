#include "measures/fluid/norms.hpp"

#include <cmath>

#include "base/mutant.hpp"

namespace veriflex::measures {

void NormSums::Sums::add(double value) {
  l1 += std::abs(value);
  squares += value * value;
  linf = worse(linf, std::abs(value));
}

Norms NormSums::relative() const {
  return {relative_to(error_.l1, exact_.l1),
          relative_to(planted(Mutant::norm_of_squares) ? error_.squares : std::sqrt(error_.squares),
                      std::sqrt(exact_.squares)),
          relative_to(error_.linf, exact_.linf)};
}

double NormSums::exact_l2() const { return std::sqrt(exact_.squares); }

Norms error_norms(std::span<const double> measured, std::span<const double> exact) {
  NormSums sums;
  for (std::size_t i = 0; i < exact.size(); ++i) sums.add(measured[i] - exact[i], exact[i]);
  return sums.relative();
}

std::vector<observe::Metric> norm_metrics(const std::string& name, const std::string& whose) {
  return {{"error_" + name + "l1", {}, "1", "mean error of " + whose + " over its mean magnitude"},
          {"error_" + name + "l2", {}, "1", "root mean square error of " + whose + " over that of itself"},
          {"error_" + name + "linf", {}, "1", "largest error of " + whose + " over its largest magnitude"}};
}

void set_norms(observe::Observations& seen, const std::string& name, const Norms& norms) {
  seen.set("error_" + name + "l1", norms.l1);
  seen.set("error_" + name + "l2", norms.l2);
  seen.set("error_" + name + "linf", norms.linf);
}

}  // namespace veriflex::measures
