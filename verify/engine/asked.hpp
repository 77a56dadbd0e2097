/// What a check asks of a study: a number of many runs of a case, not of one.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "io/document.hpp"

namespace veriflex::engine {

/// Values of axes, as TOML text.
using Pinned = std::vector<std::pair<std::string, std::string>>;

struct Asked {
  std::string of;      // one of numbers_of_studies()
  std::string metric;  // a column of the study's table
  std::string along;   // the axis of an order, a limit or an exponent; else empty
  Pinned where;        // which rows
  Pinned over;         // of a ratio: the row of its denominator, as far as it differs from `where`

  /// `order(viscosity_error) along wave.nodes at fluid.relaxation_time = 0.6`: what the number is called in
  /// results.
  std::string name() const;
};

/// value, min, max, mean, order, richardson, gci, exponent, ratio.
const std::vector<std::string>& numbers_of_studies();

/// Of a `[[check]]` with `metric`, and `of` (default: value), `along`, `where`, `over`. Throws InputError.
Asked read_asked(const io::Table& check);

}  // namespace veriflex::engine
