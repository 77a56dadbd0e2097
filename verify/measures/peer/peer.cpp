// The solid against tables that another program computed.

#include <string>
#include <vector>

#include "measures/drivers.hpp"
#include "measures/peer/kinds.hpp"

namespace veriflex::measures {

engine::Study read_peer(const io::Table& top) {
  const io::Table table = top.table("peer");
  const std::vector<std::string> kinds{"bond-table", "angle-table", "node-forces",
                                       "tensile",    "cantilever",  "trajectory"};
  const std::string kind = table.choice("kind", kinds);
  if (kind == "bond-table") return peer::read_bond_table(top, table);
  if (kind == "angle-table") return peer::read_angle_table(top, table);
  if (kind == "node-forces") return peer::read_node_forces(top, table);
  if (kind == "tensile") return peer::read_tensile_table(top, table);
  if (kind == "cantilever") return peer::read_cantilever(top, table);
  return peer::read_trajectory(top, table);
}

}  // namespace veriflex::measures
