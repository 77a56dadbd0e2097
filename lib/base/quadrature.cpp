#include "base/quadrature.hpp"

#include <gsl/gsl_integration.h>

#include <cmath>
#include <memory>

#include "base/error.hpp"
#include "base/mutant.hpp"

namespace veriflex {

double integral(const Function& f, double a, double b) {
  const std::unique_ptr<gsl_integration_glfixed_table, void (*)(gsl_integration_glfixed_table*)> rule(
      gsl_integration_glfixed_table_alloc(planted(Mutant::quadrature_of_four_points) ? 4 : 512),
      &gsl_integration_glfixed_table_free);
  gsl_function wrapped{[](double x, void* g) { return (*static_cast<const Function*>(g))(x); },
                       const_cast<Function*>(&f)};
  const double value = gsl_integration_glfixed(&wrapped, a, b, rule.get());
  if (!std::isfinite(value)) throw NumericalFailure("an integral is not finite", FailureMode::NotFinite);
  return value;
}

}  // namespace veriflex
