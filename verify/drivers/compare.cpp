// The solid against tables that another program computed.

#include <string>
#include <vector>

#include "drivers/compare/kinds.hpp"
#include "drivers/drivers.hpp"

namespace veriflex::drivers {

engine::Study read_compare(const io::Section& top) {
  const io::Section section = top.table("compare");
  const std::vector<std::string> kinds{"bond-table", "angle-table", "node-forces",
                                       "tensile",    "cantilever",  "trajectory"};
  const std::string kind = section.choice("kind", kinds);
  if (kind == "bond-table") return compare::read_bond_table(top, section);
  if (kind == "angle-table") return compare::read_angle_table(top, section);
  if (kind == "node-forces") return compare::read_node_forces(top, section);
  if (kind == "tensile") return compare::read_tensile_table(top, section);
  if (kind == "cantilever") return compare::read_cantilever(top, section);
  return compare::read_trajectory(top, section);
}

}  // namespace veriflex::drivers
