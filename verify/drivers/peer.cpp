// The solid against tables that another program computed.

#include <string>
#include <vector>

#include "drivers/drivers.hpp"
#include "drivers/peer/kinds.hpp"

namespace veriflex::drivers {

engine::Study read_peer(const io::Section& top) {
  const io::Section section = top.table("peer");
  const std::vector<std::string> kinds{"bond-table", "angle-table", "node-forces",
                                       "tensile",    "cantilever",  "trajectory"};
  const std::string kind = section.choice("kind", kinds);
  if (kind == "bond-table") return peer::read_bond_table(top, section);
  if (kind == "angle-table") return peer::read_angle_table(top, section);
  if (kind == "node-forces") return peer::read_node_forces(top, section);
  if (kind == "tensile") return peer::read_tensile_table(top, section);
  if (kind == "cantilever") return peer::read_cantilever(top, section);
  return peer::read_trajectory(top, section);
}

}  // namespace veriflex::drivers
