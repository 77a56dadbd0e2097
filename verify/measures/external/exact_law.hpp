/// Exact laws y = f(x) that a column of somebody else's table can be held against, point by point.
#pragma once

#include <functional>
#include <string>

#include "base/interval.hpp"
#include "io/document.hpp"

namespace veriflex::measures::external {

struct ExactLaw {
  std::string name;
  std::string x_dimension, y_dimension;  // such as "L T^-1"; "1" for a pure number
  Interval domain;                       // of x, open
  std::function<double(double)> at;
};

/// The law that `exact.law` names, with its parameters; `bond-tension` is that of the case's [bond]. Throws
/// InputError.
ExactLaw read_exact_law(const io::Table& top, const io::Table& exact);

}  // namespace veriflex::measures::external
