/// Errors of a field against the exact one.
#pragma once

#include <span>
#include <string>

#include "base/reduce.hpp"
#include "observe/record.hpp"

namespace veriflex::measures {

struct Norms {
  double l1, l2, linf;  // relative to the same norm of the exact values
};

/// Sums over values as they are known: one number, or the magnitude of a vector.
class NormSums {
 public:
  void add(double error, double exact) {
    error_.add(error);
    exact_.add(exact);
  }
  Norms relative() const;
  double exact_l2() const;  // of the exact values alone

 private:
  struct Sums {
    double l1 = 0.0, squares = 0.0, linf = 0.0;
    void add(double value);
  };
  Sums error_, exact_;
};

/// Of values against exact ones.
Norms error_norms(std::span<const double> measured, std::span<const double> exact);

/// The metrics error_<name>l1, error_<name>l2 and error_<name>linf of what `whose` says.
std::vector<observe::Metric> norm_metrics(const std::string& name, const std::string& whose);
void set_norms(observe::Observations& seen, const std::string& name, const Norms& norms);

}  // namespace veriflex::measures
