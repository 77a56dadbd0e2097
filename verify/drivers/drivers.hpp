/// The kinds of study, each in a file of its own.
#pragma once

#include <vector>

#include "engine/study.hpp"

namespace veriflex::drivers {

/// Rest state, Young's modulus and validity range of a bond law.                 [wu-qi-2014, Eqs. 21-25]
engine::Study read_derive(const io::Section& top);

/// Static pull on a bar of the law's bonds: stress-strain curve and modulus at zero strain.
engine::Study read_tensile(const io::Section& top);

/// The solid against a table that another program computed.
engine::Study read_compare(const io::Section& top);

inline const std::vector<engine::Driver>& all() {
  static const std::vector<engine::Driver> drivers{
      {"derive", "rest state, Young's modulus and validity range of a bond law", &read_derive},
      {"compare", "the solid against a table that another program computed", &read_compare},
      {"tensile", "static pull on a bar: stress-strain curve and modulus at zero strain", &read_tensile},
  };
  return drivers;
}

}  // namespace veriflex::drivers
