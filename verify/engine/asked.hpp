/// What a check asks of a study: a number of many runs of a case, not of one.
#pragma once

#include <optional>
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
  double order;        // of richardson and gci, where it is known; else 0
  std::string across;  // the axis of a curve of such numbers, one for each of its values; else empty
  Pinned where;        // which rows
  Pinned over;         // of a ratio: the row of its denominator, as far as it differs from `where`

  /// `order(viscosity_error) along wave.nodes at fluid.relaxation_time = 0.6`: what the number is called in
  /// results.
  std::string name() const;
};

/// value, min, max, mean, order, richardson, gci, exponent, ratio.
const std::vector<std::string>& numbers_of_studies();

/// Of a `[[check]]` with `metric`, and `of` (default: value), `along`, `where`, `over`; or of one with
/// `curve` and `of`, whose `y` is the metric and whose `x` the axis across. Throws InputError.
Asked read_asked(const io::Table& check);

/// The grid convergence index of the values that a check asks for, along the axis that its `uncertainty`
/// names with `gci_along`, of order `gci_order` where that is known; nothing where it names none, or asks for
/// anything but a value or a limit.
std::optional<Asked> read_asked_gci(const io::Table& check);

/// Whether a check asks for a curve of numbers of a study, not for a column of a record.
bool is_curve_of_numbers(const io::Table& check);

/// `relaxation_time` of `fluid.relaxation_time`: what such a curve's x is called.
std::string last_part(const std::string& path);

}  // namespace veriflex::engine
