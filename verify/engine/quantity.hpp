/// A number of a case in lattice units and in units for people, and whether it is a good one.
#pragma once

#include <optional>
#include <string>

namespace veriflex::engine {

struct Quantity {
  std::string name, symbol;
  double lattice;
  std::optional<double> physical{};  // SI; a pure number has none
  std::string unit{};                // of that: "m/s"
  std::string fault{};               // why it lies outside of the good range, and
  std::string remedy{};              // what to change; both empty for a good one
};

}  // namespace veriflex::engine
